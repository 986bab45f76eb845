// The minimiser against the full Newton reference, and what a frame may rely on.
#include <gtest/gtest.h>

#include "models.h"
#include "sim/fem/solver/stall_watch.h"
#include "sim/testing/reference_newton.h"

namespace limberg {
namespace test_elastic_solver {

BenchScene pulled_scene(double poisson) {
  BenchScene s = bench_scene(20, 2, poisson);
  s.springs.back().target_mm += Vec3(-10, -10, 26);
  return s;
}

double largest_difference(std::span<const Vec3f> a, std::span<const Vec3> b) {
  double m = 0;
  for (size_t i = 0; i < a.size(); ++i) m = std::max(m, (a[i].cast<double>() - b[i]).norm());
  return m;
}

class AgainstNewton : public ::testing::TestWithParam<double> {};

// Covers the primal path (nu 0.3) and the augmented one, whose fixed point must be the primal solution.
TEST_P(AgainstNewton, SameEquilibriumAfterA30mmPull) {
  const BenchScene s = pulled_scene(GetParam());
  InlineWorkers workers;
  auto solver = make_solver(workers);
  solver->set_model(std::make_shared<FemModel>(s.model), {});
  solver->set_springs(s.springs);
  StepSettings settings;
  settings.max_iterations = 400, settings.tolerance = 3e-6;
  const StepReport r = solver->step(settings);
  EXPECT_TRUE(r.converged);
  ReferenceElasticity reference(s.model, s.springs);
  const auto q = reference.solve(std::vector<Vec3>(s.model.X_mm.size(), Vec3::Zero()), {});
  EXPECT_TRUE(q.converged);
  EXPECT_LT(largest_difference(solver->displacement_mm(), q.u), 1e-3);
}
INSTANTIATE_TEST_SUITE_P(Poisson, AgainstNewton, ::testing::Values(0.3, 0.45, 0.49));

// Every boundary node is held on a homogeneous deformation; inside, that deformation is the only equilibrium.
TEST(ElasticSolver, PatchTest) {
  BoxSpec b;
  b.cells = {5, 4, 4}, b.size_mm = {11, 9, 8}, b.poisson = 0.45;
  FemModel m = box_model(b);
  for (size_t i = 0; i < m.X_mm.size(); ++i) {
    const Vec3 X = m.X_mm[i];
    m.fixed[i] = std::abs(X[0]) > 5.49 || std::abs(X[1]) > 4.49 || X[2] < 0.01 || X[2] > 7.99;
  }
  Mat3 F;
  F << 1.15, 0.2, 0, -0.1, 0.95, 0.1, 0.05, 0, 1.0;
  F /= std::cbrt(F.determinant());
  std::vector<Vec3> want;
  for (const Vec3& X : m.X_mm) want.push_back((F - Mat3::Identity()) * X);
  std::vector<Vec3f> u = test::to_float(want);
  test::Random r(1);
  for (size_t i = 0; i < u.size(); ++i)
    if (!m.fixed[i]) u[i] += r.vector(0.5).cast<float>();
  InlineWorkers w;
  auto solver = make_solver(w);
  solver->set_model(std::make_shared<FemModel>(m), {});
  solver->set_displacement_mm(u);
  StepSettings s;
  s.max_iterations = 300, s.tolerance = 1e-6;
  EXPECT_TRUE(solver->step(s).converged);
  EXPECT_LT(largest_difference(solver->displacement_mm(), want), 1e-5);
  for (size_t c = 0; c < m.cells.size(); ++c) EXPECT_LT((solver->cell_F(int32_t(c)) - F).norm(), 1e-5);
  std::vector<float> J;
  solver->cell_J(J);
  for (float j : J) EXPECT_NEAR(j, 1, 1e-5);
}

// Single precision ends near 1e-6: a solver that is asked for more says that it stalls, long before its last iteration.
TEST(ElasticSolver, AStallIsSaid) {
  BoxSpec b;
  b.cells = {6, 5, 4}, b.size_mm = {12, 10, 8}, b.poisson = 0.45;
  const auto m = std::make_shared<FemModel>(box_model(b));
  std::vector<Vec3f> u(m->X_mm.size(), Vec3f::Zero());
  test::Random r(1);
  for (size_t i = 0; i < u.size(); ++i)
    if (!m->fixed[i]) u[i] = r.vector(0.4).cast<float>();
  InlineWorkers w;
  for (const double tolerance : {1e-4, 1e-12}) {
    auto solver = make_solver(w);
    solver->set_model(m, {});
    solver->set_displacement_mm(u);
    StepSettings s;
    s.max_iterations = 20000, s.tolerance = tolerance;
    const StepReport report = solver->step(s);
    EXPECT_EQ(report.converged, tolerance > 1e-6);
    EXPECT_EQ(report.stalled, tolerance < 1e-6);
    EXPECT_EQ(report.at_floor, tolerance < 1e-6);
    EXPECT_LT(report.iterations, 1000) << "known at the floor, not after thousands without gain";
    EXPECT_LT(report.residual, tolerance < 1e-6 ? 2e-6 : 1e-4);
  }
}

// Sessions and operations take a few iterations at a time: the floor is known over all of them, costs no iteration once
// it is known, and is forgotten when the solver is given anything.
TEST(ElasticSolver, TheFloorIsKnownOverManySteps) {
  BoxSpec b;
  b.cells = {6, 5, 4}, b.size_mm = {12, 10, 8}, b.poisson = 0.45;
  const auto m = std::make_shared<FemModel>(box_model(b));
  InlineWorkers w;
  auto solver = make_solver(w);
  solver->set_model(m, {});
  const auto pulled = [&](double by_mm) {
    const size_t top = m->X_mm.size() - 1;
    Spring s;
    s.id = 1, s.to_world = true, s.k_N_per_mm = 1, s.target_mm = m->X_mm[top] + Vec3(0, 0, by_mm);
    s.a.node.fill(int32_t(top)), s.a.w.fill(0), s.a.w[0] = 1;
    return std::vector{s};
  };
  StepSettings s;
  s.max_iterations = 20, s.tolerance = 1e-12;
  const auto iterations_to_floor = [&] {
    int n = 0;
    for (int i = 0; i < 40; ++i) {
      const StepReport r = solver->step(s);
      n += r.iterations;
      if (!r.at_floor) continue;
      EXPECT_TRUE(r.stalled);
      EXPECT_LT(r.residual, 1e-5);
      return n;
    }
    return -1;
  };
  solver->set_springs(pulled(1));
  EXPECT_GT(iterations_to_floor(), 0);
  EXPECT_EQ(iterations_to_floor(), 0);
  solver->set_springs(pulled(1));
  EXPECT_EQ(iterations_to_floor(), 0) << "the same once more";
  solver->set_springs(pulled(2));
  EXPECT_GT(iterations_to_floor(), 0) << "the hand moves";
  const SolverState at = solver->save();
  solver->restore(at);
  EXPECT_GT(iterations_to_floor(), 0) << "a state that is brought back knows nothing of it";
}

TEST(StallWatch, AsksForATenthOfTheResidual) {
  fem::StallWatch watch;
  EXPECT_FALSE(watch.look(1, 0));
  EXPECT_FALSE(watch.look(0.95, fem::StallWatch::kIterations - 1)) << "less, and not by a tenth";
  EXPECT_TRUE(watch.look(0.95, 1));
  EXPECT_TRUE(watch.look(2, 20)) << "worse is no gain";
  EXPECT_FALSE(watch.look(0.89, 20)) << "goes on";
  double slow = 1;
  for (int i = 0; i < 100; ++i) EXPECT_FALSE(watch.look(slow *= 0.79, fem::StallWatch::kIterations - 1));
}

// One cell pulled at its corners: axial stretch b, lateral stretch a with no lateral stress,
// P = mu F + (lambda (J - 1) - mu) cof F.
TEST(ElasticSolver, UniaxialTensionOfOneCell) {
  const Elastic el = elastic_from_young(50, 0.42);
  const double stretch = 1.4;
  double a = 1;
  for (int k = 0; k < 60; ++k) {  // P_xx = mu a + (lambda (a^2 b - 1) - mu) a b = 0 by bisection-free Newton
    const double p = el.lambda_kPa * (a * a * stretch - 1) - el.mu_kPa;
    const double f = el.mu_kPa + p * stretch, df = 2 * el.lambda_kPa * a * stretch * stretch;
    a -= f / df;
  }
  const double P = el.mu_kPa * stretch + (el.lambda_kPa * (a * a * stretch - 1) - el.mu_kPa) * a * a;
  BoxSpec b;
  b.cells = {1, 1, 1}, b.size_mm = {4, 4, 4}, b.young_bottom_kPa = b.young_top_kPa = 50, b.poisson = 0.42;
  const auto m = std::make_shared<FemModel>(box_model(b));
  const double force = P * 16 / 4;  // mN per corner
  std::vector<Spring> springs;
  for (size_t i = 0; i < 8; ++i) {
    const Vec3 X = m->X_mm[i];
    Spring s;
    s.id = int32_t(i), s.to_world = true, s.k_N_per_mm = 0.05;
    s.a = embed(*m, X);
    const bool up = X[2] > 2;
    s.target_mm = Vec3(a * X[0], a * X[1], stretch * (X[2] - 2) + 2 + (up ? 1 : -1) * force / 50);
    springs.push_back(s);
  }
  InlineWorkers w;
  auto solver = make_solver(w);
  solver->set_model(m, {});
  solver->set_springs(springs);
  StepSettings s;
  s.max_iterations = 300, s.tolerance = 1e-6;
  EXPECT_TRUE(solver->step(s).converged);
  const Mat3 F = solver->cell_F(0);
  EXPECT_NEAR(F(2, 2), stretch, 1e-5);
  EXPECT_NEAR(F(0, 0), a, 1e-5);
  EXPECT_NEAR(solver->spring_force_mN(7)[2], force, 1e-3 * force);
}

TEST(ElasticSolver, HooksAndSupportsBalance) {
  const BenchScene s = pulled_scene(0.45);
  InlineWorkers w;
  auto solver = make_solver(w);
  solver->set_model(std::make_shared<FemModel>(s.model), {});
  solver->set_springs(s.springs);
  StepSettings st;
  st.max_iterations = 400, st.tolerance = 1e-5;
  solver->step(st);
  const Vec3 hook = solver->spring_force_mN(100), support = solver->support_force_mN();
  EXPECT_GT(hook.norm(), 100);
  EXPECT_LT((hook - support).norm(), 1e-3 * hook.norm());  // the block passes the hook's pull on to its sides
}

TEST(ElasticSolver, StiffSuturesCloseTheirGap) {
  BenchScene s = bench_scene(20, 2, 0.45);
  for (Spring& p : s.springs) p.k_N_per_mm = 30;
  s.springs.pop_back();
  InlineWorkers w;
  auto solver = make_solver(w);
  solver->set_model(std::make_shared<FemModel>(s.model), {});
  StepSettings st;
  solver->step(st);  // the factor knows none of them
  solver->set_springs(s.springs);
  st.max_iterations = 400, st.tolerance = 1e-5;
  EXPECT_TRUE(solver->step(st).converged);
  for (const Spring& p : s.springs) {
    const double gap = (solver->position_mm(p.a) - solver->position_mm(p.b)).norm();
    EXPECT_LT(gap, 0.2);
    EXPECT_NEAR(solver->spring_force_mN(p.id).norm(), 30e3 * gap, 0.05 * 30e3 * gap + 1);
  }
}

// Held by means over places along its edge: the means meet, the places themselves need not, and all three ways of
// counting a spring agree about where that is.
TEST(ElasticSolver, AWideStitchBringsTheMeansTogether) {
  BenchScene s = bench_scene(20, 2, 0.45);
  s.springs = {s.springs[9]};
  Spring& stitch = s.springs[0];
  stitch.k_N_per_mm = 20;
  const auto place = [&](const EmbeddedPoint& p) {
    Vec3 X = Vec3::Zero();
    for (size_t i = 0; i < 8; ++i) X += double(p.w[i]) * s.model.X_mm[size_t(p.node[i])];
    return X;
  };
  const Vec3 along = (place(stitch.a) - place(stitch.b)).cross(Vec3::UnitZ()).normalized();
  for (double d : {-3.0, 0.0, 3.0})
    stitch.a_wide.push_back(embed(s.model, place(stitch.a) + d * along)),
        stitch.b_wide.push_back(embed(s.model, place(stitch.b) + d * along));
  InlineWorkers w;
  auto solver = make_solver(w);
  solver->set_model(std::make_shared<FemModel>(s.model), {});
  solver->set_springs(s.springs);
  StepSettings st;
  st.max_iterations = 400, st.tolerance = 3e-6;
  EXPECT_TRUE(solver->step(st).converged);
  const auto mean = [&](const std::vector<HeldPlace>& end) {
    Vec3 sum = Vec3::Zero();
    for (const EmbeddedPoint& p : end) sum += solver->position_mm(p);
    return Vec3(sum / double(end.size()));
  };
  const Vec3 gap = mean(stitch.a_wide) - mean(stitch.b_wide);
  EXPECT_LT(gap.norm(), 0.2);
  EXPECT_NEAR(solver->spring_force_mN(stitch.id).norm(), 20e3 * gap.norm(), 1e-3 * 20e3 * gap.norm());
  EXPECT_GT((solver->position_mm(stitch.a_wide[0]) - solver->position_mm(stitch.b_wide[0])).norm(), 2 * gap.norm());
  // In equilibrium by the reference, too, which counts springs by itself.
  const ReferenceElasticity reference(s.model, s.springs);
  std::vector<Vec3> u, g;
  for (const Vec3f& d : solver->displacement_mm()) u.push_back(d.cast<double>());
  reference.gradient(u, g);
  double most = 0;
  for (size_t i = 0; i < g.size(); ++i)
    if (!s.model.fixed[i]) most = std::max(most, g[i].norm());
  EXPECT_LT(most, 1e-2 * solver->spring_force_mN(stitch.id).norm());
}

// A stitch with slack pulls only what the slack leaves; taking the slack away in steps ends where a tight stitch ends.
TEST(ElasticSolver, AStitchIsTightenedThroughItsSlack) {
  BenchScene s = bench_scene(20, 2, 0.45);
  s.springs = {s.springs[9]};
  Spring& stitch = s.springs[0];
  stitch.k_N_per_mm = 20;
  InlineWorkers w;
  auto slow = make_solver(w), tight = make_solver(w);
  StepSettings st;
  st.max_iterations = 300, st.tolerance = 3e-6;
  for (auto* solver : {&slow, &tight}) (*solver)->set_model(std::make_shared<FemModel>(s.model), {});
  tight->set_springs(s.springs);
  tight->step(st);
  const Vec3 open = slow->position_mm(stitch.a) - slow->position_mm(stitch.b);
  for (double slack : {1.0, 0.5, 0.0}) {
    stitch.target_mm = slack * open;
    slow->set_springs(s.springs);
    slow->step(st);
    const Vec3 gap = slow->position_mm(stitch.a) - slow->position_mm(stitch.b);
    EXPECT_LT((gap - slack * open).norm(), 0.2);
    EXPECT_LT((slow->spring_force_mN(stitch.id) + 20e3 * (gap - stitch.target_mm)).norm(), 0.5);
    if (slack == 1.0) {
      EXPECT_LT(slow->spring_force_mN(stitch.id).norm(), 1);
    }
  }
  double worst = 0;
  for (size_t i = 0; i < s.model.X_mm.size(); ++i)
    worst = std::max(worst, double((slow->displacement_mm()[i] - tight->displacement_mm()[i]).norm()));
  EXPECT_LT(worst, 2e-3);
}

// A stitch's pull is great against all that the iterates before have learned, and the metric knows it: what they have
// learned does not count. A hook's does not stop them: its motion is small, and it moves at every frame.
TEST(ElasticSolver, ADrawnStitchBeginsAnew) {
  for (const bool hook : {false, true}) {
    BenchScene s = bench_scene(20, 2, 0.45);
    s.springs = {s.springs[9], s.springs.back()};
    Spring& moved = s.springs[hook ? 1 : 0];
    s.springs[0].k_N_per_mm = 20;
    InlineWorkers w;
    auto solver = make_solver(w), fresh = make_solver(w);
    for (auto* one : {&solver, &fresh})
      (*one)->set_model(std::make_shared<FemModel>(s.model), {}), (*one)->set_springs(s.springs);
    StepSettings st;
    st.max_iterations = 6;
    solver->step(st);
    fresh->restore(solver->save());  // but without a history
    moved.target_mm += Vec3(0.2, 0.1, 0.4);
    st.max_iterations = 1;
    for (auto* one : {&solver, &fresh}) (*one)->set_springs(s.springs), (*one)->step(st);
    EXPECT_EQ(std::ranges::equal(solver->displacement_mm(), fresh->displacement_mm()), !hook);
  }
}

// A step that may only go so far stops at the node that has, but not for one that only a sliver of material hangs on.
TEST(ElasticSolver, AStepsLengthIsThatOfWhatCarriesSomething) {
  for (const float fraction : {1.0f, 0.25f, 0.15f, 0.01f}) {
    BoxSpec b;
    b.cells = {3, 3, 3}, b.size_mm = {9, 9, 9}, b.fix_bottom = true;
    FemModel m = box_model(b);
    Spring pull;
    pull.id = 1, pull.to_world = true, pull.a = embed(m, {4.5, 4.5, 9}), pull.target_mm = {14.5, 4.5, 9};
    for (HexCell& c : m.cells)
      if ((m.X_mm[size_t(c.node[7])] - Vec3(4.5, 4.5, 9)).norm() < 1e-9)
        c.scale = fraction, pull.k_N_per_mm = 0.02 * double(fraction);
    InlineWorkers w;
    auto solver = make_solver(w);
    solver->set_model(std::make_shared<FemModel>(m), {});
    solver->set_springs(std::span(&pull, 1));
    StepSettings st;
    st.max_iterations = 12, st.most_move_mm = 0.5;
    const StepReport r = solver->step(st);
    const double went = double((solver->position_mm(pull.a) - Vec3(4.5, 4.5, 9)).norm());
    EXPECT_GT(went, 0.5) << fraction;
    if (fraction >= 0.2f) {
      EXPECT_LT(r.iterations, 12) << fraction;
    } else {
      EXPECT_EQ(r.iterations, 12) << fraction;
    }
  }
}

struct Recorded {
  std::vector<Vec3f> u;
  std::vector<double> residual;
};

/// A little session: drag, suture, cut, drag on.
Recorded session(Workers& w) {
  const BenchScene s = bench_scene(20, 2, 0.47);
  auto solver = make_solver(w);
  const auto model = std::make_shared<FemModel>(s.model);
  solver->set_model(model, {});
  StepSettings st;
  st.max_iterations = 6;
  Recorded out;
  Spring hook = s.springs.back();
  std::vector<Spring> springs{hook};
  auto run = [&](int steps) {
    for (int k = 0; k < steps; ++k) {
      springs[0].target_mm += Vec3(-0.3, -0.3, 0.8);
      solver->set_springs(springs);
      out.residual.push_back(solver->step(st).residual);
    }
  };
  run(4);
  springs.insert(springs.end(), s.springs.begin(), s.springs.begin() + 8);
  run(4);
  const FemModel cut = test::cut_at_x0(s.model, 40);
  solver->set_model(std::make_shared<FemModel>(cut), test::identity_parents(cut));
  springs.resize(1);  // the sutures' weights would name the old copies
  run(8);
  out.u.assign(solver->displacement_mm().begin(), solver->displacement_mm().end());
  return out;
}

TEST(ElasticSolver, SameBitsForAnyNumberOfWorkers) {
  InlineWorkers one;
  test::ThreadWorkers two(2), three(3);
  const Recorded a = session(one), b = session(one), c = session(two), d = session(three);
  for (const Recorded* r : {&b, &c, &d}) {
    EXPECT_EQ(a.residual, r->residual);
    ASSERT_EQ(a.u.size(), r->u.size());
    for (size_t i = 0; i < a.u.size(); ++i) ASSERT_EQ(a.u[i], r->u[i]);
  }
}

TEST(ElasticSolver, ACutAndANewSpringMoveNothingByThemselves) {
  const BenchScene s = pulled_scene(0.45);
  InlineWorkers w;
  auto solver = make_solver(w);
  solver->set_model(std::make_shared<FemModel>(s.model), {});
  solver->set_springs(s.springs);
  StepSettings st;
  st.max_iterations = 300, st.tolerance = 1e-5;
  solver->step(st);
  const std::vector<Vec3f> before(solver->displacement_mm().begin(), solver->displacement_mm().end());
  const FemModel cut = test::cut_at_x0(s.model, 40);
  solver->set_model(std::make_shared<FemModel>(cut), test::identity_parents(cut));
  solver->set_springs(std::vector<Spring>(s.springs.end() - 1, s.springs.end()));
  for (size_t i = 0; i < cut.X_mm.size(); ++i) ASSERT_EQ(solver->displacement_mm()[i], before[size_t(cut.parent[i])]);
  // The pressures came along: where nothing was cut and no suture was taken away, the block is still in balance.
  st.max_iterations = 0;
  solver->step(st);
  for (size_t i = 0; i < cut.X_mm.size(); ++i) ASSERT_EQ(solver->displacement_mm()[i], before[size_t(cut.parent[i])]);
}

// Displacements and pressures are carried: the same model given again is still in balance.
TEST(ElasticSolver, TheSameModelGivenAgainIsStillInBalance) {
  const BenchScene s = pulled_scene(0.49);
  InlineWorkers w;
  auto solver = make_solver(w);
  solver->set_model(std::make_shared<FemModel>(s.model), {});
  solver->set_springs(s.springs);
  StepSettings st;
  st.max_iterations = 300, st.tolerance = 1e-5;
  const double residual = solver->step(st).residual;
  EXPECT_LE(residual, 1e-5);
  // Nodes and cells in another order: parents must be used, not indices.
  FemModel again = s.model;
  const size_t n = again.X_mm.size();
  auto moved = [&](int32_t i) { return int32_t((size_t(i) + 7) % n); };
  for (size_t i = 0; i < n; ++i) {
    const size_t j = size_t(moved(int32_t(i)));
    again.X_mm[j] = s.model.X_mm[i], again.fixed[j] = s.model.fixed[i], again.mass_kg[j] = s.model.mass_kg[i];
    again.parent.set(j, int32_t(i));
  }
  std::vector<HexCell> cells = again.cells.flat();
  std::reverse(cells.begin(), cells.end());
  for (HexCell& c : cells)
    for (int32_t& v : c.node) v = moved(v);
  again.cells = cells;
  std::vector<int32_t> cell_parent = test::identity_parents(again);
  std::reverse(cell_parent.begin(), cell_parent.end());
  std::vector<Spring> springs = s.springs;
  for (Spring& p : springs)
    for (size_t i = 0; i < 8; ++i) p.a.node[i] = moved(p.a.node[i]), p.b.node[i] = moved(p.b.node[i]);
  solver->set_model(std::make_shared<FemModel>(again), cell_parent);
  solver->set_springs(springs);
  st.max_iterations = 0;
  EXPECT_LT(solver->step(st).residual, 1.5 * residual);
}

// With a factor that never comes, the answer is the same.
TEST(ElasticSolver, TheCycleChangesNothingButTime) {
  const BenchScene s = pulled_scene(0.45);
  const FemModel cut = test::cut_at_x0(s.model, 45);
  InlineWorkers w;
  auto waiting = make_solver(w), fresh = make_solver(w);
  waiting->set_model(std::make_shared<FemModel>(s.model), {});
  StepSettings st;
  waiting->step(st);
  waiting->set_model(std::make_shared<FemModel>(cut), test::identity_parents(cut));
  fresh->set_model(std::make_shared<FemModel>(cut), {});
  st.max_iterations = 1500, st.tolerance = 3e-6, st.adopt_after_steps = 1000;
  const std::vector<Spring> hook(s.springs.end() - 1, s.springs.end());
  StepReport r[2];
  int k = 0;
  for (auto* solver : {&waiting, &fresh}) (*solver)->set_springs(hook), r[k++] = (*solver)->step(st);
  EXPECT_TRUE(r[0].converged && r[1].converged);
  EXPECT_TRUE(r[0].preconditioner_pending);
  EXPECT_FALSE(r[1].preconditioner_pending);
  RecordProperty("iterations_cycle", r[0].iterations);
  RecordProperty("iterations_factor", r[1].iterations);
  EXPECT_TRUE(r[0].metric_is_cycle && !r[1].metric_is_cycle);
  EXPECT_LT(r[0].iterations, 1.5 * r[1].iterations);
  double worst = 0;
  for (size_t i = 0; i < cut.X_mm.size(); ++i)
    worst = std::max(worst, double((waiting->displacement_mm()[i] - fresh->displacement_mm()[i]).norm()));
  EXPECT_LT(worst, 5e-3);
}

}  // namespace test_elastic_solver
}  // namespace limberg
