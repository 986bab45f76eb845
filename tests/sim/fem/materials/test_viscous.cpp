// Relaxation against the analytic Prony series, and what must hold besides: rest stays rest, states come back, nothing
// costs anything where nothing relaxes.
#include <gtest/gtest.h>

#include <cstring>

#include "../models.h"
#include "sim/fem/elements/material_points.h"
#include "sim/fem/elements/viscous_points.h"
#include "sim/fem/materials/fibres.h"
#include "sim/fem/materials/isotropic.h"

namespace limberg {
namespace test_viscous {

constexpr double kMu = 20, kNu = 0.499;

/// A bar of 10 x 5 x 5 mm, nothing held.
FemModel bar(const std::vector<ViscousPoint::Term>& terms, LawPtr fibres = nullptr, const Mat3& M = Mat3::Identity()) {
  BoxSpec b;
  b.cells = {4, 2, 2};
  b.size_mm = {10, 5, 5};
  b.poisson = kNu, b.young_top_kPa = b.young_bottom_kPa = 2 * (1 + kNu) * kMu;
  FemModel m = box_model(b);
  const LawPtr matrix = neo_hookean(kMu);
  m.laws = {fibres ? sum_of({matrix, fibres}) : matrix};
  if (fibres) m.laws.push_back(fibres);
  for (Stencil& s : m.stencils) {
    s = box_stencil(m.cell_mm, elastic_from_young(2 * (1 + kNu) * kMu, kNu), 1e-6, M);
    if (fibres) {
      MaterialPoint p;
      p.volume_mm3 = s.volume_mm3, p.law = 1, p.M = M;
      s.points = {p};
      s.p0_kPa += (fibres->at(M).P_kPa * M.transpose())(2, 2);
    }
    if (!terms.empty()) s.viscous = {{Vec3::Constant(0.5), s.volume_mm3, 0, M, terms}};
  }
  return m;
}

EmbeddedPoint at_node(size_t i) {
  EmbeddedPoint p;
  p.node.fill(int32_t(i)), p.w[0] = 1;
  return p;
}

/// Both ends held by stiff springs at uniform uniaxial stretch l: no force across, so the state stays uniform.
std::vector<Spring> grips(const FemModel& m, double l, double lateral) {
  std::vector<Spring> s;
  for (size_t i = 0; i < m.X_mm.size(); ++i) {
    if (std::fabs(m.X_mm[i][0]) < 4.999) continue;
    Spring k;
    k.id = int32_t(i) + 1, k.to_world = true, k.a = at_node(i), k.k_N_per_mm = 100;
    k.target_mm = Vec3(l * m.X_mm[i][0], lateral * m.X_mm[i][1], (m.X_mm[i][2] - 2.5) / (l * lateral) + 2.5);
    s.push_back(k);
  }
  return s;
}

double pull_mN(const ElasticSolver& solver, const FemModel& m) {
  double f = 0;
  for (size_t i = 0; i < m.X_mm.size(); ++i)
    if (m.X_mm[i][0] > 4.999) f += solver.spring_force_mN(int32_t(i) + 1)[0];
  return f;
}

StepSettings dynamic(double dt) {
  StepSettings s;
  s.max_iterations = 300, s.tolerance = 2e-6, s.dt_s = dt;
  return s;
}

struct Case {
  const char* name;
  LawPtr fibres;
  double lateral;  // of a stretch of 1.2
  Integrator integrator = Integrator::backward_euler;
};

// A sudden stretch of 20 %, held: the force is the relaxed one times 1 + sum ratio exp(-t / time). The jump is taken in
// the middle of the first step.
// The energy of a step in the middle of a history, against central differences of itself (single precision).
TEST(Viscous, ForceIsTheDerivativeOfTheEnergy) {
  const FemModel m = bar({{0.8, 0.5}, {0.5, 4}}, dispersed_fibres({100, 1, 0.1}, {{Vec3::UnitX()}}));
  InlineWorkers one;
  const fem::Engine engine(one);
  fem::ViscousPoints points(m);
  const auto nodes = [](const std::vector<Vec3>& u) {
    NodeArray a(u.size());
    for (size_t i = 0; i < u.size(); ++i) a[i] = {float(u[i][0]), float(u[i][1]), float(u[i][2]), 0};
    return a;
  };
  for (uint64_t seed : {1, 2, 3}) {
    points.begin_step(0.2);
    points.end_step(nodes(test::random_displacement(m, 0.3, seed)));
  }
  points.begin_step(0.1);
  const auto u = test::random_displacement(m, 0.3, 4), d = test::random_displacement(m, 1, 5);
  const auto energy = [&](double t, NodeArray& g) {
    auto v = u;
    for (size_t i = 0; i < v.size(); ++i) v[i] += t * d[i];
    g.zero();
    return points.add(nodes(v), g, false, engine).energy;
  };
  NodeArray g(u.size()), unused(u.size());
  energy(0, g);
  double exact = 0, size = 0;
  for (size_t i = 0; i < u.size(); ++i) {
    const Vec3 f(double(g[i].x), double(g[i].y), double(g[i].z));
    exact += f.dot(d[i]), size += f.norm() * d[i].norm();
  }
  const double h = 1e-3;  // displacements are floats: 3e-8 mm of rounding
  EXPECT_NEAR((energy(h, unused) - energy(-h, unused)) / (2 * h), exact, 2e-4 * size);
  EXPECT_GT(std::fabs(exact), 0.01 * size);
}

TEST(Viscous, AHeldStripRelaxesByItsPronySeries) {
  const std::vector<ViscousPoint::Term> terms = {{0.8, 0.5}, {0.5, 4}};
  const double l = 1.2, t = 1 / std::sqrt(l);
  const LawPtr along = dispersed_fibres({100, 1, 0.1}, {{Vec3::UnitX()}});
  for (const Case& c : {Case{"neo-Hookean", nullptr, t}, Case{"fibres along", along, t},
                        Case{"fibres along, BDF2", along, t, Integrator::bdf2}}) {
    const FemModel m = bar(terms, c.fibres);
    InlineWorkers one;
    auto solver = make_solver(one);
    solver->set_model(std::make_shared<FemModel>(m), {});
    solver->set_springs(grips(m, l, c.lateral));
    const double dt = 0.1;
    std::vector<double> force;
    for (int n = 0; n < 100; ++n) {
      StepSettings moving = dynamic(dt);
      moving.integrator = c.integrator;
      EXPECT_LE(solver->step(moving).residual, 1e-4);  // the stiff grips' rounding: 2.4e-5 measured
      force.push_back(pull_mN(*solver, m));
    }
    StepSettings still;
    still.max_iterations = 500, still.tolerance = 1e-6;
    solver->step(still);
    const double relaxed = pull_mN(*solver, m);
    if (!c.fibres) {
      EXPECT_NEAR(relaxed, kMu * (l - 1 / (l * l)) * 25,
                  0.01 * kMu * (l - 1 / (l * l)) * 25);  // nominal, incompressible
    }
    for (size_t n = 0; n < force.size(); ++n) {
      const double time = (double(n) + 0.5) * dt;
      double factor = 1;
      for (const auto& p : terms) factor += p.ratio * std::exp(-time / p.time_s);
      EXPECT_NEAR(force[n] / relaxed, factor, 0.01 * factor) << c.name << " at " << time << " s";
    }
  }
}

// A constant load, then none: the standard linear solid. Strain of 1 %.
TEST(Viscous, CreepAndRecovery) {
  const double r = 1.2, tau = 1, dt = 0.05, on_s = 3;
  const FemModel m = bar({{r, tau}});
  InlineWorkers one;
  auto solver = make_solver(one);
  solver->set_model(std::make_shared<FemModel>(m), {});
  const double E = 2 * (1 + kNu) * kMu, load = 0.01 * E * 25;  // mN
  std::vector<Spring> springs;
  for (size_t i = 0; i < m.X_mm.size(); ++i) {
    const Vec3& X = m.X_mm[i];
    if (std::fabs(X[0]) < 4.999) continue;
    const double share = (std::fabs(X[1]) > 2.4 ? 0.25 : 0.5) * (std::fabs(X[2] - 2.5) > 2.4 ? 0.25 : 0.5);
    Spring k;  // so far away that its force does not change
    k.id = int32_t(i) + 1, k.to_world = true, k.a = at_node(i), k.k_N_per_mm = load * share * 1e-3 / 1e4;
    k.target_mm = X + Vec3(std::copysign(1e4, X[0]), 0, 0);
    springs.push_back(k);
  }
  solver->set_springs(springs);
  const auto strain = [&] {
    double d = 0;
    int n = 0;
    for (size_t i = 0; i < m.X_mm.size(); ++i)
      if (std::fabs(m.X_mm[i][0]) > 4.999)
        d += double(solver->displacement_mm()[i][0]) * (m.X_mm[i][0] > 0 ? 1 : -1), ++n;
    return 2 * d / n / 10;
  };
  const auto creep = [&](double t) { return t <= 0 ? 0.0 : 0.01 * (1 - r / (1 + r) * std::exp(-t / (tau * (1 + r)))); };
  for (int n = 0; n < 120; ++n) {
    if (n * dt > on_s - 1e-9 && !springs.empty()) springs.clear(), solver->set_springs(springs);
    solver->step(dynamic(dt));
    const double t = (n + 0.5) * dt, expected = creep(t) - creep(t - on_s);
    EXPECT_NEAR(strain(), expected, 0.01 * 0.01) << t;  // of the full strain; geometry is linear to about 1 % of it
  }
}

// Prestretched skin with relaxation under a free surface: a flat piece stays where it is.
TEST(Viscous, RestStaysRest) {
  const Mat3 M = Vec3(1.15, 1.05, 1 / (1.15 * 1.05)).asDiagonal();
  FemModel m = bar({{1.5, 0.2}}, dispersed_fibres({80, 2, 0.2}, {{{0.75, 0.66, 0}}, {{0.75, -0.66, 0}}}), M);
  for (size_t i = 0; i < m.X_mm.size(); ++i)
    m.fixed[i] = std::fabs(m.X_mm[i][0]) > 4.999 || std::fabs(m.X_mm[i][1]) > 2.499;
  InlineWorkers one;
  auto solver = make_solver(one);
  solver->set_model(std::make_shared<FemModel>(m), {});
  for (int n = 0; n < 20; ++n) solver->step(dynamic(0.05));
  for (const Vec3f& u : solver->displacement_mm()) EXPECT_LT(u.norm(), 1e-4f);
}

// States come back, new models of the same tissue go on, and the number of workers changes nothing.
TEST(Viscous, StatesComeBackAndAreCarriedOn) {
  const FemModel m = bar({{0.8, 0.5}});
  const auto shared = std::make_shared<FemModel>(m);
  const auto run = [&](Workers& w, bool new_model) {
    auto solver = make_solver(w);
    solver->set_model(shared, {});
    solver->set_springs(grips(m, 1.2, 0.9));
    for (int n = 0; n < 5; ++n) solver->step(dynamic(0.1));
    if (new_model) {
      FemModel again = m;
      again.parent = ParentList::identity(again.parent.size());
      solver->set_model(std::make_shared<FemModel>(again), test::identity_parents(m));
      solver->set_springs(grips(m, 1.2, 0.9));
    }
    return solver;
  };
  InlineWorkers one;
  test::ThreadWorkers two(2);
  auto a = run(one, false), b = run(two, false), c = run(one, true);
  const SolverState state = a->save();
  EXPECT_FALSE(state.memory.empty());
  EXPECT_EQ(state, b->save());
  EXPECT_EQ(state.memory, c->save().memory);
  const auto go_on = [&] {
    for (int n = 0; n < 5; ++n) a->step(dynamic(0.1));
    return a->save();
  };
  a->restore(state);
  const SolverState first = go_on();
  a->restore(state);
  EXPECT_EQ(first, go_on());
  EXPECT_NE(first.memory, state.memory);
  SolverState broken = state;
  broken.memory.pop_back();
  EXPECT_ANY_THROW(a->restore(broken));
}

TEST(Viscous, TissueTurnedInsideOutComesBack) {
  FemModel m = bar({{1.5, 0.2}});
  for (size_t i = 0; i < m.X_mm.size(); ++i) m.fixed[i] = m.X_mm[i][0] < -4.999;
  InlineWorkers one;
  auto solver = make_solver(one);
  solver->set_model(std::make_shared<FemModel>(m), {});
  test::Random r(4);
  std::vector<Vec3f> u;
  for (size_t i = 0; i < m.X_mm.size(); ++i)
    u.push_back(m.fixed[i] ? Vec3f(0, 0, 0) : Vec3f(r.vector(8).cast<float>()));
  solver->set_displacement_mm(u);
  StepReport last;
  for (int n = 0; n < 60; ++n) last = solver->step(dynamic(0.1));
  EXPECT_GT(last.min_J, 0.9);
  for (const Vec3f& v : solver->displacement_mm()) EXPECT_LT(v.norm(), 0.1f);
}

// The loop for neo-Hookean layers against the one that asks the law (a sum of one
// law is no neo-Hookean to it): six points in every cell, prestretch, a history,
// and displacements that turn some cells inside out. Every instruction set.
TEST(Viscous, NeoHookeanLoopAgreesWithTheLaw) {
  const Mat3 M = Vec3(1.2, 1.1, 1 / (1.2 * 1.1)).asDiagonal();
  FemModel closed = bar({{0.8, 0.5}, {0.5, 4}}, nullptr, M), asked;
  for (Stencil& s : closed.stencils)
    for (int q = 1; q < 6; ++q) {
      ViscousPoint p = s.viscous[0];
      p.at = Vec3(0.1 * q, 0.9 - 0.15 * q, q % 2 ? 0.2 : 0.7), p.volume_mm3 *= 0.3 + 0.1 * q;
      s.viscous.push_back(p);
    }
  asked = closed;
  asked.laws[0] = sum_of({closed.laws[0]});
  InlineWorkers one;
  for (const fem::Kernels* set : fem::available_kernels()) {
    const fem::Engine engine(one, *set);
    fem::ViscousPoints a(closed), b(asked);
    const auto compare = [&](double size, uint64_t seed) {
      NodeArray u(closed.X_mm.size()), ga(u.size()), gb(u.size());
      const auto from = test::random_displacement(closed, size, seed);
      for (size_t i = 0; i < u.size(); ++i) u[i] = {float(from[i][0]), float(from[i][1]), float(from[i][2]), 0};
      const fem::CellSums ea = a.add(u, ga, true, engine), eb = b.add(u, gb, true, engine);
      EXPECT_NEAR(ea.energy, eb.energy, 1e-6 * eb.magnitude) << set->name;
      double apart = 0, norm = 0;
      for (size_t i = 0; i < u.size(); ++i) {
        const v4 d = load(ga[i]) - load(gb[i]), f = load(gb[i]);
        for (int k = 0; k < 4; ++k) apart += double(d[k]) * double(d[k]), norm += double(f[k]) * double(f[k]);
      }
      EXPECT_LT(std::sqrt(apart / norm), 2e-6) << set->name << ", displacements of " << size;
      return u;
    };
    for (uint64_t step = 1; step < 5; ++step) {
      a.begin_step(0.1), b.begin_step(0.1);
      compare(0.05, 7 * step), compare(3, 7 * step + 1);
      const NodeArray u = compare(0.3, 7 * step + 2);
      a.end_step(u), b.end_step(u);
      for (size_t i = 0; i < a.memory().size(); ++i) EXPECT_NEAR(a.memory()[i], b.memory()[i], 1e-5 * kMu);
    }
  }
}

// What a quasi-static step leaves is worked out when asked for: whether and when somebody asks changes no bit.
TEST(Viscous, AskingForTheMemoryChangesNothing) {
  const FemModel m = bar({{0.8, 0.5}});
  const auto run = [&](bool asked) {
    InlineWorkers one;
    auto solver = make_solver(one);
    solver->set_model(std::make_shared<FemModel>(m), {});
    StepSettings still;
    still.max_iterations = 7;
    for (int n = 0; n < 6; ++n) {
      solver->set_springs(grips(m, 1 + 0.03 * n, 1));
      solver->step(n == 3 ? dynamic(0.1) : still);
      if (asked) {
        EXPECT_FALSE(solver->memory().empty());
      }
    }
    return solver->save();
  };
  EXPECT_EQ(run(true), run(false));
}

TEST(Viscous, NothingThatRelaxesNothingToRemember) {
  InlineWorkers one;
  auto solver = make_solver(one);
  solver->set_model(std::make_shared<FemModel>(bar({})), {});
  solver->step(dynamic(0.1));
  EXPECT_TRUE(solver->memory().empty() && solver->save().memory.empty());
}

}  // namespace test_viscous
}  // namespace limberg
