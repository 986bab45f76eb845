#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/operating_point/cpu_clock.h"
#include "sim/fem/solver/focus_solver.h"
#include "sim/fem/solver/lbfgs_solver.h"
#include "sim/testing/reference_newton.h"
#include "tests/bench/speed_parts.h"

namespace limberg::bench {
namespace {

const Vec3 pull(-10, -10, 26);  // mm, 29.6 in length

struct SpeedSize {
  const char* name;
  int side, layers;
  // Times faster than Newton. 8k to 1 mm: the issue's. 2k,
  // and 8k to 0.1 mm: the targets set after the prototype
  // (35-98 times to 1 mm, 22-70 to 0.1 mm). 30k, where
  // Newton is stopped at its limit and the ratio is a lower bound: the prototype's lowest.
  double bar_1mm, bar_01mm;
  double lag_median, lag_worst;  // mm, drag; 0: not dragged. The issue's
};
constexpr SpeedSize sizes[] = {
    {"2k", 24, 2, 30, 20, 0, 0}, {"8k", 44, 3, 150, 50, 0.05, 0.05}, {"30k", 66, 6, 35, 22, 0.06, 0.3}};
constexpr SpeedSize large = {"100k", 100, 9, 0, 0, 0, 0};  // the stretch: how far it gets, no bar
// With what lies far holding still: half of the lag that the eye sees, and that.
constexpr SpeedSize near_30k = {"30k", 66, 6, 0, 0, 0.05, 0.1}, near_100k = {"100k", 100, 9, 0, 0, 0.05, 0.1};

const char* method(bool cycle) {
  return cycle ? "L-BFGS, multilevel cycle, augm. Lagrangian" : "L-BFGS, panel Cholesky, augm. Lagrangian";
}

struct NewtonTimes {
  double to_1mm = 0, to_01mm = 0;
  double error = 0;  // at the end
  bool has_1mm = false, has_01mm = false;
  int iterations = 0, failed = 0;
};

NewtonTimes newton(const ReferenceElasticity& ref, const std::vector<Vec3>& exact, bool adaptive, double limit_ms) {
  NewtonTimes t;
  ReferenceElasticity::Settings s;
  s.adaptive = adaptive;
  s.max_iterations = 400;
  double spent = 0, start = cpu_ms();
  s.on_iterate = [&](std::span<const Vec3> u) {
    spent += cpu_ms() - start;
    t.error = largest_error(u, exact);
    ++t.iterations;
    if (t.error > 1) t.has_1mm = false;
    if (t.error > 0.1) t.has_01mm = false;
    if (t.error <= 1 && !t.has_1mm) t.has_1mm = true, t.to_1mm = spent;
    if (t.error <= 0.1 && !t.has_01mm) t.has_01mm = true, t.to_01mm = spent;
    start = cpu_ms();
    return spent > limit_ms || t.error < 1e-3;
  };
  const auto r = ref.solve(std::vector<Vec3>(exact.size(), Vec3::Zero()), s);
  t.failed = r.failed_factors;
  if (!t.has_1mm) t.to_1mm = spent;
  if (!t.has_01mm) t.to_01mm = spent;
  return t;
}

void cold_pull(const SpeedRun& run, const SpeedSize& size, double poisson) {
  Result& out = run.out;
  const BenchScene scene = pulled_scene(size.side, size.layers, poisson);
  const auto model = std::make_shared<FemModel>(scene.model);
  const std::string label = fmt::format("pull 30 mm, {} nodes, nu {:.2f}", size.name, poisson);
  const std::string nodes =
      std::to_string(model->X_mm.size()) + " nodes, " + std::to_string(model->cells.size()) + " cells";
  run.say(std::string(label) + ": reference");
  const std::vector<Vec3> exact = equilibrium(model, scene.springs);
  const PullTimes ours = our_pull(model, scene.springs, exact);
  for (int i = 0; i < 2; ++i) {
    const std::string how =
        fmt::format(", {} iterations, to {} mm, median of 3; {:.2f} ms with the estimate of the error",
                    ours.iterations[i], i ? "0.1" : "1", ours.with_estimate_ms[i]);
    out.rows.push_back({label, method(ours.cycle), nodes + how, ours.ms[i], false, ours.error[i], "mm",
                        "Newton to residual 1e-10", ours.iterations[i] >= 0 && ours.error[i] <= (i ? 0.1 : 1)});
  }
  ReferenceElasticity reference(scene.model, scene.springs);
  reference.prepare();

  NewtonTimes best{};
  for (bool adaptive : {false, true}) {
    run.say(std::string(label) + (adaptive ? ": adaptive Newton" : ": projected Newton"));
    const NewtonTimes t = newton(reference, exact, adaptive, run.settings.newton_limit_ms);
    const std::string how =
        nodes + ", " + std::to_string(t.iterations) + " iterations, " + std::to_string(t.failed) + " failed factors";
    const std::string method = adaptive ? "adaptive Newton, CHOLMOD" : "projected Newton, CHOLMOD";
    out.rows.push_back({label, method, how + ", to 1 mm", t.to_1mm, !t.has_1mm, t.has_1mm ? 1.0 : t.error, "mm",
                        "Newton to residual 1e-10", true});
    out.rows.push_back({label, method, how + ", to 0.1 mm", t.to_01mm, !t.has_01mm, t.has_01mm ? 0.1 : t.error, "mm",
                        "Newton to residual 1e-10", true});
    const auto better = [](bool has, double time, bool best_has, double best_time) {
      return has != best_has ? has
             : has           ? time < best_time
                             : time > best_time;  // both stopped: the longer one says more
    };
    if (!adaptive || better(t.has_1mm, t.to_1mm, best.has_1mm, best.to_1mm))
      best.has_1mm = t.has_1mm, best.to_1mm = t.to_1mm;
    if (!adaptive || better(t.has_01mm, t.to_01mm, best.has_01mm, best.to_01mm))
      best.has_01mm = t.has_01mm, best.to_01mm = t.to_01mm;
  }
  const auto bar = [&](const char* what, double newton_ms, bool has, double own_ms, double wanted) {
    const double ratio = own_ms > 0 ? newton_ms / own_ms : 0;
    out.bars.push_back({std::string(label) + ": times faster than Newton to " + what, ratio, !has, wanted, true,
                        ratio >= wanted, "issue: 150 times to 1 mm at 8k; prototype: 35-98 to 1 mm, 22-70 to 0.1 mm"});
  };
  bar("1 mm", best.to_1mm, best.has_1mm, ours.ms[0], size.bar_1mm);
  bar("0.1 mm", best.to_01mm, best.has_01mm, ours.ms[1], size.bar_01mm);
}

/// `every`: the truth is asked for after so many frames only (at 100k nodes it costs seconds). `near`: as a session
/// does it, what lies far from the hook holds still meanwhile (focus_solver.h).
void drag(const SpeedRun& run, const SpeedSize& size, double poisson, int every, bool near) {
  Result& out = run.out;
  run.say(std::string("drag at ") + size.name + " nodes" + (near ? ", near the hook" : ""));
  BenchScene scene = bench_scene(size.side, size.layers, poisson);
  const auto model = std::make_shared<FemModel>(scene.model);
  InlineWorkers workers;
  auto solver = ready(workers, scene.springs, model), exact = ready(workers, scene.springs, model);
  fem::FocusSolver* focus = nullptr;
  if (near) {
    auto own = std::make_unique<fem::FocusSolver>(workers);
    focus = own.get(), solver = std::move(own);
    solver->set_model(model, {}), solver->set_springs(scene.springs);
  }
  StepSettings settle, frame;
  frame.focus = near;
  settle.max_iterations = 800, settle.tolerance = 3e-6;
  solver->step(settle);
  frame.max_iterations = 1000, frame.tolerance = 3e-6;
  constexpr double budget_ms = 1000.0 / 60;
  double start = 0, last = 0, longest = 0, iterations = 0;
  frame.should_stop = [&] {  // room for one more iteration, and for what follows the last
    const double now = cpu_ms(), one = now - last;
    last = now;
    return now - start + one > budget_ms - 0.7;
  };
  bool cycle = false;
  std::vector<double> lag;
  double after = 0;
  for (int f = 0; f < 36; ++f) {
    if (f < 30) scene.springs.back().target_mm += pull.normalized();
    const bool looked_at = f % every == every - 1 || f == 32;
    std::vector<Vec3> truth;
    if (looked_at) {
      exact->set_springs(scene.springs);
      exact->step(settle);
      for (const Vec3f& u : exact->displacement_mm()) truth.push_back(u.cast<double>());
    }
    start = last = cpu_ms();
    solver->set_springs(scene.springs);
    const limberg::StepReport r = solver->step(frame);
    cycle = r.metric_is_cycle;
    longest = std::max(longest, cpu_ms() - start);
    if (looked_at && f < 30) lag.push_back(largest_error(solver->displacement_mm(), truth));
    if (f == 32) after = largest_error(solver->displacement_mm(), truth);
    if (f < 30) iterations += r.iterations / 30.0;
  }
  std::sort(lag.begin(), lag.end());
  const std::string label =
      fmt::format("drag 60 mm/s at 60 Hz, {} nodes, nu {:.3g}{}", size.name, poisson, near ? ", near the hook" : "");
  const std::string how =
      fmt::format("{} of {} nodes, {:.1f} iterations a frame, longest frame {:.1f} ms",
                  focus ? focus->most_nodes_near() : model->X_mm.size(), model->X_mm.size(), iterations, longest);
  const std::string truth = "equilibrium of the current target, residual 3e-6";
  const struct {
    const char* name;
    double value, bar;
    const char* source;
  } figures[] = {
      {"lag median", lag[lag.size() / 2], size.lag_median, "prototype 0.000-0.001 at 8k, 0.011-0.026 at 30k"},
      {"lag worst", lag.back(), size.lag_worst, "prototype 0.001-0.004 at 8k, 0.155-0.284 at 30k"},
      {"3 frames after the stop", after, size.lag_worst > 0 ? 0.03 : 0, "prototype 0.001-0.013"}};
  for (const auto& g : figures) {
    const bool pass = g.bar == 0 || g.value <= g.bar;
    out.rows.push_back(
        {label, method(cycle), std::string(g.name) + ", " + how, budget_ms, false, g.value, "mm", truth, pass});
    if (g.bar > 0)
      out.bars.push_back({std::string(label) + ": " + g.name + " (mm)", g.value, false, g.bar, false, pass, g.source});
  }
}

/// Iterations after which the error stays below `limit` (from
/// the errors after 0, 1, ... iterations); -1 if it does not.
int settled_at(const std::vector<double>& error, double limit) {
  int at = -1;
  for (int k = int(error.size()); k-- > 0 && error[size_t(k)] <= limit;) at = k;
  return at;
}

}  // namespace

double largest_error(std::span<const Vec3f> u, std::span<const Vec3> exact) {
  double m = 0;
  for (size_t i = 0; i < u.size(); ++i) m = std::max(m, (u[i].cast<double>() - exact[i]).squaredNorm());
  return std::sqrt(m);
}
double largest_error(std::span<const Vec3> u, std::span<const Vec3> exact) {
  double m = 0;
  for (size_t i = 0; i < u.size(); ++i) m = std::max(m, (u[i] - exact[i]).squaredNorm());
  return std::sqrt(m);
}

BenchScene pulled_scene(int side, int layers, double poisson) {
  BenchScene scene = bench_scene(side, layers, poisson);
  scene.springs.back().target_mm += pull;
  return scene;
}

std::unique_ptr<ElasticSolver> ready(Workers& w, std::span<const Spring> springs,
                                     const std::shared_ptr<const FemModel>& model, bool estimate_error) {
  std::unique_ptr<ElasticSolver> solver =
      std::make_unique<fem::LbfgsSolver>(w, true, fem::MetricPolicy{}, fem::MinimiserPolicy{0, estimate_error});
  solver->set_model(model, {});
  solver->set_springs(springs);
  StepSettings none;
  none.max_iterations = 0;
  solver->step(none);  // builds the factor
  return solver;
}

std::vector<Vec3> equilibrium(const std::shared_ptr<const FemModel>& model, std::span<const Spring> springs) {
  InlineWorkers workers;
  auto solver = ready(workers, springs, model);
  StepSettings s;
  s.max_iterations = 1500, s.tolerance = 2e-6;
  solver->step(s);
  std::vector<Vec3> u;
  for (const Vec3f& v : solver->displacement_mm()) u.push_back(v.cast<double>());
  ReferenceElasticity::Settings polish;
  polish.max_iterations = u.size() > 20000 ? 2 : 4, polish.tolerance = 1e-10;
  return ReferenceElasticity(*model, springs).solve(u, polish).u;
}

// First the error after every iteration, then timed calls of exactly as many as are needed.
PullTimes our_pull(const std::shared_ptr<const FemModel>& model, std::span<const Spring> springs,
                   std::span<const Vec3> exact) {
  InlineWorkers workers;
  std::vector<double> error;
  {
    auto solver = ready(workers, springs, model);
    StepSettings one;
    one.max_iterations = 1;
    error.push_back(largest_error(solver->displacement_mm(), exact));
    for (int k = 0; k < 400 && error.back() > 0.02; ++k) {
      solver->step(one);
      error.push_back(largest_error(solver->displacement_mm(), exact));
    }
  }
  PullTimes t;
  for (int i = 0; i < 2; ++i) {
    t.iterations[i] = settled_at(error, i ? 0.1 : 1);
    t.error[i] = error.back();
    Times times, estimated;
    for (int repeat = 0; repeat < 6 && t.iterations[i] >= 0; ++repeat) {
      const bool estimate = repeat % 2;  // a peer has none
      auto solver = ready(workers, springs, model, estimate);
      StepSettings s;
      s.max_iterations = t.iterations[i];
      const double start = cpu_ms();
      t.cycle = solver->step(s).metric_is_cycle;
      (estimate ? estimated : times).add(cpu_ms() - start);
      t.error[i] = largest_error(solver->displacement_mm(), exact);
    }
    t.ms[i] = times.median(), t.with_estimate_ms[i] = estimated.median();
  }
  return t;
}

Result speed(const SpeedSettings& settings) {
  Result out;
  const SpeedRun run{out, settings};
  const auto wanted = [&](const std::string& part) {
    return settings.only.empty() || part.find(settings.only) != std::string::npos;
  };
  for (const SpeedSize& size : sizes) {
    if (settings.quick && size.side != 24) continue;
    for (double poisson : {0.45, 0.49})
      if (wanted(std::string("pull ") + size.name)) cold_pull(run, size, poisson);
  }
  if (wanted("kernels")) speed_kernels(run);
  if (wanted("profile")) speed_profile(run);
  if (wanted("locking")) speed_locking(run);
  if (wanted("slab")) speed_slab(run);
  if (wanted("flap")) speed_flap(run);
  if (wanted("region")) speed_region(run);
  if (settings.quick) return out;
  if (wanted("scalar")) speed_scalar_double(run);
  if (wanted("workers")) speed_workers(run);
  if (wanted("bullet")) speed_bullet(run);
  for (const SpeedSize& size : sizes)
    for (double poisson : {0.45, 0.49, 0.499})
      if (size.lag_worst > 0 && wanted(std::string("drag ") + size.name)) {
        drag(run, size, poisson, 1, false);
        if (size.side > 60) drag(run, near_30k, poisson, 1, true);
      }
  for (const bool near : {false, true})
    if (wanted(std::string("drag ") + large.name)) drag(run, near ? near_100k : large, 0.49, 10, near);
  return out;
}

}  // namespace limberg::bench
