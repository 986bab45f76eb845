// Undo and redo to any depth: every bit comes back, in both directions.
#include <gtest/gtest.h>

#include <random>

#include "sim/patient/soft_tissue.h"
#include "sim/patient/world.h"
#include "tests/sim/patient/small_block.h"

namespace limberg {
namespace test_undo {

WorldSpec block(bool dynamic = false) {
  WorldSpec spec = test::small_block({.along = 1.1, .across = 1.06});
  spec.dynamic = dynamic;
  return spec;
}

class Surgeon {
 public:
  explicit Surgeon(uint64_t seed) : rng_(seed) {}
  int pick(int n) { return int(rng_() % uint64_t(n)); }
  double real(double lo, double hi) { return lo + (hi - lo) * double(rng_() >> 11) / 9007199254740992.0; }
  ChartPoint point() { return {real(-22, 22), real(-22, 22)}; }
  /// Something that undo takes back, if it is carried out.
  Command act() {
    const ChartPoint p = point();
    switch (pick(6)) {
      case 0:
        return Excise{{p, p + Vec2(8, 1), p + Vec2(7, 8), p + Vec2(-1, 7)}, real(2, 5)};
      case 1:
        return Undermine{{p, p + Vec2(12, 0), p + Vec2(12, 9), p + Vec2(0, 9)}, real(2, 5)};
      case 2:
        return Suture{p, p + Vec2(real(-6, 6), real(-6, 6))};
      case 3:
        return SutureRow{{p, p + Vec2(10, 1)}, {p + Vec2(0, 4), p + Vec2(10, 5)}, 3};
      default:
        return Incise{{p, point()}, real(2, 5), real(50, 130)};
    }
  }
  /// What a hand does between: undo does not count it, but brings back what it found.
  Command hand() {
    const int id = 1 + pick(3);
    switch (pick(4)) {
      case 0:
        return ReleaseHook{id};
      case 1:
        return SetHook{id, point()};
      default:
        return MoveHook{id, {real(-20, 20), real(-20, 20), real(0, 8)}, 0};
    }
  }

