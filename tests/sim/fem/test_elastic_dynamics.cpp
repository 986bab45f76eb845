// Backward Euler through the same minimiser.
#include <gtest/gtest.h>

#include "models.h"
#include "sim/fem/reference_newton.h"

namespace limberg {
namespace {

std::vector<Vec3> current(const ElasticSolver& s) {
  std::vector<Vec3> u;
  for (const Vec3f& v : s.displacement_mm()) u.push_back(v.cast<double>());
  return u;
}

FemModel block(bool fixed) {
  BoxSpec b;
  b.cells = {2, 2, 4}, b.size_mm = {10, 10, 20}, b.poisson = 0.3, b.fix_bottom = fixed;
  return box_model(b);
}

/// A heavy point on a world spring: one cell, rigid compared with the spring.
struct Oscillator {
  std::shared_ptr<FemModel> model;
  Spring spring;
  double omega = 0;  // 1/s
  Oscillator() {
    BoxSpec b;
    b.cells = {1, 1, 1}, b.size_mm = {10, 10, 10}, b.young_bottom_kPa = b.young_top_kPa = 500, b.poisson = 0.3;
    model = std::make_shared<FemModel>(box_model(b));
    spring.id = 1, spring.a = embed(*model, {0, 0, 5}), spring.to_world = true, spring.k_N_per_mm = 0.001;
    spring.target_mm = {0, 0, 7};
    double mass = 0;
    for (double v : model->mass_kg) mass += v;
    omega = std::sqrt(spring.k_N_per_mm * 1000 / mass);
  }
  /// Height of the point above its rest after `periods` of a period in `steps` steps.
  double run(int steps, double time) const {
    InlineWorkers w;
    auto solver = make_solver(w);
    solver->set_model(model, {});
    solver->set_springs(std::vector<Spring>{spring});
    StepSettings s;
    s.dt_s = time / steps, s.max_iterations = 200, s.tolerance = 1e-6;
    for (int i = 0; i < steps; ++i) solver->step(s);
    return solver->position_mm(spring.a)[2] - 5;
  }
};

TEST(BackwardEuler, FirstOrderOnAnOscillation) {
  const Oscillator o;
  const double time = 2.0 / o.omega;
  const double exact = 2 * (1 - std::cos(2.0));  // pulled by 2 mm from rest
  const double e1 = o.run(40, time) - exact, e2 = o.run(80, time) - exact, e3 = o.run(160, time) - exact;
  EXPECT_LT(std::abs(e3), 0.1);
  EXPECT_NEAR(e1 / e2, 2, 0.2);
  EXPECT_NEAR(e2 / e3, 2, 0.2);
}

TEST(BackwardEuler, AFreeBlockKeepsItsMomentum) {
  const auto m = std::make_shared<FemModel>(block(false));
  InlineWorkers w;
  auto solver = make_solver(w);
  solver->set_model(m, {});
  // A deformed start: it springs back, and nothing outside pulls at it.
  solver->set_displacement_mm(test::to_float(test::random_displacement(*m, 0.5, 3)));
  StepSettings s;
  s.dt_s = 1e-3, s.max_iterations = 200, s.tolerance = 1e-6;
  auto before = current(*solver);
  Vec3 moved = Vec3::Zero();
  double path = 0, mass = 0;
  for (double v : m->mass_kg) mass += v;
  for (int k = 0; k < 20; ++k) {
    solver->step(s);
    const auto now = current(*solver);
    for (size_t i = 0; i < now.size(); ++i) {
      moved += m->mass_kg[i] / mass * (now[i] - before[i]);
      path += m->mass_kg[i] / mass * (now[i] - before[i]).norm();
    }
    before = now;
  }
  EXPECT_GT(path, 0.1);
  EXPECT_LT(moved.norm(), 1e-4 * path);  // residual 1e-6 per step, 20 steps
}

TEST(BackwardEuler, EnergyOnlyFalls) {
  const auto m = std::make_shared<FemModel>(block(true));
  ReferenceElasticity reference(*m, {});
  InlineWorkers w;
  for (double damping : {0.0, 30.0}) {
    auto solver = make_solver(w);
    solver->set_model(m, {});
    solver->set_displacement_mm(test::to_float(test::random_displacement(*m, 0.5, 5, false)));
    StepSettings s;
    s.dt_s = 2e-3, s.damping_per_s = damping, s.max_iterations = 200, s.tolerance = 1e-6;
    auto before = current(*solver);
    double total = reference.energy(before);
    const double start = total;
    for (int k = 0; k < 50; ++k) {
      solver->step(s);
      const auto now = current(*solver);
      double kinetic = 0;
      for (size_t i = 0; i < now.size(); ++i) kinetic += 0.5 * m->mass_kg[i] * ((now[i] - before[i]) / s.dt_s).squaredNorm();
      const double e = reference.energy(now) + kinetic;
      EXPECT_LE(e, total + 1e-4 * start);
      total = e, before = now;
    }
    EXPECT_LT(total, 0.2 * start);
  }
}

TEST(BackwardEuler, ManyStepsEndInTheStaticSolution) {
  const auto m = std::make_shared<FemModel>(block(true));
  Spring hook;
  hook.id = 3, hook.a = embed(*m, {2, 1, 20}), hook.to_world = true, hook.target_mm = {6, 3, 24}, hook.k_N_per_mm = 0.1;
  InlineWorkers w;
  auto fast = make_solver(w), still = make_solver(w);
  for (auto* s : {&fast, &still}) (*s)->set_model(m, {}), (*s)->set_springs(std::vector<Spring>{hook});
  StepSettings s;
  s.max_iterations = 300, s.tolerance = 1e-6;
  still->step(s);
  s.dt_s = 0.01, s.damping_per_s = 20;
  for (int k = 0; k < 200; ++k) fast->step(s);
  double worst = 0;
  for (size_t i = 0; i < m->X_mm.size(); ++i)
    worst = std::max(worst, double((fast->displacement_mm()[i] - still->displacement_mm()[i]).norm()));
  EXPECT_LT(worst, 1e-3);
}

}  // namespace
}  // namespace limberg
