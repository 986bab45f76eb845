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

std::vector<Vec3f> seen_mm(const ElasticSolver& s, const SharedArray<EmbeddedPoint>& surface) {
  std::vector<Vec3f> out;
  out.reserve(surface.size());
  for (const EmbeddedPoint& p : surface) out.push_back(s.position_mm(p).cast<float>());
  return out;
}

double farthest_mm(std::span<const Vec3f> a, std::span<const Vec3f> b) {
  float most = 0;
  for (size_t i = 0; i < a.size(); ++i) most = std::max(most, (a[i] - b[i]).squaredNorm());
  return std::sqrt(double(most));
}

}  // namespace

void LiveFrames::add(const ElasticSolver& s, const StepReport& r, const SharedArray<EmbeddedPoint>& surface) {
  u_.emplace_back(s.displacement_mm().begin(), s.displacement_mm().end());
  seen_mm_.push_back(seen_mm(s, surface));
  stated_mm_.push_back(r.distance_mm);
}

void LiveFrames::end(const ElasticSolver& s, LiveRatios& ratios, const SharedArray<EmbeddedPoint>& surface) {
  constexpr double kKnown_mm = 2e-3;  // what a residual of 2e-6 leaves open, several times
  const std::span<const Vec3f> rest = s.displacement_mm();
  const std::vector<Vec3f> seen = seen_mm(s, surface);
  for (size_t k = 0; k < u_.size(); ++k) {
    if (u_[k].size() != rest.size() || seen_mm_[k].size() != seen.size()) continue;
    if (const double truth = farthest_mm(u_[k], rest); truth > kKnown_mm) ratios.nodes.push_back(stated_mm_[k] / truth);
    if (const double truth = farthest_mm(seen_mm_[k], seen); truth > kKnown_mm)
      ratios.seen.push_back(stated_mm_[k] / truth);
  }
  u_.clear(), seen_mm_.clear(), stated_mm_.clear();
}

bool comes_to_rest(const std::function<StepReport(const StepSettings&)>& step) {
  StepSettings to_rest;
  to_rest.max_iterations = 100, to_rest.tolerance = 2e-6;
  StepReport r;
  for (int k = 0; k < 80 && !r.converged; ++k) r = step(to_rest);
  return r.residual <= 10 * to_rest.tolerance;
}

void report_live(Result& out, const std::string& name, std::vector<double> ratios, double ms) {
  if (ratios.empty()) return;
  std::sort(ratios.begin(), ratios.end());
  const auto at = [&](double share) { return ratios[size_t(share * double(ratios.size() - 1))]; };
  const double below =
      100. * double(std::lower_bound(ratios.begin(), ratios.end(), 1. / 3) - ratios.begin()) / double(ratios.size());
  const std::string how = fmt::format("{} frames; stated / true: least {:.2f}, 1 % below {:.2f}, 10 % above {:.1f}",
                                      ratios.size(), ratios.front(), at(0.01), at(0.9));
  out.rows.push_back({"live error", name, how, ms, false, at(0.5), "x", "the state that the frames lead to", true});
  at_most(out, "live error, " + name + ": frames more than three times farther off than they state (%)", below, 0,
          "an honest distance is never less than a third of the truth");
  at_most(out, "live error, " + name + ": stated over true, median", at(0.5), 5, "nor at the median five times it");
}

void report_live(Result& out, const std::string& name, const LiveRatios& ratios, double ms) {
  report_live(out, name + ", nodes", ratios.nodes, ms);
  report_live(out, name + ", what is seen", ratios.seen, 0);
}

void live_error(Result& out, const VerificationSettings& set) {
  InlineWorkers workers;
  uint32_t seed = 77;
  const auto random = [&] {
    return (seed = seed * 1664525u + 1013904223u), 2 * double(seed >> 8) / double(1 << 24) - 1;
  };
  LiveRatios ratios;
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
        LiveFrames watch;
        StepSettings step;
        step.max_iterations = iterations, step.tolerance = 2e-6;
        for (int k = 0; k < 60; ++k) {
          const StepReport r = solver->step(step);
          watch.add(*solver, r);
          if (r.converged) break;
        }
        if (comes_to_rest([&](const StepSettings& to) { return solver->step(to); })) watch.end(*solver, ratios);
      }
    }
  report_live(out, "random pulls of 4 and 25 mm", ratios, cpu_ms() - before);

  struct Operation {
    std::string scene, script;
  };
  for (const auto& [name, acts] : {Operation{"rhomboid", "rhomboid"}, {"zplasty", "zplasty"}, {"cheek", "rhomboid"}}) {
    ratios = {}, before = cpu_ms();
    try {
      const Scene scene = load_scene(find_scene(name, {"app/scenes", source_dir() + "/app/scenes"}));
      const Script script = load_script(source_dir() + "/recordings/" + acts + ".jsonl");
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
        LiveFrames watch;
        for (int k = 0; k < 60; ++k) {
          const bool settled = world.settled();
          const StepReport r = world.step(step);
          if (settled) watch.add(world.skin()->solver(), r, world.skin()->topology()->embedding);
          if (r.converged && world.settled()) break;
        }
        if (comes_to_rest([&](const StepSettings& to) { return world.step(to); }))
          watch.end(world.skin()->solver(), ratios, world.skin()->topology()->embedding);
      }
      report_live(out, fmt::format("script {} in scene {}, 5 mm cells", acts, name), ratios, cpu_ms() - before);
    } catch (const InputError& e) {
      out.notes.push_back("live error: the shipped scene " + name + " was not found (" + e.what() + ")");
    }
  }
}

}  // namespace limberg::bench
