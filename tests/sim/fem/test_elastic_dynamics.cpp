// Backward Euler and BDF2 through the same minimiser.
#include <gtest/gtest.h>

#include "models.h"
#include "sim/testing/reference_newton.h"

namespace limberg {
namespace test_elastic_dynamics {

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
  double run(int steps, double time, Integrator integrator = Integrator::backward_euler,
             double damping_per_s = 0) const {
    InlineWorkers w;
    auto solver = make_solver(w);
    solver->set_model(model, {});
    solver->set_springs(std::vector<Spring>{spring});
    StepSettings s;
    s.dt_s = time / steps, s.max_iterations = 40, s.tolerance = 1e-6;
    s.integrator = integrator, s.damping_per_s = damping_per_s;
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
      for (size_t i = 0; i < now.size(); ++i)
        kinetic += 0.5 * m->mass_kg[i] * ((now[i] - before[i]) / s.dt_s).squaredNorm();
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

// Against the closed form, which is nearer than any number of float steps: below
// 1e-3 mm rounding of velocities takes over (measured with 320 steps and more).
// What a step must have made zero, worked out apart from the
// minimiser: m a + dE/du, a from the formulas of the two methods.
TEST(Dynamics, AStepBalancesForceAndInertia) {
  const auto m = std::make_shared<FemModel>(block(true));
  for (const Integrator method : {Integrator::backward_euler, Integrator::bdf2}) {
    InlineWorkers w;
    auto solver = make_solver(w);
    solver->set_model(m, {});
    solver->set_displacement_mm(test::to_float(test::random_displacement(*m, 0.3, 4)));
    StepSettings s;
    s.dt_s = 2e-3, s.max_iterations = 400, s.tolerance = 1e-6, s.integrator = method;
    const double h = s.dt_s;
    std::vector<std::vector<Vec3>> u{current(*solver)}, v{std::vector<Vec3>(m->X_mm.size(), Vec3::Zero())};
    for (int k = 1; k <= 4; ++k) {
      solver->step(s);
      u.push_back(current(*solver));
      const bool second = method == Integrator::bdf2 && k > 1;  // the first step is backward Euler's
      const size_t n = size_t(k);
      const auto rate = [&](const std::vector<std::vector<Vec3>>& x, size_t i) {
        return second ? Vec3((3 * x[n][i] - 4 * x[n - 1][i] + x[n - 2][i]) / (2 * h))
                      : Vec3((x[n][i] - x[n - 1][i]) / h);
      };
      v.emplace_back();
      for (size_t i = 0; i < m->X_mm.size(); ++i) v[n].push_back(rate(u, i));
      std::vector<Vec3> g;
      ReferenceElasticity(*m, {}).gradient(u[n], g);
      double left = 0, size = 0;
      for (size_t i = 0; i < g.size(); ++i) {
        if (m->fixed[i]) continue;
        const Vec3 inertia = m->mass_kg[i] * rate(v, i);
        left += (g[i] + inertia).squaredNorm(), size += g[i].squaredNorm() + inertia.squaredNorm();
      }
      EXPECT_LT(std::sqrt(left), 2e-3 * std::sqrt(size)) << k;  // u in floats over h^2; a wrong factor would be tenths
    }
  }
}

TEST(Bdf2, SecondOrderOnADampedOscillation) {
  const Oscillator o;
  const double time = 2.0 / o.omega, damping = 0.4 * o.omega;
  // The point on its spring, from rest: 2 mm (1 - e^(-ct/2) (cos wt
  // + c/(2w) sin wt)). The block is stiff: 500 times the spring.
  const double w = o.omega * std::sqrt(1 - 0.04);
  const double exact =
      2 * (1 - std::exp(-damping * time / 2) * (std::cos(w * time) + damping / (2 * w) * std::sin(w * time)));
  const auto error = [&](int steps, Integrator kind) { return o.run(steps, time, kind, damping) - exact; };
  const double e1 = error(20, Integrator::bdf2), e2 = error(40, Integrator::bdf2), e3 = error(80, Integrator::bdf2);
  EXPECT_NEAR(std::log2(e1 / e2), 2, 0.1);  // measured 1.99, 1.98
  EXPECT_NEAR(std::log2(e2 / e3), 2, 0.1);
  EXPECT_NEAR(std::log2(error(40, Integrator::backward_euler) / error(80, Integrator::backward_euler)), 1, 0.1);
  EXPECT_LT(std::abs(e3), 0.1 * std::abs(error(80, Integrator::backward_euler)));
}

TEST(Bdf2, EnergyNeverGrowsBeyondTheStartAndSlowMotionKeepsMost) {
  const auto m = std::make_shared<FemModel>(block(true));
  ReferenceElasticity reference(*m, {});
  InlineWorkers w;
  // Bent over: mostly the lowest mode (a period of about 20 ms), some of the others.
  std::vector<Vec3> bent;
  for (const Vec3& X : m->X_mm) bent.push_back({0.02 * X[2] * X[2], 0, 0});
  double left[2];
  for (Integrator kind : {Integrator::backward_euler, Integrator::bdf2}) {
    auto solver = make_solver(w);
    solver->set_model(m, {});
    solver->set_displacement_mm(test::to_float(bent));
    StepSettings s;
    s.dt_s = 1e-3, s.integrator = kind, s.max_iterations = 200, s.tolerance = 1e-6;
    const double start = reference.energy(current(*solver));
    double most = 0, total = 0;
    for (int k = 0; k < 60; ++k) {
      solver->step(s);
      const auto now = current(*solver);
      const SolverState state = solver->save();
      double kinetic = 0;
      for (size_t i = 0; i < now.size(); ++i)
        for (size_t j = 0; j < 3; ++j)
          kinetic +=
              0.5 * m->mass_kg[i] * double(state.velocity_mm_s[3 * i + j]) * double(state.velocity_mm_s[3 * i + j]);
      total = reference.energy(now) + kinetic, most = std::max(most, total);
    }
    EXPECT_LT(most, start * (1 + 1e-4));
    left[kind == Integrator::bdf2] = total / start;
  }
  EXPECT_LT(left[1], 0.99);
  EXPECT_GT(left[1], 2 * left[0]);
}

TEST(Bdf2, LongStepsOfStiffTissueEndAtRest) {
  const auto m = std::make_shared<FemModel>(block(true));
  InlineWorkers w;
  auto solver = make_solver(w);
  solver->set_model(m, {});
  solver->set_displacement_mm(test::to_float(test::random_displacement(*m, 0.5, 5, false)));
  StepSettings s;
  s.dt_s = 0.1, s.integrator = Integrator::bdf2, s.max_iterations = 300, s.tolerance = 1e-6;
  for (int k = 0; k < 40; ++k) solver->step(s);
  for (const Vec3f& u : solver->displacement_mm()) EXPECT_LT(u.norm(), 1e-3);
}

TEST(Bdf2, SavedAndRestoredItGoesOnToTheBit) {
  const Oscillator o;
  InlineWorkers w;
  auto a = make_solver(w), b = make_solver(w);
  StepSettings s;
  s.dt_s = 0.1 / o.omega, s.integrator = Integrator::bdf2, s.max_iterations = 200, s.tolerance = 1e-6;
  for (auto* x : {&a, &b}) (*x)->set_model(o.model, {}), (*x)->set_springs(std::vector<Spring>{o.spring});
  for (int k = 0; k < 3; ++k) a->step(s);
  const SolverState state = a->save();
  EXPECT_GT(state.before_s, 0);
  b->step(s);
  b->restore(state);
  EXPECT_TRUE(b->save() == state);
  a->restore(state);  // forgets its pairs, as b
  for (int k = 0; k < 3; ++k) a->step(s), b->step(s);
  EXPECT_TRUE(a->save() == b->save());
  StepSettings still;
  still.max_iterations = 5;
  a->step(still);
  EXPECT_EQ(a->save().before_s, 0);  // another kind of step: BDF2 begins anew
}

}  // namespace test_elastic_dynamics
}  // namespace limberg
