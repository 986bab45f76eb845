// While something is carried the part around it is solved for: how far that is from the whole, what it says of it, and
// that what rests is the whole's.
#include <gtest/gtest.h>

#include <cmath>

#include "models.h"
#include "sim/fem/solver/focus_solver.h"

namespace limberg {
namespace test_focus_solver {

using fem::FocusSettings;
using fem::FocusSolver;

/// 200 x 60 mm of soft tissue, 9 mm thick; held below, or at its two ends only.
std::shared_ptr<const FemModel> slab(bool held_below = true) {
  BoxSpec b;
  b.cells = {50, 15, 3}, b.size_mm = {200, 60, 9};
  b.young_bottom_kPa = 18, b.young_top_kPa = 60, b.poisson = 0.45;
  b.fix_bottom = held_below;
  FemModel m = box_model(b);
  for (size_t i = 0; !held_below && i < m.X_mm.size(); ++i)
    if (const double x = std::as_const(m.X_mm)[i].x(); std::fabs(x) > 99.9) m.fixed.set(i, true);
  return std::make_shared<const FemModel>(m);
}

FocusSettings always() {
  FocusSettings s;
  s.from_nodes = 100;
  return s;
}

StepSettings live(bool focus) {
  StepSettings s;
  s.max_iterations = 6, s.tolerance = 1e-5, s.focus = focus;
  return s;
}

/// A hook in the slab's left third, and one that stays.
std::vector<Spring> hooks(const FemModel& m, double lifted_mm) {
  Spring carried, stays;
  carried.id = 7, carried.to_world = true, carried.k_N_per_mm = 0.3, carried.a = embed(m, {-60, 5, 8.5});
  carried.target_mm = Vec3(-60 + 0.5 * lifted_mm, 5, 8.5 + lifted_mm);
  stays = carried, stays.id = 2, stays.a = embed(m, {-50, -12, 8.5}), stays.target_mm = Vec3(-50, -14, 10);
  return {carried, stays};
}

double apart(const ElasticSolver& a, const ElasticSolver& b) {
  double d = 0;
  for (size_t i = 0; i < a.displacement_mm().size(); ++i)
    d = std::max(d, double((a.displacement_mm()[i] - b.displacement_mm()[i]).norm()));
  return d;
}

void settle(ElasticSolver& s, bool focus = true) {
  StepSettings set = live(focus);
  set.max_iterations = 300, set.tolerance = 3e-6;
  for (int i = 0; i < 40; ++i)
    if (s.step(set).converged && i > 20) return;
}

TEST(FocusSolver, WhileAHookIsCarriedIsNearTheWholeAndAtRestItIsThat) {
  InlineWorkers workers;
  const auto m = slab();
  FocusSolver focus(workers, always()), whole(workers, always());
  focus.set_model(m, {}), whole.set_model(m, {});
  double worst = 0, told = 0;
  int near = 0;
  for (int i = 0; i <= 60; ++i) {
    const std::vector<Spring> h = hooks(*m, 0.1 * i);
    focus.set_springs(h), whole.set_springs(h);
    focus.step(live(true)), whole.step(live(false));
    near += focus.focused();
    // Both lag behind the hook; the exact place at this hook is that of neither, so they are compared once both rest.
    if (i % 20 == 0 && i > 0) {
      FocusSolver exact(workers, always());
      exact.set_model(m, {}), exact.set_springs(h);
      exact.restore(whole.save());
      settle(exact, false);
      for (int k = 0; k < 4; ++k) focus.step(live(true));  // the hand waits, and near comes closer
      worst = std::max(worst, apart(focus, exact)), told = std::max(told, focus.held_back_mm());
    }
  }
  EXPECT_GT(near, 40);
  EXPECT_LT(focus.most_nodes_near(), m->X_mm.size() / 2);
  EXPECT_LT(worst, 0.1);  // twice the budget: lengths that were not solved for, and what is not at rest yet
  EXPECT_LE(told, 0.05);
  settle(focus), settle(whole);
  EXPECT_FALSE(focus.focused());
  EXPECT_LT(apart(focus, whole), 2e-3);
  for (const int id : {7, 2}) EXPECT_LT((focus.spring_force_mN(id) - whole.spring_force_mN(id)).norm(), 1) << id;
}

TEST(FocusSolver, WhereItsBudgetIsNotKeptThePartGrows) {
  InlineWorkers workers;
  const auto m = slab();
  FocusSettings near = always();
  near.reach_mm = 1, near.budget_mm = 0.02;  // one box
  FocusSolver focus(workers, near), whole(workers, near);
  focus.set_model(m, {}), whole.set_model(m, {});
  double worst = 0;
  size_t first = 0;
  for (int i = 0; i <= 80; ++i) {
    const std::vector<Spring> h = hooks(*m, 0.1 * i);
    focus.set_springs(h), whole.set_springs(h);
    focus.step(live(true)), whole.step(live(false));
    if (first == 0) first = focus.most_nodes_near();
    worst = std::max(worst, apart(focus, whole));
  }
  EXPECT_GT(first, 0u);
  EXPECT_GT(focus.most_nodes_near(), first);
  settle(focus), settle(whole);
  EXPECT_LT(apart(focus, whole), 5e-3);
  // The defect on purpose: no budget, and the part stays as it was, far from the whole.
  near.budget_mm = 1e9;
  FocusSolver careless(workers, near), again(workers, near);
  careless.set_model(m, {}), again.set_model(m, {});
  double far = 0;
  for (int i = 0; i <= 80; ++i) {
    careless.set_springs(hooks(*m, 0.1 * i)), again.set_springs(hooks(*m, 0.1 * i));
    careless.step(live(true)), again.step(live(false));
    far = std::max(far, apart(careless, again));
  }
  EXPECT_GT(far, 2 * worst);
}

TEST(FocusSolver, WhatIsSavedIsTheWholeAndGoesOnAlike) {
  InlineWorkers workers;
  const auto m = slab();
  FocusSolver a(workers, always());
  a.set_model(m, {});
  int i = 0;
  for (; i < 20; ++i) a.set_springs(hooks(*m, 0.1 * i)), a.step(live(true));
  ASSERT_TRUE(a.focused());
  const SolverState state = a.save();
  const auto path = a.path();
  EXPECT_EQ(state.displacement_mm.size(), 3 * m->X_mm.size());
  std::vector<Vec3f> shown(a.displacement_mm().begin(), a.displacement_mm().end());
  for (size_t k = 0; k < shown.size(); ++k)
    for (int c = 0; c < 3; ++c) ASSERT_EQ(state.displacement_mm[3 * k + size_t(c)], shown[k][c]) << k;
  // Asked twice it says the same, and it goes on as if it had not been asked.
  EXPECT_EQ(a.save(), state);
  FocusSolver b(workers, always());
  b.set_model(m, {});
  for (int k = 0; k < 20; ++k) b.set_springs(hooks(*m, 0.1 * k)), b.step(live(true));
  const auto carry_on = [&](FocusSolver& s) {
    for (int k = i; k < i + 15; ++k) s.set_springs(hooks(*m, 0.1 * k)), s.step(live(true));
    return s.save();
  };
  const SolverState later = carry_on(a);
  EXPECT_EQ(later, carry_on(b));
  // Gone back to: afresh, the same steps are the same bits.
  const auto from_there = [&](FocusSolver& s) {
    s.restore(state), s.take_up(*path);
    s.set_springs(hooks(*m, 2.5));
    StepSettings fresh = live(true);
    fresh.afresh = true;
    s.step(fresh);
    for (int k = 0; k < 10; ++k) s.set_springs(hooks(*m, 2.5 + 0.1 * k)), s.step(live(true));
    return s.save();
  };
  EXPECT_EQ(from_there(a), from_there(b));
}

TEST(FocusSolver, WithoutBeingAskedItIsThePlainSolver) {
  InlineWorkers workers;
  const auto m = slab();
  FocusSolver focus(workers, always());
  auto plain = make_solver(workers);
  focus.set_model(m, {}), plain->set_model(m, {});
  for (int i = 0; i < 10; ++i) {
    focus.set_springs(hooks(*m, 0.1 * i)), plain->set_springs(hooks(*m, 0.1 * i));
    focus.step(live(false)), plain->step(live(false));
  }
  EXPECT_EQ(focus.save(), plain->save());
  EXPECT_EQ(focus.steps_near(), 0u);
}

TEST(FocusSolver, AStitchFarAwayIsTakenInAndFiguresOfTheWholeStayTrue) {
  InlineWorkers workers;
  const auto m = slab();
  FocusSolver focus(workers, always());
  focus.set_model(m, {});
  int i = 0;
  for (; i < 20; ++i) focus.set_springs(hooks(*m, 0.1 * i)), focus.step(live(true));
  ASSERT_TRUE(focus.focused());
  const StepReport near = focus.step(live(true));
  std::vector<float> J;
  focus.cell_J(J);
  EXPECT_EQ(J.size(), m->cells.size());
  // Support, hooks and weight balance as well as this step is at rest.
  Vec3 pulled = Vec3::Zero();
  for (const int id : {7, 2}) pulled += focus.spring_force_mN(id);
  EXPECT_LT((focus.support_force_mN() - pulled).norm(), 0.1 * pulled.norm());
  StepSettings none = live(false);
  none.max_iterations = 0;
  const StepReport whole = focus.step(none);
  EXPECT_NEAR(near.energy_uJ, whole.energy_uJ, 1e-3 * whole.energy_uJ);

  for (; i < 40; ++i) focus.set_springs(hooks(*m, 0.1 * i)), focus.step(live(true));
  ASSERT_TRUE(focus.focused());
  std::vector<Spring> with_stitch = hooks(*m, 0.1 * i);
  Spring stitch;
  stitch.id = 9, stitch.k_N_per_mm = 0.5, stitch.a = embed(*m, {80, 3, 8.5}), stitch.b = embed(*m, {84, 3, 8.5}),
  stitch.target_mm = Vec3(-3.5, 0, 0);
  with_stitch.push_back(stitch);
  focus.set_springs(with_stitch);
  EXPECT_FALSE(focus.focused());
  settle(focus);
  auto plain = make_solver(workers);
  plain->set_model(m, {}), plain->set_springs(with_stitch);
  settle(*plain, false);
  EXPECT_LT(apart(focus, *plain), 2e-3);
}

}  // namespace test_focus_solver
}  // namespace limberg
