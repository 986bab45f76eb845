// The distance to equilibrium that every step states (sim/fem/solver/distance_estimate.h), against the true one.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/operating_point/cpu_clock.h"
#include "app/program/places.h"
#include "app/scene/scene.h"
#include "sim/base/error.h"
#include "sim/commands/script.h"
#include "sim/fem/model/box_model.h"
#include "sim/fem/solver/elastic_solver.h"
#include "sim/patient/soft_tissue.h"
#include "sim/patient/world.h"
#include "tests/bench/verification_parts.h"

namespace limberg::bench {
namespace {

/// Frames after one disturbance: what each stated, where it was, and where it all ended.
class Watch {
 public:
  void frame(const ElasticSolver& s, const StepReport& r) {
    u_.emplace_back(s.displacement_mm().begin(), s.displacement_mm().end());
    stated_.push_back(r.distance_mm);
  }
  /// Ratios stated / true of the frames that were farther off than 1e-3 mm and 20 times what the end itself may be off.
  void end(std::vector<double>& ratios) {
    if (!u_.empty()) {
      const double floor = std::max(1e-3, 20 * stated_.back());
      for (size_t k = 0; k + 1 < u_.size(); ++k) {
        if (u_[k].size() != u_.back().size()) continue;
        float most = 0;
        for (size_t i = 0; i < u_[k].size(); ++i) most = std::max(most, (u_[k][i] - u_.back()[i]).squaredNorm());
        const double truth = std::sqrt(double(most));
        if (truth > floor) ratios.push_back(stated_[k] / truth);
      }
    }
    u_.clear(), stated_.clear();
  }

 private:
  std::vector<std::vector<Vec3f>> u_;
  std::vector<double> stated_;
};

void report(Result& out, const std::string& name, const std::vector<double>& ratios, double ms) {
  Times r, off;  // of logarithms, not of times
  for (const double x : ratios) r.add(std::log(std::max(x, 1e-9))), off.add(std::fabs(r.ms.back()));
  const std::string how =
      fmt::format("{} frames; stated / true: median {:.2f}, 5 % below {:.2f}, 5 % above {:.2f}", ratios.size(),
                  std::exp(r.percentile(0.5)), std::exp(r.percentile(0.05)), std::exp(r.percentile(0.95)));
  const double factor = std::exp(off.percentile(0.9));
  out.rows.push_back({"live error", name, how, ms, false, factor, "x", "the state that the frames lead to", true});
  at_most(out, "live error, " + name + ": nine frames of ten within a factor of", factor, 4,
          "stated in distance_estimate.h: 3 on the set that it was made from");
}

}  // namespace

void live_error(Result& out, const VerificationSettings& set) {
  InlineWorkers workers;
  uint32_t seed = 77;
  const auto random = [&] {
    return (seed = seed * 1664525u + 1013904223u), 2 * double(seed >> 8) / double(1 << 24) - 1;
  };
  std::vector<double> ratios;
  double before = cpu_ms();
  for (double nu : {0.45, 0.49})
    for (int iterations : set.quick ? std::vector<int>{10} : std::vector<int>{5, 10, 20}) {
      BenchScene s = bench_scene(24, 2, nu);
      const auto solver = make_solver(workers);
      solver->set_model(std::make_shared<FemModel>(s.model), {});
      const Vec3 rest = s.springs.back().target_mm;
      for (int pull = 0; pull < 4; ++pull) {
        s.springs.back().target_mm = rest + (pull % 2 ? 4 : 25) * Vec3(random(), random(), std::fabs(random()));
        solver->set_springs(s.springs);
        Watch watch;
        StepSettings step;
        step.max_iterations = iterations, step.tolerance = 2e-6;
        for (int k = 0; k < 60; ++k) {
          const StepReport r = solver->step(step);
          watch.frame(*solver, r);
          if (r.converged) break;
        }
        watch.end(ratios);
      }
    }
  report(out, "random pulls of 4 and 25 mm", ratios, cpu_ms() - before);

  for (const std::string name : {"rhomboid", "zplasty"}) {
    ratios.clear(), before = cpu_ms();
    try {
      const Scene scene = load_scene(find_scene(name, {"app/scenes", source_dir() + "/app/scenes"}));
      const Script script = load_script(source_dir() + "/recordings/" + name + ".jsonl");
      WorldSpec spec = world_spec(scene, build_body(scene));
      spec.cell_mm = 5;
      World world(spec, workers);
      StepSettings step;
      step.max_iterations = 10, step.tolerance = 8e-6;
      size_t lines = 0;
      for (const ScriptLine& l : script.lines) {
        if (set.quick && ++lines > 12) break;
        world.apply(l.command);
        if (std::holds_alternative<Stage>(l.command)) continue;
        Watch watch;
        for (int k = 0; k < 60; ++k) {
          const bool settled = world.settled();
          const StepReport r = world.step(step);
          if (settled) watch.frame(world.skin()->solver(), r);
          if (r.converged && world.settled()) break;
        }
        watch.end(ratios);
      }
      report(out, "shipped script " + name + ", 5 mm cells", ratios, cpu_ms() - before);
    } catch (const InputError& e) {
      out.notes.push_back("live error: the shipped scene " + name + " was not found (" + e.what() + ")");
    }
  }
}

}  // namespace limberg::bench
