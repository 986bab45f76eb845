// One history for skin and bone: whatever was done, refused, undone and done again, the patient is to the bit the one
// on whom only the acts that remain were carried out.
//
// Between the acts there are no solver steps: the minimiser's memory of past iterates is no part of a patient's state
// (elastic_solver.h), so that steps after an undo lead to the same rest on another way. A few steps are taken before
// the first act, alike in both; what undo does with steps between is in test_undo.cpp.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <random>
#include <stdexcept>

#include "sim/cutting/arrangement/fault.h"
#include "sim/patient/history.h"
#include "sim/patient/soft_tissue.h"
#include "sim/patient/world.h"
#include "sim/skull/head/head.h"
#include "sim/skull/simplex/generators.h"
#include "tests/sim/patient/planted_defect.h"
#include "tests/sim/patient/small_block.h"

namespace limberg {
namespace test_history {

/// Skin over a ball of bone that can be moved, and one that cannot.
std::unique_ptr<World> patient(FaultPlan* fault, Workers& workers) {
  WorldSpec spec = test::small_block({.side_mm = 40, .thickness_mm = 8, .skin_cell_mm = 4, .cell_mm = 6, .fat = false});
  spec.fault = fault;
  HeadParts parts;
  parts.bones.push_back({"ball", simplex::make_sphere({0, 0, -45}, 30, 2), false});
  parts.bones.push_back({"anvil", simplex::make_sphere({0, 0, -200}, 20, 1), true});
  parts.landmarks = {{"top", {0, 0, -15}, false}};
  HeadSettings head;
  head.carries_skin_mm = 12;
  auto world = std::make_unique<World>(spec, std::move(parts), workers, head);
  StepSettings s;
  s.max_iterations = 3;
  for (int i = 0; i < 2; ++i) world->step(s);
  return world;
}

class Hand {
 public:
  explicit Hand(uint64_t seed) : rng_(seed) {}
  int pick(int n) { return int(rng_() % uint64_t(n)); }
  double real(double lo, double hi) { return lo + (hi - lo) * double(rng_() >> 11) / 9007199254740992.0; }
  ChartPoint point() { return {real(-23, 23), real(-23, 23)}; }  // now and then off the skin
  Command cut() {
    const ChartPoint p = point();
    switch (pick(4)) {
      case 0:
        return Excise{{p, p + Vec2(7, 1), p + Vec2(6, 7), p + Vec2(-1, 6)}, real(2, 4), pick(3) > 0};
      case 1:
        return Undermine{{p, p + Vec2(9, 0), p + Vec2(9, 8), p + Vec2(0, 8)}, real(2, 4)};
      default:
        return Incise{{p, p + Vec2(real(-12, 12), real(-12, 12))}, real(2, 5), real(60, 120)};
    }
  }
  /// A piece of a stroke: most go on from the last one, some are too short to cut, some strokes are left half.
  Command piece() {
    if (!stroke_ || pick(5) == 0) tip_ = point(), stroke_ = ++strokes_;
    const double length = pick(3) ? 6 : 0.4;
    InciseMore m{stroke_, {tip_}, 3, 90, pick(4) == 0};
    m.path.push_back(tip_ += Vec2(real(-length, length), real(-length, length)));
    if (m.last) stroke_ = 0;
    return m;
  }
  Command sew() {
    const ChartPoint p = point();
    switch (pick(7)) {
      case 3:
        return SutureBite{p, p + Vec2(real(-5, 5), real(-5, 5))};
      case 4:
        return TieSuture{};
      case 0:
        return SutureRow{{p, p + Vec2(9, 1)}, {p + Vec2(0, 3), p + Vec2(9, 4)}, 4, 0, pick(2) > 0, 1};
      case 1:
        return CutSuture{{pick(2) ? 1 + pick(12) : 0, p}};
      case 2:
        return SutureBetween{{1 + pick(6), {0, 0}}, {1 + pick(6), {0, 0}}, {3, 0, pick(2) > 0, 0}};
      default:
        return Suture{p, p + Vec2(real(-5, 5), real(-5, 5))};
    }
  }
  Command hook() {
    const int id = 1 + pick(3);
    if (pick(3) == 0) return ReleaseHook{id};
    if (pick(2)) return SetHook{id, point()};
    return MoveHook{id, {real(-20, 20), real(-20, 20), real(0, 8)}, 0};
  }
  HeadCommand bone() {
    const FragmentPick of{pick(4), Vec3::Zero()};
    switch (pick(6)) {
      case 0: {
        CutBone c;
        c.point_mm = {0, 0, real(-65, -25)}, c.normal = Vec3(real(-1, 1), real(-1, 1), 1).normalized();
        return c;
      }
      case 1:
        return PlateFragments{{real(-30, 30), 0, -45}, {real(-30, 30), 0, -40}};
      case 2:
        return Unplate{of};
      case 3:
        return PlaceLandmark{pick(2) ? "top" : "side", {real(-20, 20), real(-20, 20), -20}, false};
      default: {
        MoveFragment m;
        m.fragment = of, m.by.translation_mm = {real(-3, 3), real(-3, 3), real(-3, 3)};
        return m;
      }
    }
  }

