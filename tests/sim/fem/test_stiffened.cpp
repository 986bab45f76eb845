// Material that has become far stiffer than its metric, or carries more pressure than its penalty: it comes to rest.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "models.h"
#include "sim/fem/elements/material_points.h"
#include "sim/fem/materials/fibres.h"
#include "sim/fem/materials/isotropic.h"
#include "sim/fem/solver/lbfgs_solver.h"
#include "sim/fem/solver/metric_scale.h"
#include "sim/fem/solver/stall_watch.h"
#include "sim/testing/reference_newton.h"

namespace limberg {
namespace test_stiffened {

struct Skin {
  const char* name;
  double mu_kPa, k1_kPa, k2, kappa, angle_deg;
  int families;
};
const Skin cheek{"skin/cheek", 18, 100, 2, 0.2, 41, 2}, one_family{"set G2", 10, 100, 1, 0.1, 0, 1},
    steep{"steep", 20, 50, 1.5, 0.15, 45, 2};

/// A cube of n cells of 2 mm a side, of fibres in a matrix of that Poisson's ratio; nothing is held.
FemModel cube(const Skin& skin, int n, double nu) {
  BoxSpec b;
  b.cells = {n, n, n}, b.size_mm = Vec3::Constant(2.0 * n);
  FemModel m = box_model(b);
  const double a = skin.angle_deg * std::numbers::pi / 180;
  std::vector<FibreFamily> families{{{std::cos(a), std::sin(a), 0}}};
  if (skin.families == 2) families.push_back({{std::cos(a), -std::sin(a), 0}});
  const LawPtr law = sum_of({neo_hookean(skin.mu_kPa), dispersed_fibres({skin.k1_kPa, skin.k2, skin.kappa}, families)});
  m.laws = {law};
  for (Stencil& s : m.stencils) s = fem::law_stencil(m.cell_mm, 0, *law, skin.mu_kPa * (2 * nu / (1 - 2 * nu) + 1));
  return m;
}

bool on_a_side(const FemModel& m, size_t i, int n) {
  return std::max(std::fabs(m.X_mm[i][0]), std::fabs(m.X_mm[i][1])) > n - 1e-6;
}

struct Rest {
  StepReport report;
  double off_mm = 0;  // of the node farthest from where full Newton in double brings it
};

Rest rest(const FemModel& m, const std::vector<Spring>& springs, const std::vector<Vec3f>& start) {
  InlineWorkers w;
  fem::LbfgsSolver solver(w);
  solver.set_model(std::make_shared<FemModel>(m), {});
  solver.set_displacement_mm(start);
  solver.set_springs(springs);
  StepSettings s;
  s.max_iterations = 1000, s.tolerance = 1e-5;
  Rest r{solver.step(s)};
  std::vector<Vec3> from;
  for (const Vec3f& u : start) from.push_back(u.cast<double>());
  const auto exact = ReferenceElasticity(m, springs).solve(from, {});
  EXPECT_LT(exact.residual, 1e-10);
  for (size_t i = 0; i < from.size(); ++i)
    r.off_mm = std::max(r.off_mm, (solver.displacement_mm()[i].cast<double>() - exact.u[i]).norm());
  return r;
}

/// The sides are pulled to an equibiaxial stretch of 1.5, thickness 1/2.25, by springs of 5 N/mm; top and base free.
Rest pulled_by_springs(const Skin& skin, int n, double nu) {
  const FemModel m = cube(skin, n, nu);
  std::vector<Spring> springs;
  for (size_t i = 0; i < m.X_mm.size(); ++i) {
    if (!on_a_side(m, i, n)) continue;
    Spring& p = springs.emplace_back();
    p.id = int32_t(i) + 1, p.to_world = true, p.a = embed(m, m.X_mm[i]), p.k_N_per_mm = 5;
    p.target_mm = Vec3(1.5, 1.5, 1 / 2.25).cwiseProduct(m.X_mm[i]);
  }
  return rest(m, springs, std::vector<Vec3f>(m.X_mm.size(), Vec3f::Zero()));
}

/// The sides are held at a stretch of 1.5 both ways, and at their thickness: cells there must grow in volume.
Rest held_at_thickness(FemModel m, int n) {
  std::vector<Vec3f> start(m.X_mm.size(), Vec3f::Zero());
  for (size_t i = 0; i < m.X_mm.size(); ++i)
    if (on_a_side(m, i, n)) m.fixed[i] = 1, start[i] = {0.5f * float(m.X_mm[i][0]), 0.5f * float(m.X_mm[i][1]), 0};
  return rest(m, {}, start);
}

// The metric is the stiffness at rest. Before it was scaled: 2,705 iterations to residual .03, 2,983 to .13.
TEST(Stiffened, FibresPulledToOneAndAHalfComeToRest) {
  for (const double nu : {0.49, 0.499}) {
    const Rest r = pulled_by_springs(one_family, 6, nu);
    EXPECT_TRUE(r.report.converged) << nu << " residual " << r.report.residual;
    EXPECT_LT(r.report.iterations, 500) << nu;
    EXPECT_LT(r.off_mm, 2e-3) << nu;
  }
}

// Multipliers of up to fifty times the penalty. Before these were told from others: residuals of 4e-4, .03 and 7e-4
// after 2,000 iterations and more.
TEST(Stiffened, PressuresBeyondThePenaltyComeToRest) {
  for (const auto& [skin, n, nu] :
       {std::tuple{&cheek, 2, 0.49}, {&steep, 4, 0.499}, {&cheek, 4, 0.499}, {&one_family, 2, 0.499}}) {
    const Rest r = held_at_thickness(cube(*skin, n, nu), n);
    EXPECT_TRUE(r.report.converged) << skin->name << " " << n << " residual " << r.report.residual;
    EXPECT_LT(r.report.iterations, 300) << skin->name << " " << n;
    EXPECT_LT(r.off_mm, 5e-4) << skin->name << " " << n;
  }
}

// Near rest, energies cannot be told apart. Where a slope of .9998 of the first was taken there, at the far side of the
// valley, the residual stayed between 5e-5 and 2e-4 for 2,000 iterations.
TEST(Stiffened, StepsInTheNoiseOfTheEnergyStillLeadOn) {
  for (const double nu : {0.47, 0.49, 0.495, 0.499}) {
    BoxSpec b;
    b.cells = {4, 4, 4}, b.size_mm = Vec3::Constant(8);
    FemModel m = box_model(b);
    for (Stencil& s : m.stencils) s = box_stencil(m.cell_mm, {18, 18 * (2 * nu / (1 - 2 * nu) + 1)});
    const Rest r = held_at_thickness(m, 4);
    EXPECT_TRUE(r.report.converged) << nu << " residual " << r.report.residual;
    EXPECT_LT(r.report.iterations, 500) << nu;
    EXPECT_LT(r.off_mm, 1e-4) << nu;
  }
}

// The plain energy is that of the reference, and the multipliers that it leaves give the same forces.
TEST(Stiffened, ThePlainEnergyIsTheAugmentedOneAtItsFixedPoint) {
  BoxSpec b;
  b.cells = {4, 3, 3}, b.size_mm = {8, 6, 6}, b.poisson = 0.49;
  const FemModel m = box_model(b);
  const auto u = test::random_displacement(m, 0.15, 5);
  NodeArray at(u.size()), plain(u.size()), augmented(u.size());
  for (size_t i = 0; i < u.size(); ++i) at[i] = {float(u[i][0]), float(u[i][1]), float(u[i][2]), 0};
  fem::ElementSystem system(std::make_shared<FemModel>(m));
  const double energy_before = system.evaluate(at, augmented, false, test::engine()).energy + system.energy_to_primal();
  system.plain(true);
  const double energy = system.evaluate(at, plain, false, test::engine()).energy;
  EXPECT_EQ(system.energy_to_primal(), 0);
  EXPECT_FALSE(system.update_multipliers(test::engine()));
  system.plain(false);
  const double energy_after = system.evaluate(at, augmented, false, test::engine()).energy + system.energy_to_primal();
  std::vector<Vec3> g, rounded;
  for (size_t i = 0; i < u.size(); ++i) rounded.emplace_back(double(at[i].x), double(at[i].y), double(at[i].z));
  const double exact = ReferenceElasticity(m, {}).gradient(rounded, g);
  for (const double e : {energy_before, energy, energy_after}) EXPECT_NEAR(e, exact, 3e-6 * exact);
  double size = 0;
  for (const Vec3& v : g) size = std::max(size, v.norm());
  for (size_t i = 0; i < u.size(); ++i)
    for (const NodeArray* f : {&plain, &augmented})
      EXPECT_LT((Vec3((*f)[i].x, (*f)[i].y, (*f)[i].z) - g[i]).norm(), 1e-5 * size);
}

TEST(Stiffened, OneCellInSixtyFourIsOverloaded) {
  BoxSpec b;
  b.cells = {8, 4, 4}, b.poisson = 0.49;
  fem::ElementSystem system(std::make_shared<FemModel>(box_model(b)));
  EXPECT_FALSE(system.overloaded());
  system.set_q(7, 3), system.set_q(9, 1.9f);
  EXPECT_FALSE(system.overloaded()) << "one in 128, another near the bar";
  system.set_q(9, -2.1f);
  EXPECT_TRUE(system.overloaded());
  b.poisson = 0.3;  // no multipliers
  fem::ElementSystem soft(std::make_shared<FemModel>(box_model(b)));
  for (size_t c = 0; c < soft.cells(); ++c) soft.set_q(c, 3);
  EXPECT_FALSE(soft.overloaded());
}

// A state saved while the plain energy is at work is in balance for another solver.
TEST(Stiffened, AStateUnderTooMuchPressureIsStillInBalanceElsewhere) {
  FemModel m = cube(cheek, 2, 0.49);
  std::vector<Vec3f> start(m.X_mm.size(), Vec3f::Zero());
  for (size_t i = 0; i < m.X_mm.size(); ++i)
    if (on_a_side(m, i, 2)) m.fixed[i] = 1, start[i] = {0.5f * float(m.X_mm[i][0]), 0.5f * float(m.X_mm[i][1]), 0};
  const auto model = std::make_shared<FemModel>(m);
  InlineWorkers w;
  fem::LbfgsSolver first(w), second(w);
  for (auto* s : {&first, &second}) s->set_model(model, {}), s->set_displacement_mm(start);
  StepSettings s;
  s.max_iterations = 500, s.tolerance = 1e-5;
  ASSERT_TRUE(first.step(s).converged);
  const SolverState state = first.save();
  float most = 0;
  for (float q : state.pressure) most = std::max(most, std::fabs(q));
  EXPECT_GT(most, 2) << "no such state";
  second.restore(state);
  s.max_iterations = 0;
  EXPECT_LT(second.step(s).residual, 1.5e-5);
  EXPECT_EQ(second.save().pressure, first.save().pressure);
}

// A quadratic a hundred times stiffer than its metric says: one pair tells it, and all directions are right at once.
TEST(LbfgsHistory, TheNewestPairScalesTheMetric) {
  const size_t n = 5;
  fem::LbfgsHistory history;
  history.resize(n, 5);
  const auto metric = [](const NodeArray& r, NodeArray& z) {
    for (size_t i = 0; i < r.size(); ++i)
      z[i] = {r[i].x / float(i + 1), r[i].y / float(i + 1), r[i].z / float(i + 1), 0};
  };
  test::Random random(3);
  NodeArray g(n), d(n);
  for (Node4& v : g) v = {float(random.uniform()), float(random.uniform()), float(random.uniform()), 0};
  EXPECT_EQ(history.direction(g, d, metric, test::engine(), true), 1) << "no pair yet";
  NodeArray &s = history.next_s(), &y = history.next_y();
  for (size_t i = 0; i < n; ++i) {
    s[i] = {float(random.uniform()), float(random.uniform()), float(random.uniform()), 0};
    const float k = 100 * float(i + 1);
    y[i] = {k * s[i].x, k * s[i].y, k * s[i].z, 0};
  }
  ASSERT_TRUE(history.push(test::engine()));
  EXPECT_NEAR(history.direction(g, d, metric, test::engine(), true), 0.01, 1e-7);
  for (size_t i = 0; i < n; ++i) EXPECT_NEAR(d[i].x, -g[i].x / (100 * float(i + 1)), 1e-7);
  EXPECT_EQ(history.direction(g, d, metric, test::engine()), 1);
  EXPECT_GT(std::fabs(d[0].x + g[0].x / 100), 1e-3) << "not scaled where not asked for";
}

TEST(MetricScale, CutStepsInARowTurnItOnAndAGoodMetricOff) {
  fem::MetricScale scale;
  const auto times = [&](int n, bool cut, double gamma) {
    for (int i = 0; i < n; ++i) scale.accepted(cut, gamma);
  };
  constexpr int k = fem::MetricScale::kInARow;
  times(k - 1, true, 1), times(1, false, 1), times(k - 1, true, 1);
  EXPECT_FALSE(scale.on());
  times(1, true, 1);
  EXPECT_TRUE(scale.on());
  times(50, true, 0.4), times(k - 1, false, 0.6), times(1, true, 0.4), times(k - 1, false, 0.6);
  EXPECT_TRUE(scale.on());
  times(1, false, 0.6);
  EXPECT_FALSE(scale.on());
}

TEST(LevelWatch, SuspectsWhereEnergiesCannotBeToldApart) {
  fem::LevelWatch watch;
  constexpr int k = fem::LevelWatch::kLevel;
  const auto run = [&](int n, bool level) {
    bool any = false;
    for (int i = 0; i < n; ++i) any = watch.suspects(1, level) || any;
    return any;
  };
  run(1, true);  // the first look is a gain
  EXPECT_FALSE(run(k - 1, true));
  EXPECT_FALSE(run(1, false));
  EXPECT_FALSE(run(k - 1, true));
  EXPECT_TRUE(run(1, true));
  EXPECT_FALSE(run(k - 1, true)) << "once";
  EXPECT_FALSE(watch.suspects(0.5, true)) << "a gain";
  EXPECT_FALSE(watch.suspects(0.6, true));
}

}  // namespace test_stiffened
}  // namespace limberg
