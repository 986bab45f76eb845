// Weight, loads and components that are held alone, against closed forms, against Newton, and by their balance.
#include <gtest/gtest.h>

#include <cmath>

#include "divided_box.h"
#include "models.h"
#include "sim/base/error.h"
#include "sim/fem/solver/lbfgs_solver.h"
#include "sim/fem/solver/region_solver.h"
#include "sim/testing/reference_newton.h"

namespace limberg {
namespace test_dead_loads {

bool at(double x, double y) { return std::abs(x - y) < 1e-9; }

/// Rollers: every node is held along the axes across the planes x = +-, y = +- and z = 0 on which it lies.
void put_on_rollers(FemModel& m, bool high_sides = true) {
  Vec3 lo = m.X_mm[0], hi = lo;
  for (const Vec3& X : m.X_mm) lo = lo.cwiseMin(X), hi = hi.cwiseMax(X);
  for (size_t i = 0; i < m.X_mm.size(); ++i)
    for (int a = 0; a < 3; ++a)
      if (const double x = m.X_mm[i][a]; at(x, lo[a]) || (high_sides && a < 2 && at(x, hi[a])))
        m.fixed[i] |= Held::axis(a);
}

StepReport to_rest(ElasticSolver& s, double tolerance = 1e-6, int most = 600) {
  StepSettings set;
  set.max_iterations = most, set.tolerance = tolerance;
  return s.step(set);
}

Vec3 sum(std::span<const SupportForce> forces) {
  Vec3 f = Vec3::Zero();
  for (const SupportForce& s : forces) f += s.force_mN;
  return f;
}

// A column between rollers under its own weight. In uniaxial strain P = (mu + lambda)(F - 1) for this law, so the
// solution of small strains holds for all: u = - rho g (L z - z^2 / 2) / M, M = E (1 - nu) / ((1 + nu)(1 - 2 nu)).
// Linear elements with lumped masses are exact at the nodes; between them they miss rho g h^2 / (8 M): order 2.
TEST(DeadLoads, AColumnUnderItsOwnWeight) {
  constexpr double length = 24, young = 60, density = 1e-6, g = 30;
  for (const double nu : {0.0, 0.3, 0.45}) {
    const double M = young * (1 - nu) / ((1 + nu) * (1 - 2 * nu));
    const auto exact = [&](double z) { return -density * 1000 * g * (length * z - z * z / 2) / M; };
    double before = 0;
    for (const int cells : {4, 8, 16}) {
      BoxSpec b;
      b.cells = {2, 2, cells}, b.size_mm = {6, 6, length}, b.poisson = nu, b.density_kg_mm3 = density;
      b.young_bottom_kPa = b.young_top_kPa = young;
      FemModel m = box_model(b);
      put_on_rollers(m);
      InlineWorkers w;
      auto solver = make_solver(w);
      solver->set_gravity({0, 0, -g});
      solver->set_model(std::make_shared<FemModel>(m), {});
      const StepReport r = to_rest(*solver);
      EXPECT_TRUE(r.converged) << nu << " " << cells << " " << r.residual;
      const double most = std::abs(exact(length));
      EXPECT_GT(most, 0.03);
      for (size_t i = 0; i < m.X_mm.size(); ++i) {
        const Vec3f u = solver->displacement_mm()[i];
        EXPECT_NEAR(double(u[2]), exact(m.X_mm[i][2]), 2e-4 * most) << nu << " " << cells;
        EXPECT_LT(u.head<2>().norm(), 2e-4 * most);
      }
      // Energy: half the potential of the weight, sum over lumped masses.
      double work = 0;
      for (size_t i = 0; i < m.X_mm.size(); ++i) work += m.mass_kg[i] * 1000 * g * exact(m.X_mm[i][2]);
      EXPECT_NEAR(r.energy_uJ, 0.5 * work, 1e-3 * std::abs(work));
      const double h = length / cells, z = length - h / 2;
      const double error = solver->position_mm(embed(m, {0, 0, z}))[2] - z - exact(z);
      EXPECT_NEAR(error, density * 1000 * g * h * h / (8 * M), 4e-4 * most) << nu << " " << cells;
      if (cells == 8) {
        EXPECT_NEAR(before / error, 4, 0.3) << nu;  // 16 cells: too near to single precision
      }
      before = error;
    }
  }
}

// Rollers on three sides, the fourth drawn out: a homogeneous state, lambda (J - 1) l + mu = mu l with J = l a^2, at
// any Poisson's ratio; the pull is the sum of the supports.
TEST(DeadLoads, UniaxialTensionOnRollers) {
  constexpr double l = 1.3;
  for (const double nu : {0.0, 0.3, 0.45, 0.499}) {
    BoxSpec b;
    b.cells = {6, 4, 4}, b.size_mm = {12, 8, 8}, b.poisson = nu;
    FemModel m = box_model(b);
    put_on_rollers(m, false);
    std::vector<Vec3f> u(m.X_mm.size(), Vec3f::Zero());
    for (size_t i = 0; i < m.X_mm.size(); ++i)
      if (at(m.X_mm[i][0], 6)) m.fixed[i] |= Held::axis(0), u[i][0] = float((l - 1) * 12);
    InlineWorkers w;
    auto solver = make_solver(w);
    solver->set_model(std::make_shared<FemModel>(m), {});
    solver->set_displacement_mm(u);
    const StepReport r = to_rest(*solver);
    EXPECT_LT(r.residual, 2e-6) << nu;
    const Elastic e = elastic_from_young(60, nu);
    const double J = 1 + e.mu_kPa * (l - 1) / (e.lambda_kPa * l), a = std::sqrt(J / l);
    for (size_t c = 0; c < m.cells.size(); ++c)
      EXPECT_LT((solver->cell_F(int32_t(c)) - Mat3(Vec3(l, a, a).asDiagonal())).norm(), 2e-4) << nu;
    for (size_t i = 0; i < m.X_mm.size(); ++i)
      for (int k = 0; k < 3; ++k)
        if (m.fixed[i].along(k)) {
          ASSERT_EQ(solver->displacement_mm()[i][k], u[i][k]) << "left its plane";
        }
    const double P = e.mu_kPa * l + (e.lambda_kPa * (J - 1) - e.mu_kPa) * a * a;
    double low = 0, high = 0;
    for (const SupportForce& f : solver->support_forces_mN())
      (at(m.X_mm[size_t(f.node)][0], 6) ? high : low) += f.force_mN[0];
    EXPECT_NEAR(high, -P * 64, 1e-3 * P * 64) << nu;
    EXPECT_NEAR(low, P * 64, 1e-3 * P * 64) << nu;
  }
}

/// A block with everything: weight, two loads, a hook, a cut, one side held, one on rollers, the bottom on rollers.
struct Loaded {
  FemModel model;
  std::vector<Spring> springs;
  std::vector<DeadLoad> loads;
  Vec3 gravity{3, -2, -9.81};
  explicit Loaded(bool divided, double nu = 0.45) {
    BoxSpec b;
    b.cells = {8, 6, 4}, b.size_mm = {24, 18, 10}, b.poisson = nu, b.density_kg_mm3 = 4e-6;
    b.young_bottom_kPa = 18;
    model = box_model(b);
    for (size_t i = 0; i < model.X_mm.size(); ++i) {
      const Vec3& X = std::as_const(model.X_mm)[i];
      if (at(X[0], -12)) model.fixed[i] = true;
      if (at(X[1], -9)) model.fixed[i] |= Held::axis(1);
      if (at(X[2], 0)) model.fixed[i] |= Held::axis(2);
    }
    Spring hook;
    hook.id = 1, hook.to_world = true, hook.k_N_per_mm = 0.3, hook.a = embed(model, {5, 2, 9.5});
    hook.target_mm = {9, 4, 16};
    springs = {hook};
    loads.resize(2);
    loads[0].at = {embed(model, {-3, 3, 9.9})}, loads[0].force_mN = {40, 0, -90};
    for (const double y : {-4.0, 0.0, 4.0}) loads[1].at.push_back(embed(model, {8, y, 9.9}));
    loads[1].force_mN = {-30, 60, 20};
    if (!divided) return;
    std::vector<int> level;  // nodes of whole cells keep their numbers
    for (const HexCell& c : std::as_const(model).cells)
      level.push_back(std::as_const(model.X_mm)[size_t(c.node[0])][0] > 2 && c.at[2] >= 4);
    model = test::divide(model, level).model;
    model.parent.assign(model.X_mm.size(), -1), model.born.clear();
  }
};

TEST(DeadLoads, SameEquilibriumAsNewton) {
  for (const bool divided : {false, true})
    for (const double nu : {0.3, 0.45}) {
      const Loaded s(divided, nu);
      InlineWorkers w;
      auto solver = make_solver(w);
      solver->set_gravity(s.gravity);
      solver->set_model(std::make_shared<FemModel>(s.model), {});
      solver->set_springs(s.springs);
      solver->set_loads(s.loads);
      const StepReport r = to_rest(*solver, 3e-6);
      EXPECT_TRUE(r.converged) << divided << " " << nu << " " << r.residual;
      const ReferenceElasticity reference(s.model, s.springs, {}, s.gravity, s.loads);
      const auto q = reference.solve(std::vector<Vec3>(s.model.X_mm.size(), Vec3::Zero()), {});
      ASSERT_TRUE(q.converged);
      double off = 0, far = 0;
      for (size_t i = 0; i < q.u.size(); ++i) {
        off = std::max(off, (solver->displacement_mm()[i].cast<double>() - q.u[i]).norm());
        far = std::max(far, q.u[i].norm());
      }
      EXPECT_GT(far, 1);
      EXPECT_LT(off, 2e-3) << divided << " " << nu;
      EXPECT_NEAR(r.energy_uJ, q.energy_uJ, 1e-4 * std::abs(q.energy_uJ));
      EXPECT_LT(r.distance_mm, 0.05);
    }
}

// The reference's own gradient is that of its energy, loads included.
TEST(DeadLoads, ForcesAreTheSlopeOfTheEnergy) {
  const Loaded s(false, 0.3);
  const ReferenceElasticity e(s.model, s.springs, {}, s.gravity, s.loads);
  std::vector<Vec3> u = test::random_displacement(s.model, 0.2, 5), g;
  e.gradient(u, g);
  for (const size_t i : {size_t(3), size_t(40), size_t(200)})
    for (int k = 0; k < 3; ++k) {
      std::vector<Vec3> a = u, b = u;
      a[i][k] += 1e-5, b[i][k] -= 1e-5;
      EXPECT_NEAR((e.energy(a) - e.energy(b)) / 2e-5, g[i][k], 1e-5 * (1 + std::abs(g[i][k])));
    }
}

// Supports, hooks, weight and loads, node by node and in sum.
TEST(DeadLoads, EverythingBalances) {
  for (const bool divided : {false, true}) {
    const Loaded s(divided);
    InlineWorkers w;
    auto solver = make_solver(w);
    solver->set_gravity(s.gravity);
    solver->set_model(std::make_shared<FemModel>(s.model), {});
    solver->set_springs(s.springs);
    solver->set_loads(s.loads);
    to_rest(*solver, 3e-6);
    const std::vector<SupportForce> support = solver->support_forces_mN();
    EXPECT_EQ(sum(support), solver->support_force_mN());
    size_t held = 0;
    for (const Held h : s.model.fixed) held += h.any();
    ASSERT_EQ(support.size(), held);
    double size = 0;
    for (const SupportForce& f : support) {
      size += f.force_mN.norm();
      for (int k = 0; k < 3; ++k)
        if (!s.model.fixed[size_t(f.node)].along(k)) {
          EXPECT_EQ(f.force_mN[k], 0);
        }
    }
    double mass = 0;
    for (double m : s.model.mass_kg) mass += m;
    Vec3 loads = 1000 * mass * s.gravity;
    EXPECT_GT(loads.norm(), 100);
    for (const DeadLoad& l : s.loads) loads += l.force_mN;
    EXPECT_LT((solver->load_force_mN() - loads).norm(), 1e-4 * loads.norm());
    EXPECT_LT((solver->spring_force_mN(1) + loads - sum(support)).norm(), 2e-5 * (size + loads.norm())) << divided;
  }
}

// A new model brings its own masses: here the half that has been taken away weighs nothing any more.
TEST(DeadLoads, WeightIsThatOfTheNewModel) {
  Loaded s(false);
  InlineWorkers w;
  auto solver = make_solver(w);
  solver->set_gravity({0, 0, -10});
  solver->set_model(std::make_shared<FemModel>(s.model), {});
  to_rest(*solver);
  const double all = solver->load_force_mN()[2];
  FemModel half = s.model;
  half.cells.clear();
  half.mass_kg.assign(half.X_mm.size(), 0);
  std::vector<int32_t> parent;
  for (size_t c = 0; c < s.model.cells.size(); ++c) {
    const HexCell& cell = std::as_const(s.model.cells)[c];
    if (s.model.X_mm[size_t(cell.node[0])][0] > -0.1) continue;
    half.cells.push_back(cell), parent.push_back(int32_t(c));
    const Stencil& st = std::as_const(s.model.stencils)[size_t(cell.stencil)];
    for (int32_t v : cell.node) half.mass_kg[size_t(v)] += st.density_kg_mm3 * st.volume_mm3 / 8;
  }
  half.parent = ParentList::identity(half.X_mm.size());
  ParentList cells;
  for (int32_t c : parent) cells.push_back(c);
  solver->set_model(std::make_shared<FemModel>(half), cells);
  to_rest(*solver);
  EXPECT_NEAR(solver->load_force_mN()[2], all / 2, 1e-4 * std::abs(all));
  EXPECT_NEAR(solver->support_force_mN()[2], all / 2, 1e-3 * std::abs(all));
}

// Free fall by backward Euler: after n steps u = g dt^2 n (n + 1) / 2. In quasi-static steps what nothing holds stays.
TEST(DeadLoads, WhatNothingHoldsFallsOnlyInTime) {
  BoxSpec b;
  b.cells = {3, 3, 3}, b.poisson = 0.3;
  const auto m = std::make_shared<FemModel>(box_model(b));
  InlineWorkers w;
  auto solver = make_solver(w);
  solver->set_gravity({1, 0, -9.81});
  solver->set_model(m, {});
  EXPECT_EQ(to_rest(*solver).iterations, 0);
  for (const Vec3f& u : solver->displacement_mm()) ASSERT_EQ(u.norm(), 0);
  EXPECT_EQ(solver->load_force_mN().norm(), 0);
  StepSettings s;
  s.dt_s = 1 / 60.0, s.max_iterations = 30, s.tolerance = 1e-6;
  constexpr int steps = 12;
  for (int i = 0; i < steps; ++i) solver->step(s);
  const Vec3 fallen = 1000 * Vec3(1, 0, -9.81) * s.dt_s * s.dt_s * steps * (steps + 1) / 2;
  for (const Vec3f& u : solver->displacement_mm()) EXPECT_LT((u.cast<double>() - fallen).norm(), 1e-5 * fallen.norm());

  // A hook holds it in every direction, a roller along its axis alone.
  auto hooked = make_solver(w);
  hooked->set_gravity({1, 0, -9.81});
  hooked->set_model(m, {});
  Spring hook;
  hook.id = 1, hook.to_world = true, hook.a = embed(*m, {0, 0, 10}), hook.target_mm = {0, 0, 10};
  hooked->set_springs({&hook, 1});
  const double weight = 1e-6 * 1000 * 1000 * 9.81;  // mN of 1000 mm^3
  EXPECT_NEAR(hooked->load_force_mN()[2], -weight, 1e-4 * weight);
  hooked->set_springs({});
  EXPECT_EQ(hooked->load_force_mN().norm(), 0);
  FemModel rolling = *m;
  for (size_t i = 0; i < rolling.X_mm.size(); ++i)
    if (at(std::as_const(rolling.X_mm)[i][2], 0)) rolling.fixed[i] = Held::axis(2);
  auto roller = make_solver(w);
  roller->set_gravity({1, 0, -9.81});
  roller->set_model(std::make_shared<FemModel>(rolling), {});
  EXPECT_NEAR(roller->load_force_mN()[2], -weight, 1e-4 * weight);
  EXPECT_EQ(roller->load_force_mN()[0], 0);
}

// A damped block that sways under its weight ends where the quasi-static one rests.
TEST(DeadLoads, DynamicStepsEndAtTheSameRest) {
  Loaded s(false, 0.3);
  InlineWorkers w;
  const auto model = std::make_shared<FemModel>(s.model);
  std::vector<std::unique_ptr<ElasticSolver>> solvers;
  for (int k = 0; k < 2; ++k) {
    solvers.push_back(make_solver(w));
    solvers[size_t(k)]->set_gravity(s.gravity), solvers[size_t(k)]->set_model(model, {});
    solvers[size_t(k)]->set_springs(s.springs), solvers[size_t(k)]->set_loads(s.loads);
  }
  to_rest(*solvers[0], 3e-6);
  StepSettings t;
  t.dt_s = 0.05, t.max_iterations = 40, t.tolerance = 1e-6, t.damping_per_s = 20;
  for (int i = 0; i < 120; ++i) solvers[1]->step(t);
  double off = 0;
  for (size_t i = 0; i < s.model.X_mm.size(); ++i)
    off = std::max(off, double((solvers[0]->displacement_mm()[i] - solvers[1]->displacement_mm()[i]).norm()));
  EXPECT_LT(off, 0.01);
}

// Rollers cost no iterations: each component has the operator of its own boundary.
TEST(ComponentMetric, RollersConvergeAsHeldSidesDo) {
  const auto iterations = [](bool rollers, fem::MetricPolicy policy) {
    BoxSpec b;
    b.cells = {14, 14, 8}, b.size_mm = {42, 42, 24}, b.poisson = 0.45;
    b.fix_sides = b.fix_bottom = !rollers;
    FemModel m = box_model(b);
    if (rollers) put_on_rollers(m);
    InlineWorkers w;
    fem::LbfgsSolver solver(w, true, policy);
    Spring hook;
    hook.id = 1, hook.to_world = true, hook.a = embed(m, {3, 2, 23.9}), hook.target_mm = {8, 4, 34};
    solver.set_gravity({0, 0, -9.81});
    solver.set_model(std::make_shared<FemModel>(m), {});
    solver.set_springs({&hook, 1});
    return to_rest(solver, 1e-5, 2000).iterations;
  };
  for (const int32_t factor_up_to : {0, 10000}) {
    fem::MetricPolicy policy;
    policy.factor_up_to_nodes = factor_up_to;
    const int held = iterations(false, policy), rolling = iterations(true, policy);
    RecordProperty("held_" + std::to_string(factor_up_to), held);
    RecordProperty("rolling_" + std::to_string(factor_up_to), rolling);
    EXPECT_LT(rolling, 1.6 * held + 10) << held << " " << factor_up_to;
  }
}

TEST(ComponentMetric, OneOperatorForEachWayToBeHeld) {
  InlineWorkers w;
  BoxSpec b;
  b.cells = {4, 4, 4}, b.fix_bottom = true;
  FemModel m = box_model(b);
  fem::ComponentMetric metric(w);
  metric.set_model(std::make_shared<FemModel>(m), {});
  EXPECT_EQ(metric.operators(), 1u);
  for (size_t i = 0; i < m.X_mm.size(); ++i)
    if (at(std::as_const(m.X_mm)[i][0], 5)) m.fixed[i] |= Held::axis(0);
  metric.set_model(std::make_shared<FemModel>(m), {});
  EXPECT_EQ(metric.operators(), 2u);
  for (size_t i = 0; i < m.X_mm.size(); ++i)
    if (at(std::as_const(m.X_mm)[i][1], 5)) m.fixed[i] |= Held::axis(1);
  metric.set_model(std::make_shared<FemModel>(m), {});
  EXPECT_EQ(metric.operators(), 3u);
  metric.set_springs({});
  metric.begin_step(0, 3, false);
  NodeArray r(m.X_mm.size()), z(m.X_mm.size());
  test::Random draw(3);
  for (size_t i = 0; i < r.size(); ++i)
    for (int k = 0; k < 3; ++k)
      if (!m.fixed[i].along(k)) (&r[i].x)[k] = float(draw.uniform());
  metric.apply(r, z);
  double product = 0;
  for (size_t i = 0; i < r.size(); ++i)
    for (int k = 0; k < 3; ++k) {
      product += double((&r[i].x)[k]) * double((&z[i].x)[k]);
      if (m.fixed[i].along(k)) {
        EXPECT_EQ((&z[i].x)[k], 0);
      }
    }
  EXPECT_GT(product, 0);
}

// A region is the whole with its outside held: weight and loads too.
TEST(DeadLoads, InARegion) {
  Loaded s(false);
  for (size_t c = 0; c < s.model.cells.size(); ++c) {
    HexCell cell = std::as_const(s.model.cells)[c];
    if (s.model.X_mm[size_t(cell.node[0])][0] > -8.9) continue;
    for (int32_t v : cell.node) s.model.fixed[size_t(v)] = true;
    cell.scale = 0;
    s.model.cells[c] = cell;
  }
  InlineWorkers w;
  auto whole = make_solver(w);
  fem::RegionSolver part(make_solver(w));
  for (ElasticSolver* e : {whole.get(), static_cast<ElasticSolver*>(&part)}) {
    e->set_model(std::make_shared<FemModel>(s.model), {});
    e->set_gravity(s.gravity);
    e->set_springs(s.springs);
    e->set_loads(s.loads);
    to_rest(*e, 3e-6);
  }
  EXPECT_EQ(part.loads().size(), 2u);
  double off = 0;
  for (size_t i = 0; i < s.model.X_mm.size(); ++i)
    off = std::max(off, double((whole->displacement_mm()[i] - part.displacement_mm()[i]).norm()));
  EXPECT_LT(off, 1e-3);
  Vec3 hook = part.spring_force_mN(1);
  EXPECT_LT((hook + part.load_force_mN() - part.support_force_mN()).norm(), 1);
  for (const SupportForce& f : part.support_forces_mN())
    if (f.node >= 0) {
      EXPECT_TRUE(s.model.fixed[size_t(f.node)].any());
    }
}

TEST(DeadLoads, BadOnesAreRefused) {
  const Loaded s(false);
  InlineWorkers w;
  auto solver = make_solver(w);
  EXPECT_THROW(solver->set_loads(s.loads), InputError);
  solver->set_model(std::make_shared<FemModel>(s.model), {});
  EXPECT_THROW(solver->set_gravity({0, NAN, 0}), InputError);
  std::vector<DeadLoad> bad(1);
  EXPECT_THROW(solver->set_loads(bad), InputError);
  bad = s.loads, bad[1].at[0].node[3] = int32_t(s.model.X_mm.size());
  EXPECT_THROW(solver->set_loads(bad), InputError);
  bad = s.loads, bad[0].force_mN[1] = INFINITY;
  EXPECT_THROW(solver->set_loads(bad), InputError);
  EXPECT_EQ(solver->loads().size(), 0u);
}

}  // namespace test_dead_loads
}  // namespace limberg