 private:
  std::mt19937_64 rng_;
  int stroke_ = 0, strokes_ = 0;
  ChartPoint tip_{0, 0};
};

/// What a patient's history should be: the commands that remain.
class Remaining {
 public:
  void done(const Command& c, bool entry, bool ends_redo) {
    const bool bone = std::holds_alternative<HeadCommand>(c);
    log_.push_back({++serial_, bone, c});
    if (entry) done_.push_back({serial_, bone, 0, {}});
    if (entry || ends_redo) undone_.clear();
  }
  bool can_undo() const { return !done_.empty(); }
  bool can_redo() const { return !undone_.empty(); }
  /// Of bone: that act. Of skin: it and all that came after it in skin, hooks too.
  void undo() {
    Entry e = std::move(done_.back());
    done_.pop_back();
    e.undone_at = ++serial_;
    e.tail.clear();
    take([&](const Line& l) { return l.bone == e.bone && (e.bone ? l.serial == e.serial : l.serial >= e.serial); },
         &e.tail);
    undone_.push_back(std::move(e));
  }
  /// What was done in skin since the undo goes: hooks that were moved.
  void redo() {
    Entry e = std::move(undone_.back());
    undone_.pop_back();
    if (!e.bone) take([&](const Line& l) { return !l.bone && l.serial > e.undone_at; }, nullptr);
    log_.insert(log_.end(), e.tail.begin(), e.tail.end());
    std::sort(log_.begin(), log_.end(), [](const Line& a, const Line& b) { return a.serial < b.serial; });
    done_.push_back(std::move(e));
  }
  uint64_t carried_out(Workers& workers) const {
    const std::unique_ptr<World> fresh = patient(nullptr, workers);
    for (const Line& l : log_) {
      const Outcome o = fresh->apply(l.command);
      EXPECT_TRUE(o.done) << o.reason;
    }
    return fresh->full_hash();
  }