 private:
  std::mt19937_64 rng_;
};

void steps(World& world, int n, bool dynamic, bool focus = false) {
  StepSettings s;
  s.max_iterations = 4, s.focus = focus;
  if (dynamic) s.dt_s = 0.016, s.damping_per_s = 5;
  for (int i = 0; i < n; ++i) world.step(s);
}

class UndoHistories : public testing::TestWithParam<int> {};

TEST_P(UndoHistories, EveryHashComesBackInBothDirections) {
  InlineWorkers workers;
  const bool dynamic = GetParam() % 3 == 2;
  WorldSpec spec = block(dynamic);
  spec.refine_fronts = GetParam() % 2, spec.refine_pockets = GetParam() % 4 == 1;
  if (GetParam() > 6) {  // on a graded lattice
    spec.wound_level = 1;
    spec.fine.push_back({{-5, 3}, {9, 6}, 6, 5, 1});
  }
  if (GetParam() == 5 || GetParam() == 7) {  // with weight and loads
    spec.gravity_m_s2 = {3, -5, -9.81};
    spec.loads = {{{-8, 4}, {0.1, 0, -0.2}, 3}, {{10, -9}, {0, 0.1, 0.1}, 2}};
  }
  const bool focus = GetParam() == 4 || GetParam() == 6;  // what lies far from a moved hook holds still meanwhile
  if (focus) spec.focus = {.from_nodes = 10, .reach_mm = 1, .budget_mm = 1e3, .worth = 0.98};
  World world(spec, workers);
  Surgeon surgeon{uint64_t(GetParam())};
  steps(world, 3, dynamic, focus);
  std::vector<uint64_t> hash;  // just before each act that counted
  int refused = 0;
  for (int i = 0; i < 30; ++i) {
    const uint64_t before = world.full_hash();
    if (world.apply(surgeon.act()).done)
      hash.push_back(before);
    else {
      EXPECT_EQ(world.full_hash(), before) << "a refused act changes nothing";
      ++refused;
    }
    for (int k = surgeon.pick(3); k > 0; --k) world.apply(surgeon.hand());
    steps(world, surgeon.pick(3), dynamic, focus);
  }
  hash.push_back(world.full_hash());
  const std::string solved = world.skin()->solver().describe();
  EXPECT_EQ(solved.find("steps near what was carried") != std::string::npos, focus) << solved;
  ASSERT_GE(hash.size(), 12u) << refused << " refused";

  size_t at = hash.size() - 1;
  const auto undo = [&] {
    const Outcome o = world.apply(Undo{});
    ASSERT_TRUE(o.done) << o.reason;
    ASSERT_EQ(world.full_hash(), hash[--at]) << "undo to " << at;
  };
  const auto redo = [&] {
    const Outcome o = world.apply(Redo{});
    ASSERT_TRUE(o.done) << o.reason;
    ASSERT_EQ(world.full_hash(), hash[++at]) << "redo to " << at;
  };
  while (at > 0) ASSERT_NO_FATAL_FAILURE(undo());
  EXPECT_FALSE(world.apply(Undo{}).done);
  while (at + 1 < hash.size()) ASSERT_NO_FATAL_FAILURE(redo());
  EXPECT_FALSE(world.apply(Redo{}).done);
  for (int i = 0; i < 60; ++i) {  // to and fro
    if (at > 0 && (at + 1 == hash.size() || surgeon.pick(2)))
      ASSERT_NO_FATAL_FAILURE(undo());
    else
      ASSERT_NO_FATAL_FAILURE(redo());
  }
}
INSTANTIATE_TEST_SUITE_P(Seeds, UndoHistories, testing::Range(1, 9));

TEST(Undo, AnActAfterAnUndoIsTheSameActAgain) {
  InlineWorkers workers;
  World world(block(), workers);
  steps(world, 3, false);
  const Incise cut{{{-12, 0.3}, {12, 0.3}}, 4, 70};
  ASSERT_TRUE(world.apply(cut).done);
  const uint64_t hash = world.full_hash();
  ASSERT_TRUE(world.apply(Undo{}).done);
  // Another cut in between, so that points get the numbers that the first had.
  ASSERT_TRUE(world.apply(Excise{{{-8, 5}, {8, 5}, {8, 14}, {-8, 14}}, 5}).done);
  ASSERT_TRUE(world.apply(Undo{}).done);
  ASSERT_TRUE(world.apply(cut).done);
  EXPECT_EQ(world.full_hash(), hash);
}

TEST(Undo, ANewActEndsRedo) {
  InlineWorkers workers;
  World world(block(), workers);
  const auto redo_after = [&](const Command& c) {
    EXPECT_TRUE(world.apply(Incise{{{-12, 0.3}, {12, 0.3}}, 4, 90}).done);
    EXPECT_TRUE(world.apply(Undo{}).done);
    world.apply(c);
    return world.apply(Redo{}).done;
  };
  EXPECT_FALSE(redo_after(Incise{{{-12, 8}, {12, 8}}, 4, 90}));
  EXPECT_FALSE(redo_after(Suture{{-15, -9}, {-9, -9}}));
  EXPECT_FALSE(redo_after(SetHook{1, {0, -15}}));
  EXPECT_FALSE(redo_after(ReleaseHook{1}));
  // Refused acts, stages and steps end nothing.
  EXPECT_TRUE(redo_after(Incise{{{500, 0}, {600, 0}}, 4, 90}));
  EXPECT_TRUE(world.apply(Undo{}).done);
  EXPECT_TRUE(world.apply(Stage{"looking"}).done);
  steps(world, 2, false);
  EXPECT_TRUE(world.apply(Redo{}).done);
}

TEST(Undo, TheSolverGoesOnFromWhatItGotBack) {
  // Steps after undo lead where steps lead that never saw the act.
  InlineWorkers workers;
  World seen(block(), workers), unseen(block(), workers);
  for (World* w : {&seen, &unseen}) {
    ASSERT_TRUE(w->apply(Incise{{{-12, 0.3}, {12, 0.3}}, 4, 90}).done);
    steps(*w, 40, false);
  }
  ASSERT_TRUE(seen.apply(Excise{{{-8, 5}, {8, 5}, {8, 14}, {-8, 14}}, 5}).done);
  steps(seen, 40, false);
  ASSERT_TRUE(seen.apply(Undo{}).done);
  steps(seen, 60, false);
  steps(unseen, 60, false);
  const auto u = seen.skin()->solver().displacement_mm(), v = unseen.skin()->solver().displacement_mm();
  ASSERT_EQ(u.size(), v.size());
  double most = 0;
  for (size_t i = 0; i < u.size(); ++i) most = std::max(most, double((u[i] - v[i]).norm()));
  EXPECT_LT(most, 1e-3);  // both at rest to a relative residual of about 1e-6 (single precision)
}

// What undo brings back is in the hash that says whether it did.
TEST(Undo, TheHashSeesEveryFieldOfAThread) {
  InlineWorkers workers;
  const auto sewn = [&](const Command& row) {
    World world(block(), workers);
    EXPECT_TRUE(world.apply(Incise{{{-12, 0.3}, {12, 0.3}}, 4, 90}).done);
    const Outcome o = world.apply(row);
    EXPECT_TRUE(o.done) << o.reason;
    return world.full_hash();
  };
  SutureRow row{{{-9, 1}, {9, 1}}, {{-9, -0.5}, {9, -0.5}}, 6, 0, true, 0};
  const uint64_t tight = sewn(row);
  EXPECT_EQ(sewn(row), tight);
  row.slack_mm = 2;
  EXPECT_NE(sewn(row), tight) << "what is given back once the thread is closed";

  // Three stitches, five springs, all cut again: as one thread, or as single stitches and two hooks.
  World thread(block(), workers), single(block(), workers);
  for (World* w : {&thread, &single}) ASSERT_TRUE(w->apply(Incise{{{-12, 0.3}, {12, 0.3}}, 4, 90}).done);
  row.spacing_mm = 9, row.slack_mm = 0;
  ASSERT_TRUE(thread.apply(row).done);
  ASSERT_TRUE(thread.apply(CutSuture{{1, {0, 0}}}).done);
  for (int i = 0; i < 3; ++i) {
    const double x = 9 * i - 9;
    ASSERT_TRUE(single.apply(Suture{{x, 1}, {x, -0.5}}).done);
    ASSERT_TRUE(single.apply(CutSuture{{i + 1, {0, 0}}}).done);
  }
  for (int i = 0; i < 2; ++i) {
    ASSERT_TRUE(single.apply(SetHook{1, {0, 15}}).done);
    ASSERT_TRUE(single.apply(ReleaseHook{1}).done);
  }
  EXPECT_EQ(thread.state_hash(), single.state_hash());
  EXPECT_NE(thread.full_hash(), single.full_hash()) << "the number of the next thread";
}

}  // namespace test_undo
}  // namespace limberg
