#include "app/bench/speed.h"

#include <algorithm>
#include <cmath>

#include "app/bench/cpu_clock.h"
#include "sim/fem/box_model.h"
#include "sim/fem/elastic_solver.h"
#include "sim/fem/reference_newton.h"

namespace limberg::bench {
namespace {

const Vec3 pull(-10, -10, 26);  // mm, 29.6 in length

struct Size {
  const char* name;
  int side, layers;
  // Times faster than Newton. 2k and 8k: the targets set after the prototype (35-98 times to 1 mm, 22-70 to 0.1 mm). 30k, where
  // Newton is stopped at its limit and the ratio is a lower bound: the prototype's lowest.
  double bar_1mm, bar_01mm;
  double lag_median, lag_worst;  // mm, drag; 0: not dragged. The issue's
};
constexpr Size sizes[] = {{"2k", 24, 2, 30, 20, 0, 0}, {"8k", 44, 3, 60, 50, 0.05, 0.05}, {"30k", 66, 6, 35, 22, 0.06, 0.3}};

const char* method(bool cycle) {
  return cycle ? "L-BFGS, multilevel cycle, augm. Lagrangian" : "L-BFGS, panel Cholesky, augm. Lagrangian";
}

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

std::unique_ptr<ElasticSolver> ready(Workers& w, const BenchScene& s, const std::shared_ptr<const FemModel>& model) {
  auto solver = make_solver(w);
  solver->set_model(model, {});
  solver->set_springs(s.springs);
  StepSettings none;
  none.max_iterations = 0;
  solver->step(none);  // builds the factor
  return solver;
}

/// Iterations after which the error stays below `limit` (from the errors after 0, 1, ... iterations); -1 if it does not.
int settled_at(const std::vector<double>& error, double limit) {
  int at = -1;
  for (int k = int(error.size()); k-- > 0 && error[size_t(k)] <= limit;) at = k;
  return at;
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

void cold_pull(Result& out, const SpeedSettings& settings, const Size& size, double poisson) {
  const auto say = [&](const std::string& text) {
    if (settings.progress) settings.progress(text);
  };
  BenchScene scene = bench_scene(size.side, size.layers, poisson);
  scene.springs.back().target_mm += pull;
  const auto model = std::make_shared<FemModel>(scene.model);
  char label[64];
  std::snprintf(label, sizeof label, "pull 30 mm, %s nodes, nu %.2f", size.name, poisson);
  const std::string nodes = std::to_string(model->X_mm.size()) + " nodes, " + std::to_string(model->cells.size()) + " cells";

  // The exact answer: this solver to its floor, polished by Newton in double.
  say(std::string(label) + ": reference");
  InlineWorkers workers;
  ReferenceElasticity reference(scene.model, scene.springs);
  reference.prepare();
  std::vector<Vec3> exact;
  {
    auto solver = ready(workers, scene, model);
    StepSettings s;
    s.max_iterations = 1500, s.tolerance = 2e-6;
    solver->step(s);
    for (const Vec3f& u : solver->displacement_mm()) exact.push_back(u.cast<double>());
    ReferenceElasticity::Settings polish;
    polish.max_iterations = size.layers > 4 ? 2 : 4, polish.tolerance = 1e-10;
    exact = reference.solve(exact, polish).u;
  }

  // Ours: first the error after every iteration, then one timed call of exactly as many as are needed.
  std::vector<double> error;
  {
    auto solver = ready(workers, scene, model);
    StepSettings one;
    one.max_iterations = 1;
    error.push_back(largest_error(solver->displacement_mm(), exact));
    for (int k = 0; k < 400 && error.back() > 0.02; ++k) {
      solver->step(one);
      error.push_back(largest_error(solver->displacement_mm(), exact));
    }
  }
  double ours[2] = {0, 0};
  const double limits[2] = {1.0, 0.1};
  for (int i = 0; i < 2; ++i) {
    const int its = settled_at(error, limits[i]);
    std::vector<double> times;
    bool cycle = false;
    double reached = error.back();
    for (int repeat = 0; repeat < 3 && its >= 0; ++repeat) {
      auto solver = ready(workers, scene, model);
      StepSettings s;
      s.max_iterations = its;
      const double start = cpu_ms();
      cycle = solver->step(s).metric_is_cycle;
      times.push_back(cpu_ms() - start);
      reached = largest_error(solver->displacement_mm(), exact);
    }
    std::sort(times.begin(), times.end());
    ours[i] = times.empty() ? 0 : times[1];
    out.rows.push_back({label, method(cycle),
                        nodes + ", " + std::to_string(its) + " iterations, to " + (i ? "0.1" : "1") + " mm, median of 3",
                        ours[i], false, reached, "mm", "Newton to residual 1e-10", its >= 0 && reached <= limits[i]});
  }

  NewtonTimes best{};
  for (bool adaptive : {false, true}) {
    say(std::string(label) + (adaptive ? ": adaptive Newton" : ": projected Newton"));
    const NewtonTimes t = newton(reference, exact, adaptive, settings.newton_limit_ms);
    const std::string how = nodes + ", " + std::to_string(t.iterations) + " iterations, " + std::to_string(t.failed) + " failed factors";
    const std::string method = adaptive ? "adaptive Newton, CHOLMOD" : "projected Newton, CHOLMOD";
    out.rows.push_back({label, method, how + ", to 1 mm", t.to_1mm, !t.has_1mm, t.has_1mm ? 1.0 : t.error, "mm",
                        "Newton to residual 1e-10", true});
    out.rows.push_back({label, method, how + ", to 0.1 mm", t.to_01mm, !t.has_01mm, t.has_01mm ? 0.1 : t.error, "mm",
                        "Newton to residual 1e-10", true});
    const auto better = [](bool has, double time, bool best_has, double best_time) {
      return has != best_has ? has : has ? time < best_time : time > best_time;  // both stopped: the longer one says more
    };
    if (!adaptive || better(t.has_1mm, t.to_1mm, best.has_1mm, best.to_1mm)) best.has_1mm = t.has_1mm, best.to_1mm = t.to_1mm;
    if (!adaptive || better(t.has_01mm, t.to_01mm, best.has_01mm, best.to_01mm))
      best.has_01mm = t.has_01mm, best.to_01mm = t.to_01mm;
  }
  const auto bar = [&](const char* what, double newton_ms, bool has, double own_ms, double wanted) {
    const double ratio = own_ms > 0 ? newton_ms / own_ms : 0;
    out.bars.push_back({std::string(label) + ": times faster than Newton to " + what, ratio, !has, wanted, true, ratio >= wanted,
                        "prototype: 35-98 times to 1 mm, 22-70 to 0.1 mm"});
  };
  bar("1 mm", best.to_1mm, best.has_1mm, ours[0], size.bar_1mm);
  bar("0.1 mm", best.to_01mm, best.has_01mm, ours[1], size.bar_01mm);
}

void drag(Result& out, const SpeedSettings& settings, const Size& size, double poisson) {
  if (settings.progress) settings.progress(std::string("drag at ") + size.name + " nodes");
  BenchScene scene = bench_scene(size.side, size.layers, poisson);
  const auto model = std::make_shared<FemModel>(scene.model);
  InlineWorkers workers;
  auto solver = ready(workers, scene, model), exact = ready(workers, scene, model);
  StepSettings settle, frame;
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
  std::vector<double> lag, after;
  for (int f = 0; f < 36; ++f) {
    if (f < 30) scene.springs.back().target_mm += pull.normalized();
    exact->set_springs(scene.springs);
    exact->step(settle);
    std::vector<Vec3> truth;
    for (const Vec3f& u : exact->displacement_mm()) truth.push_back(u.cast<double>());
    start = last = cpu_ms();
    solver->set_springs(scene.springs);
    const StepReport r = solver->step(frame);
    cycle = r.metric_is_cycle;
    longest = std::max(longest, cpu_ms() - start);
    (f < 30 ? lag : after).push_back(largest_error(solver->displacement_mm(), truth));
    if (f < 30) iterations += r.iterations / 30.0;
  }
  std::sort(lag.begin(), lag.end());
  char label[96], how[128];
  std::snprintf(label, sizeof label, "drag 60 mm/s at 60 Hz, %s nodes, nu %.3g", size.name, poisson);
  std::snprintf(how, sizeof how, "%zu nodes, %.1f iterations a frame, longest frame %.1f ms", model->X_mm.size(), iterations, longest);
  const std::string truth = "equilibrium of the current target, residual 3e-6";
  const struct {
    const char* name;
    double value, bar;
    const char* source;
  } figures[] = {{"lag median", lag[lag.size() / 2], size.lag_median, "prototype 0.000-0.001 at 8k, 0.011-0.026 at 30k"},
                 {"lag worst", lag.back(), size.lag_worst, "prototype 0.001-0.004 at 8k, 0.155-0.284 at 30k"},
                 {"3 frames after the stop", after[2], 0.03, "prototype 0.001-0.013"}};
  for (const auto& g : figures) {
    const bool pass = g.value <= g.bar;
    out.rows.push_back({label, method(cycle), std::string(g.name) + ", " + how, budget_ms, false, g.value, "mm", truth, pass});
    out.bars.push_back({std::string(label) + ": " + g.name + " (mm)", g.value, false, g.bar, false, pass, g.source});
  }
}

}  // namespace

Result speed(const SpeedSettings& settings) {
  Result out;
  for (const Size& size : sizes) {
    if (settings.quick && size.side != 24) continue;
    for (double poisson : {0.45, 0.49}) cold_pull(out, settings, size, poisson);
  }
  if (!settings.quick) {
    for (const Size& size : sizes)
      for (double poisson : {0.45, 0.49, 0.499})
        if (size.lag_worst > 0) drag(out, settings, size, poisson);
  }
  return out;
}

}  // namespace limberg::bench