 private:
  struct Line {
    int64_t serial;
    bool bone;
    Command command;
  };
  struct Entry {
    int64_t serial;
    bool bone;
    int64_t undone_at;
    std::vector<Line> tail;
  };
  template <class Which>
  void take(Which&& which, std::vector<Line>* out) {
    if (out) std::copy_if(log_.begin(), log_.end(), std::back_inserter(*out), which);
    std::erase_if(log_, which);
  }
  int64_t serial_ = 0;
  std::vector<Line> log_;
  std::vector<Entry> done_, undone_;
};

struct Counts {
  int done = 0, refused = 0, undone = 0, redone = 0, failed = 0, nothing = 0;
};

void operate(uint64_t seed, int acts, Counts& n) {
  InlineWorkers workers;
  FaultPlan fault;
  test::PlantedDefect defect;
  fault.watch = &defect;
  const std::unique_ptr<World> world = patient(&fault, workers);
  Hand hand(seed);
  Remaining left;
  int open_stroke = 0;  // that has its entry and may go on
  for (int i = 0; i < acts; ++i) {
    SCOPED_TRACE("seed " + std::to_string(seed) + ", act " + std::to_string(i));
    if (i % 100 == 99) {
      ASSERT_EQ(world->full_hash(), left.carried_out(workers));
    }
    const int what = hand.pick(100);
    if (what < 36) {
      const bool back = what < 20, can = back ? left.can_undo() : left.can_redo();
      const Outcome o = back ? world->apply(Undo{}) : world->apply(Redo{});
      ASSERT_EQ(o.done, can) << o.reason;
      if (!can) continue;
      back ? left.undo() : left.redo();
      ++(back ? n.undone : n.redone), open_stroke = 0;
      continue;
    }
    const Command c = what < 54   ? hand.cut()
                      : what < 66 ? hand.piece()
                      : what < 78 ? hand.sew()
                      : what < 88 ? hand.hook()
                                  : Command(hand.bone());
    const auto* more = std::get_if<InciseMore>(&c);
    const uint64_t before = world->full_hash(), topology = world->skin()->topology_hash();
    defect.calls = fault.calls = 0;
    if (hand.pick(8) == 0) {  // memory at its end, or a defect
      const int64_t at = hand.pick(100);
      if (hand.pick(2))
        defect.at = at;
      else
        fault.kind = FaultPlan::thrown, fault.at = at, fault.until = at + 1;
    }
    Outcome o;
    try {
      o = world->apply(c);
    } catch (const std::out_of_range&) {
      o = {false, "a defect"};
      ++n.failed;
    }
    fault.kind = FaultPlan::count, defect.at = -1;
    if (!o.done) {
      ++n.refused;
      ASSERT_EQ(world->full_hash(), before) << o.reason;
      if (more && more->stroke == open_stroke) open_stroke = 0;
      continue;
    }
    ++n.done;
    const bool cut = world->skin()->topology_hash() != topology;
    const bool is_hook = std::holds_alternative<SetHook>(c) || std::holds_alternative<MoveHook>(c) ||
                         std::holds_alternative<ReleaseHook>(c);
    const bool entry = more ? cut && more->stroke != open_stroke : !is_hook;
    n.nothing += more && !cut;
    left.done(c, entry, is_hook && !std::holds_alternative<MoveHook>(c));
    if (entry) open_stroke = more ? more->stroke : 0;
    if (more && more->last) open_stroke = 0;
  }
  EXPECT_EQ(world->full_hash(), left.carried_out(workers)) << "seed " << seed;
}

int64_t number(const char* name, int64_t otherwise) {
  const char* v = std::getenv(name);
  return v ? std::atoll(v) : otherwise;
}

// LIMBERG_HISTORY_SEEDS lengthens the run, LIMBERG_HISTORY_SEED is the first of them.
TEST(History, WhatIsThereIsWhatRemainsOfTheActs) {
  Counts n;
  const int64_t first = number("LIMBERG_HISTORY_SEED", 1), seeds = number("LIMBERG_HISTORY_SEEDS", 20);
  for (int64_t seed = first; seed < first + seeds; ++seed) ASSERT_NO_FATAL_FAILURE(operate(uint64_t(seed), 300, n));
  std::printf("%d done (%d pieces of strokes cut nothing), %d refused (%d by planted defects), %d undone, %d redone\n",
              n.done, n.nothing, n.refused, n.failed, n.undone, n.redone);
  EXPECT_GT(n.done, 60 * seeds);
  EXPECT_GT(n.undone, 20 * seeds);
  EXPECT_GT(n.redone, 8 * seeds);
  EXPECT_GT(n.nothing, 0);
  EXPECT_GT(n.failed, 0);
}

TEST(History, KeepsTheNewestThousandActs) {
  History<int> past;
  const int all = int(History<int>::kMost) + 3;
  for (int k = 0; k < all; ++k) past.make_room(), past.push(k);
  int taken = 0, oldest = all;
  for (; past.can_undo(); ++taken) oldest = past.last(), past.went_back();
  EXPECT_EQ(taken, int(History<int>::kMost));
  EXPECT_EQ(oldest, 3);
  for (int k = 3; past.can_redo(); ++k, past.went_forth()) ASSERT_EQ(past.last_undone(), k);
  EXPECT_EQ(past.last(), all - 1);
}

}  // namespace test_history
}  // namespace limberg
