// A running stitch that is sewn bite after bite: one thread with one tension, whose bites count by where they lie.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sim/patient/soft_tissue.h"
#include "sim/patient/sutures.h"
#include "sim/patient/thread_friction.h"
#include "sim/patient/world.h"
#include "tests/sim/patient/small_block.h"

namespace limberg {
namespace test_sewn_thread {

struct Wound {
  InlineWorkers workers;
  World world{test::small_block({.skin_cell_mm = 1.5, .cell_mm = 3.5, .along = 1.2, .across = 1.2}), workers};
  explicit Wound(bool incised = true) {
    if (!incised) return;
    must(Incise{{{-14, 0.3}, {-5, 1.3}, {5, 1.3}, {14, 0.3}}, 4, 90, true});
    settle();
  }
  void settle(int steps = 300) {
    StepSettings s;
    s.max_iterations = 20;
    for (int i = 0; i < steps; ++i)
      if (const StepReport r = world.step(s); world.settled() && r.residual <= 2e-5) break;
  }
  void must(const Command& c) {
    const Outcome o = world.apply(c);
    ASSERT_TRUE(o.done) << o.reason;
  }
  std::string refused(const Command& c) {
    const uint64_t before = world.full_hash();
    const Outcome o = world.apply(c);
    EXPECT_FALSE(o.done);
    EXPECT_EQ(world.full_hash(), before) << "a refused act changes nothing";
    return o.reason;
  }
  Snapshot shown() const {
    Snapshot s;
    world.fill(s);
    return s;
  }
  static double edge_y(double x) { return 1.3 - 0.006 * x * x; }  // about where the cut runs
  /// So far from the edge on either side.
  static SutureBite bite(double x, double lower_mm = 2, double upper_mm = 2) {
    return {{x, edge_y(x) - lower_mm}, {x, edge_y(x) + upper_mm}};
  }
};

TEST(SewnThread, BiteAfterBiteIsOneThreadWithOneTension) {
  Wound w;
  EXPECT_EQ(w.shown().sewn.thread, 0);
  for (int i = 0; i < 6; ++i) {
    w.must(Wound::bite(-10 + 4 * i));
    const SewnThread t = w.shown().sewn;
    EXPECT_GT(t.thread, 0);
    EXPECT_EQ(t.bites, i + 1);
    EXPECT_GT(t.end_mm.y(), 0) << "it comes out on the side where the bite ended";
    w.settle(120);
  }
  w.settle();
  ASSERT_TRUE(w.world.settled());
  const Snapshot s = w.shown();
  ASSERT_EQ(s.sutures.size(), 6u);
  float most = 0;
  for (const SutureState& k : s.sutures) {
    EXPECT_EQ(k.thread, s.sewn.thread);
    EXPECT_LT(k.gap_mm, 0.35) << k.id;
    most = std::max(most, k.force_N);
  }
  EXPECT_GT(most, 0.05f);
  // Of a thread with slack every span that thread is left in pulls alike.
  Wound loose;
  for (int i = 0; i < 6; ++i) loose.must(Wound::bite(-10 + 4 * i));
  loose.must(TieSuture{4});
  loose.settle();
  const Snapshot open = loose.shown();
  float hi = 0;
  int alike = 0;
  for (const SutureState& k : open.sutures) hi = std::max(hi, k.force_N);
  for (const SutureState& k : open.sutures) {
    if (k.gap_mm < hi / 20 + 0.01f) continue;  // used up there: the edges have met
    EXPECT_NEAR(k.force_N, hi, 1e-3f * hi) << k.id;
    ++alike;
  }
  EXPECT_GE(alike, 2);
  EXPECT_LT(hi, most);
}

TEST(SewnThread, AKnotEndsItAndTheNextBiteBeginsAnother) {
  Wound w;
  EXPECT_NE(w.refused(TieSuture{}).find("no thread is being sewn"), std::string::npos);
  w.must(Wound::bite(-8)), w.must(Wound::bite(-4));
  const int32_t first = w.shown().sewn.thread;
  w.must(Suture{{8, 0}, {8, 1.9}});  // an assistant's single stitch in between is no part of it
  w.must(Wound::bite(0));
  EXPECT_EQ(w.shown().sewn.bites, 3);
  w.must(TieSuture{});
  EXPECT_EQ(w.shown().sewn.thread, 0);
  EXPECT_FALSE(w.world.apply(TieSuture{}).done);
  w.must(Wound::bite(4));
  EXPECT_NE(w.shown().sewn.thread, first);
  EXPECT_EQ(w.shown().sewn.bites, 1);
  w.settle();
  EXPECT_TRUE(w.world.settled());
  w.must(CutSuture{{1, {0, 0}}});  // the whole first thread
  EXPECT_EQ(w.shown().sutures.size(), 2u);
}

TEST(SewnThread, UndoTakesTheLastBiteBackAndTheSewingGoesOn) {
  Wound w;
  std::vector<uint64_t> before;
  for (int i = 0; i < 4; ++i) {
    before.push_back(w.world.full_hash());
    w.must(Wound::bite(-6 + 4 * i));
  }
  const uint64_t all = w.world.full_hash();
  w.must(Undo{});
  EXPECT_EQ(w.world.full_hash(), before[3]);
  EXPECT_EQ(w.shown().sewn.bites, 3);
  w.must(Redo{});
  EXPECT_EQ(w.world.full_hash(), all);
  w.must(TieSuture{});
  EXPECT_NE(w.world.full_hash(), all) << "whether it is tied is a part of the state";
  w.must(Undo{});
  EXPECT_EQ(w.world.full_hash(), all);
  for (int i = 3; i >= 0; --i) {
    w.must(Undo{});
    EXPECT_EQ(w.world.full_hash(), before[size_t(i)]) << i;
  }
  EXPECT_EQ(w.shown().sewn.thread, 0);
}

TEST(SewnThread, HowFarABiteLiesFromTheEdgeCounts) {
  // A wider bite holds more skin, and the edges are drawn to meet by what lies farther behind them.
  std::vector<double> force;
  for (const double mm : {1.0, 3.0}) {
    Wound w;
    for (int i = 0; i < 5; ++i) w.must(Wound::bite(-8 + 4 * i, mm, mm));
    w.must(TieSuture{});
    w.settle();
    EXPECT_TRUE(w.world.settled());
    double sum = 0;
    for (const SutureState& k : w.shown().sutures) sum += double(k.force_N);
    force.push_back(sum);
  }
  EXPECT_GT(std::abs(force[1] - force[0]), 0.02 * force[0]) << force[0] << " N, " << force[1] << " N";
  Wound w;
  EXPECT_NE(w.refused(Wound::bite(0, 9, 2)).find("within 6 mm"), std::string::npos);
  const Outcome uneven = w.world.apply(Wound::bite(0, 1, 4));
  EXPECT_TRUE(uneven.done);
  EXPECT_NE(uneven.reason.find("from the other"), std::string::npos) << uneven.reason;
  const Outcome even = w.world.apply(Wound::bite(5, 2.2, 2));
  EXPECT_TRUE(even.done);
  EXPECT_EQ(even.reason, "");
  EXPECT_NE(w.refused(Wound::bite(5, 2.2, 2)).find("is there already"), std::string::npos);
}

TEST(SewnThread, ABiteIsWhereAScriptPutsIt) {
  Wound w;
  // Other places, other states; the same places, the same.
  std::vector<uint64_t> hash;
  for (const double x : {0.0, 0.0, 1.0}) {
    Wound one;
    one.must(Wound::bite(-6)), one.must(Wound::bite(x));
    hash.push_back(one.world.full_hash());
  }
  EXPECT_EQ(hash[0], hash[1]);
  EXPECT_NE(hash[0], hash[2]);
}

// ---- a thread that is let go untied ----

/// Pulls of the stitches in N, from the first to the last.
std::vector<double> pulls(const Snapshot& s) {
  std::vector<double> N;
  for (const SutureState& k : s.sutures) N.push_back(double(k.force_N));
  return N;
}

/// A spindle of skin is gone, and what is left is sewn bite after bite: its edges pull.
struct Sewn : Wound {
  static constexpr double kHalf_mm = 4, kLong_mm = 15;
  static double edge(double x) { return kHalf_mm * (1 - x * x / (kLong_mm * kLong_mm)); }
  static SutureBite across(double x) { return {{x, -edge(x) - 2}, {x, edge(x) + 2}}; }
  explicit Sewn(int bites = 6) : Wound(false) {
    Excise spindle;
    spindle.depth_mm = 4;
    for (int i = 0; i < 24; ++i) {
      const double x = kLong_mm * std::cos(i * M_PI / 12);
      spindle.outline.emplace_back(x, (i < 12 ? 1 : -1) * edge(x));
    }
    must(spindle);
    settle();
    for (int i = 0; i < bites; ++i) must(across(-10 + 4 * i)), settle(120);
    settle();
  }
};

TEST(LetGo, TensionFallsTowardsTheFreeEndAsOnACapstan) {
  Sewn w;
  const std::vector<double> before = pulls(w.shown());
  w.must(LetThreadGo{});
  EXPECT_FALSE(w.world.settled()) << "it slips now";
  w.settle(600);
  ASSERT_TRUE(w.world.settled());
  const Snapshot s = w.shown();
  EXPECT_TRUE(s.sewn.let_go);
  const std::vector<double> after = pulls(s);
  const double turn = std::exp(kThreadFriction * 2 * M_PI);
  for (size_t i = 0; i < 6; ++i) {
    const double most = kFreeEnd_N * std::exp(kThreadFriction * M_PI * double(2 * (6 - i) - 1));
    EXPECT_NEAR(most, Sutures::held_by_friction_N(int(5 - i)), 1e-9 * most);
    EXPECT_LE(after[i], 1.02 * most + 3e-3) << i;
  }
  // Where thread is left in two neighbours their tensions are within the bounds of friction, both ways.
  for (size_t i = 0; i + 1 < 6; ++i) {
    if (s.sutures[i].gap_mm < after[i] / 20 + 0.01 || s.sutures[i + 1].gap_mm < after[i + 1] / 20 + 0.01) continue;
    EXPECT_LE(after[i], 1.03 * turn * after[i + 1] + 6e-3) << i;
    EXPECT_GE(after[i], after[i + 1] / turn / 1.03 - 6e-3) << i;
  }
  // The last stitch pulled with more than the end can hold, and parts; the first is held by all the turns after it.
  ASSERT_GT(before[5], 2 * Sutures::held_by_friction_N(0));
  EXPECT_GT(s.sutures[5].gap_mm, 0.5f);
  EXPECT_LT(s.sutures[0].gap_mm, 0.35f);
}

TEST(LetGo, AKnotHoldsWhatAnOpenEndLetsGo) {
  Sewn tied;
  tied.must(TieSuture{});
  tied.settle();
  const Snapshot held = tied.shown();
  EXPECT_NE(tied.refused(LetThreadGo{}).find("no thread is being sewn"), std::string::npos);
  for (const SutureState& k : held.sutures) EXPECT_LT(k.gap_mm, 0.35f) << k.id;

  Sewn open;
  EXPECT_EQ(open.shown().sutures.size(), held.sutures.size());
  open.must(LetThreadGo{});
  open.settle(600);
  EXPECT_NE(open.refused(LetThreadGo{}).find("already"), std::string::npos);
  EXPECT_GT(open.shown().sutures.back().gap_mm, held.sutures.back().gap_mm + 0.3f);
  // Taken up again it is drawn until the edges meet.
  open.must(TieSuture{});
  open.settle(600);
  ASSERT_TRUE(open.world.settled());
  EXPECT_EQ(open.shown().sewn.thread, 0);
  for (const SutureState& k : open.shown().sutures) EXPECT_LT(k.gap_mm, 0.35f) << k.id;
}

TEST(LetGo, TheNextBiteTakesItUpAndUndoGivesItBack) {
  Sewn w(4);
  const uint64_t held = w.world.full_hash();
  w.must(LetThreadGo{});
  EXPECT_NE(w.world.full_hash(), held);
  w.must(Undo{});
  EXPECT_EQ(w.world.full_hash(), held);
  w.must(LetThreadGo{});
  w.settle(600);
  const float parted = w.shown().sutures.back().gap_mm;
  w.must(Sewn::across(6));
  EXPECT_FALSE(w.shown().sewn.let_go);
  w.settle(600);
  ASSERT_TRUE(w.world.settled());
  ASSERT_EQ(w.shown().sutures.size(), 5u);
  EXPECT_LT(w.shown().sutures[3].gap_mm, 0.35f);
  EXPECT_GT(parted, 0.45f);
}

TEST(LetGo, ComesToTheSameStateEveryTime) {
  std::vector<uint64_t> hash;
  for (int k = 0; k < 2; ++k) {
    Sewn w(3);
    w.must(LetThreadGo{});
    w.settle(200);
    hash.push_back(w.world.full_hash());
  }
  EXPECT_EQ(hash[0], hash[1]);
}

}  // namespace test_sewn_thread
}  // namespace limberg
