// The patient as a whole: cuts gape, plugs leave, stitches close, refusals and undo change nothing.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "sim/cutting/strokes/blade_build.h"
#include "sim/lattice/topology.h"
#include "sim/patient/soft_tissue.h"
#include "sim/patient/world.h"
#include "tests/sim/patient/small_block.h"

namespace limberg {
namespace test_world {

WorldSpec small_block(double prestretch = 1.08) {
  return test::small_block({.skin_cell_mm = 1.2, .cell_mm = 3.5, .along = prestretch, .across = prestretch});
}

double largest_move_mm(const World& world) {
  double most = 0;
  for (const Vec3f& u : world.skin()->solver().displacement_mm()) most = std::max(most, double(u.norm()));
  return most;
}

StepReport settle(World& world, int steps = 200, double tolerance = 1e-4) {
  StepSettings s;
  s.max_iterations = 20;
  StepReport r;
  for (int i = 0; i < steps; ++i) {
    r = world.step(s);
    if (world.settled() && r.residual <= tolerance && !r.preconditioner_pending) break;
  }
  return r;
}

std::vector<ChartPoint> rhombus(double side) {
  const double h = side * std::sqrt(3.0) / 2;
  return {{0, h}, {-side / 2, 0}, {0, -h}, {side / 2, 0}};
}

TEST(World, PrestretchedSkinRestsUntilItIsCut) {
  InlineWorkers workers;
  World world(small_block(), workers);
  settle(world);
  // A flat prestretched layer is in equilibrium (fem_model.h); what remains is single precision on a 60 mm block.
  EXPECT_LT(largest_move_mm(world), 1e-3);
  EXPECT_EQ(world.skin()->pieces(), 1);
}

TEST(World, AnIncisionGapesByItselfOnlyUnderPrestretch) {
  for (const double prestretch : {1.0, 1.1}) {
    InlineWorkers workers;
    World world(small_block(prestretch), workers);
    const double before = world.skin()->volume_mm3();
    const Outcome o = world.apply(Incise{{{-12, 0.3}, {12, 0.3}}, 4, 90});
    ASSERT_TRUE(o.done) << o.reason;
    EXPECT_EQ(world.skin()->pieces(), 1);
    EXPECT_NEAR(world.skin()->volume_mm3() / before, 1, 1e-12);
    settle(world);
    Snapshot snap;
    world.fill(snap);
    // The gape: how far the two banks' vertices of one rest point have moved apart, on the skin.
    double gape = 0;
    const SurfaceView& view = snap.topology->view;
    std::vector<std::pair<int32_t, size_t>> by_point;
    for (size_t i = 0; i < view.X_mm.size(); ++i)
      if (snap.topology->depth_mm.get()[i] < 1e-3f) by_point.push_back({view.point[i], i});
    std::sort(by_point.begin(), by_point.end());
    for (size_t k = 1; k < by_point.size(); ++k)
      if (by_point[k].first == by_point[k - 1].first)
        gape = std::max(gape, double((snap.x_mm[by_point[k].second] - snap.x_mm[by_point[k - 1].second]).norm()));
    if (prestretch > 1)
      EXPECT_GT(gape, 0.5);
    else
      EXPECT_LT(gape, 1e-3);
  }
}

TEST(World, NothingJumpsInTheFrameOfACut) {
  InlineWorkers workers;
  World world(small_block(), workers);
  ASSERT_TRUE(world.apply(SetHook{1, {0, 8}}).done);
  ASSERT_TRUE(world.apply(MoveHook{1, {0, 5, 9}, 1}).done);
  settle(world, 30);
  Snapshot before, after;
  world.fill(before);
  ASSERT_TRUE(world.apply(Incise{{{-12, 0.3}, {12, 0.3}}, 4, 90}).done);
  world.fill(after);
  // Vertices that were there before are found by their arrangement point; both banks start where it was.
  std::vector<int32_t> vertex_of_point;
  for (size_t i = 0; i < before.topology->view.point.size(); ++i) {
    const size_t p = size_t(before.topology->view.point[i]);
    if (p >= vertex_of_point.size()) vertex_of_point.resize(p + 1, -1);
    vertex_of_point[p] = int32_t(i);
  }
  int compared = 0;
  for (size_t i = 0; i < after.topology->view.point.size(); ++i) {
    const size_t p = size_t(after.topology->view.point[i]);
    if (p >= vertex_of_point.size() || vertex_of_point[p] < 0) continue;
    EXPECT_EQ((after.x_mm[i] - before.x_mm[size_t(vertex_of_point[p])]).norm(), 0) << i;
    ++compared;
  }
  EXPECT_GT(compared, 1000);
}

TEST(World, APlugLeavesAndVolumeBalances) {
  InlineWorkers workers;
  World world(small_block(), workers);
  const Outcome o = world.apply(Excise{rhombus(16), 4});
  ASSERT_TRUE(o.done) << o.reason;
  EXPECT_EQ(world.skin()->pieces(), 1);
  EXPECT_NEAR((world.skin()->volume_mm3() + world.skin()->removed_volume_mm3()) / world.skin()->initial_volume_mm3(), 1,
              1e-9);
  // A rhombus of side a and angle 60 degrees has area a^2 sin
  // 60; blades follow the outline to the micrometres of jitter.
  EXPECT_NEAR(world.skin()->removed_volume_mm3(), 16 * 16 * std::sqrt(3.0) / 2 * 4, 0.01 * 16 * 16 * 4);
}

TEST(World, SliversOfNearlyEqualCutsAreBooked) {
  InlineWorkers workers;
  World world(small_block(), workers);
  ASSERT_TRUE(world.apply(Incise{{{-12, 0.3}, {12, 0.3}}, 4, 90}).done);
  // The same stroke again, two hundredths of a millimetre aside
  // and deeper: refused or done, nothing loose stays behind.
  world.apply(Incise{{{-11, 0.32}, {11, 0.28}}, 5, 90});
  EXPECT_EQ(world.skin()->pieces(), 1);
  EXPECT_NEAR((world.skin()->volume_mm3() + world.skin()->removed_volume_mm3()) / world.skin()->initial_volume_mm3(), 1,
              1e-9);
}

TEST(World, ASuturedWoundCloses) {
  InlineWorkers workers;
  World world(small_block(), workers);
  ASSERT_TRUE(world.apply(Excise{{{-12, 0}, {0, -4}, {12, 0}, {0, 4}}, 4}).done);
  settle(world, 60);
  Outcome o = world.apply(Suture{{0, 4.6}, {0, -4.6}});
  ASSERT_TRUE(o.done) << o.reason;
  o = world.apply(SutureRow{{{-11, 0.9}, {0, 4.6}, {11, 0.9}}, {{-11, -0.9}, {0, -4.6}, {11, -0.9}}, 3});
  ASSERT_TRUE(o.done) << o.reason;
  const StepReport r = settle(world, 600);
  EXPECT_LE(r.residual, 1e-4);
  Snapshot snap;
  world.fill(snap);
  EXPECT_GE(snap.sutures.size(), 8u);
  for (const SutureState& s : snap.sutures) {
    EXPECT_LE(s.gap_mm, 0.2f) << "suture " << s.id;  // the bar for a closed wound
    EXPECT_NEAR(s.force_N, s.gap_mm * world.skin()->spec().suture_k_N_per_mm, 1e-3 + 0.02 * s.force_N)
        << "a linear spring";
  }
}

TEST(World, ARefusedActionChangesNothing) {
  InlineWorkers workers;
  World world(small_block(), workers);
  settle(world, 5);
  const uint64_t hash = world.state_hash();
  const std::vector<Command> bad = {Incise{{{-200, 0}, {200, 0}}, 4, 90},
                                    Incise{{{0, 0}}, 4, 90},
                                    Incise{{{0, 0}, {10, 0}}, -1, 90},
                                    Incise{{{NAN, 0}, {10, 0}}, 4, 90},
                                    Excise{{{0, 0}, {1, 0}}, 4},
                                    Suture{{0, 0}, {0, 0}},
                                    Suture{{0, 0}, {500, 0}},
                                    MoveHook{7, {0, 0, 0}, 1},
                                    ReleaseHook{3},
                                    SetHook{1, {1e9, 0}},
                                    SetHook{-1, {0, 0}},
                                    Undo{},
                                    SutureRow{{{0, 0}}, {{1, 0}}, 3},
                                    SutureRow{{{0, 0}, {20, 0}}, {{0, 3}, {20, 3}}, 0}};
  for (const Command& c : bad) {
    const Outcome o = world.apply(c);
    EXPECT_FALSE(o.done) << "command " << c.index();
    EXPECT_FALSE(o.reason.empty());
    EXPECT_EQ(world.state_hash(), hash) << "command " << c.index() << ": " << o.reason;
  }
  EXPECT_EQ(world.refused(), int(bad.size()));
}

TEST(World, UndoReturnsTheExactState) {
  InlineWorkers workers;
  World world(small_block(), workers);
  settle(world, 5);
  ASSERT_TRUE(world.apply(SetHook{1, {5, 8}}).done);
  const uint64_t h0 = world.state_hash();
  ASSERT_TRUE(world.apply(Incise{{{-12, 0.3}, {12, 0.3}}, 4, 90}).done);
  EXPECT_NE(world.state_hash(), h0);
  ASSERT_TRUE(world.apply(Undo{}).done);
  EXPECT_EQ(world.state_hash(), h0);
  ASSERT_TRUE(world.apply(Excise{rhombus(16), 4}).done);
  ASSERT_TRUE(world.apply(Undo{}).done);
  EXPECT_EQ(world.state_hash(), h0);
  EXPECT_EQ(world.skin()->removed_volume_mm3(), 0);
}

TEST(World, TheSameActionsGiveTheSameBits) {
  const auto run = [] {
    InlineWorkers workers;
    World world(small_block(), workers);
    world.apply(Incise{{{-12, 0.3}, {12, 0.3}}, 4, 90});
    settle(world, 10, 0);
    world.apply(Suture{{0, 1.0}, {0, -0.4}});
    settle(world, 10, 0);
    return world.state_hash();
  };
  EXPECT_EQ(run(), run());
}

TEST(World, AStrokeOfSeveralCutsIsOneAct) {
  InlineWorkers workers;
  World world(small_block(), workers);
  const uint64_t hash = world.topology()->hash;
  // Across itself, then the same line again and deeper, and on beyond its end.
  const std::vector<ChartPoint> alpha{{-16, 0}, {8, 0.5}, {11, 7}, {3, 10}, {-3, -10}};
  for (const Incise& c : {Incise{alpha, 4, 90}, Incise{alpha, 6.5, 90}, Incise{{{-10, 0.1}, {-24, -0.2}}, 5, 90}}) {
    const uint64_t before = world.topology()->hash;
    Outcome o = world.apply(c);
    ASSERT_TRUE(o.done) << o.reason;
    const uint64_t after = world.topology()->hash;
    EXPECT_NE(after, before);
    ASSERT_TRUE(world.apply(Undo{}).done);
    EXPECT_EQ(world.topology()->hash, before);
    ASSERT_TRUE(world.apply(Redo{}).done);
    EXPECT_EQ(world.topology()->hash, after);
    EXPECT_EQ(world.skin()->pieces(), 1);
    // The same again does nothing, at sharp corners too.
    EXPECT_FALSE(world.apply(c).done);
    EXPECT_EQ(world.topology()->hash, after);
    settle(world, 30);
  }
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(world.apply(Undo{}).done);
  EXPECT_EQ(world.topology()->hash, hash);
}

TEST(World, APlugWithoutFloorLeavesOnceItIsUndermined) {
  InlineWorkers workers;
  World world(small_block(), workers);
  const std::vector<ChartPoint> ring{{8, 0}, {0, 7}, {-8, 0}, {0, -7}};
  const uint64_t hash = world.topology()->hash;
  Outcome o = world.apply(Excise{ring, 4, false});
  EXPECT_FALSE(o.done);  // still attached below
  EXPECT_EQ(world.topology()->hash, hash);
  ASSERT_TRUE(world.apply(Incise{{ring[0], ring[1], ring[2], ring[3], ring[0]}, 4, 90}).done);
  o = world.apply(Undermine{ring, 4});
  ASSERT_TRUE(o.done) << o.reason;
  EXPECT_EQ(world.skin()->pieces(), 2);
  settle(world, 30);
  o = world.apply(Excise{ring, 4, false});  // its walls are there already: it only takes the piece out
  ASSERT_TRUE(o.done) << o.reason;
  EXPECT_EQ(world.skin()->pieces(), 1);
  // The sheet lies kSheetRaise, and by turns up to 0.08 mm more, above the depth asked (build_undermining).
  EXPECT_NEAR(world.skin()->removed_volume_mm3(), 2 * 8 * 7 * (4 - kSheetRaise - 0.04), 2 * 8 * 7 * 0.045);
  EXPECT_NEAR((world.skin()->volume_mm3() + world.skin()->removed_volume_mm3()) / world.skin()->initial_volume_mm3(), 1,
              1e-9);
  const uint64_t taken = world.topology()->hash;
  ASSERT_TRUE(world.apply(Undo{}).done);
  EXPECT_EQ(world.skin()->pieces(), 2);
  ASSERT_TRUE(world.apply(Redo{}).done);
  EXPECT_EQ(world.topology()->hash, taken);
  // Walls that reach through need no undermining.
  o = world.apply(Excise{{{20, 14}, {14, 20}, {8, 14}, {14, 8}}, 12, false});
  ASSERT_TRUE(o.done) << o.reason;
}

// Undermining goes on under a defect: a thin slice off its bed goes with the blade, a thick one is the surgeon's.
TEST(World, UnderminingUnderADefectLeavesNoShavings) {
  InlineWorkers workers;
  for (const bool thin : {true, false}) {
    World world(small_block(), workers);
    const std::vector<ChartPoint> ring{{8, 0}, {0, 7}, {-8, 0}, {0, -7}};
    ASSERT_TRUE(world.apply(Incise{{ring[0], ring[1], ring[2], ring[3], ring[0]}, 4.4, 90}).done);
    ASSERT_TRUE(world.apply(Excise{ring, thin ? 3.7 : 1.5, true}).done);
    const uint64_t before = world.topology()->hash;
    const double removed = world.skin()->removed_volume_mm3();
    const Outcome o = world.apply(Undermine{{{14, -12}, {14, 12}, {-14, 12}, {-14, -12}}, 4});
    ASSERT_TRUE(o.done) << o.reason;
    const double slice = 2 * 8 * 7 * (thin ? 4 - kSheetRaise - 3.7 : 4 - 1.5);
    EXPECT_EQ(world.skin()->pieces(), thin ? 1 : 2);
    EXPECT_EQ(o.reason.find("shaved") != std::string::npos, thin) << o.reason;
    EXPECT_NEAR(world.skin()->removed_volume_mm3() - removed, thin ? slice : 0, 0.4 * slice);
    EXPECT_NEAR((world.skin()->volume_mm3() + world.skin()->removed_volume_mm3()) / world.skin()->initial_volume_mm3(),
                1, 1e-9);
    const uint64_t after = world.topology()->hash;
    ASSERT_TRUE(world.apply(Undo{}).done);
    EXPECT_EQ(world.topology()->hash, before);
    EXPECT_NEAR(world.skin()->removed_volume_mm3(), removed, 1e-9);
    ASSERT_TRUE(world.apply(Redo{}).done);
    EXPECT_EQ(world.topology()->hash, after);
  }
}

TEST(World, ASceneThatCannotBeCutSaysSo) {
  InlineWorkers workers;
  WorldSpec spec = small_block();
  spec.can_cut = false;
  World world(spec, workers);
  const Outcome o = world.apply(Incise{{{-12, 0.3}, {12, 0.3}}, 4, 90});
  EXPECT_FALSE(o.done);
  EXPECT_NE(o.reason.find("can_cut"), std::string::npos);
  EXPECT_TRUE(world.apply(SetHook{1, {0, 0}}).done);
}

// With divided fronts: the same cut opens closer to its ends, nothing jumps, undo is exact.
TEST(World, RefinedFronts) {
  const auto width_at = [](const World& world, double x) {
    Snapshot snap;
    world.fill(snap);
    const SurfaceView& view = snap.topology->view;
    double width = 0;
    for (size_t a = 0; a < view.X_mm.size(); ++a)
      for (size_t b = 0; b < a; ++b)
        if (view.point[a] == view.point[b] && snap.topology->depth_mm.get()[a] < 1e-3f &&
            std::abs(view.X_mm[a].x() - x) < 0.7)
          width = std::max(width, double((snap.x_mm[a] - snap.x_mm[b]).norm()));
    return width;
  };
  double opening[2] = {0, 0};
  for (const bool refined : {false, true}) {
    InlineWorkers workers;
    WorldSpec spec = small_block(1.1);
    spec.refine_fronts = refined;
    World world(spec, workers);
    settle(world);
    const uint64_t before = world.state_hash();
    Snapshot was, now;
    world.fill(was);
    ASSERT_TRUE(world.apply(Incise{{{-12.6, 0.3}, {12.6, 0.3}}, 4, 90}).done);
    EXPECT_EQ(world.skin()->solver().model().hanging.empty(), !refined);
    world.fill(now);
    double moved = 0;  // vertices of the skin that were there before
    std::map<int32_t, Vec3f> old;
    for (size_t v = 0; v < was.x_mm.size(); ++v) old[was.topology->view.point[v]] = was.x_mm[v];
    for (size_t v = 0; v < now.x_mm.size(); ++v)
      if (const auto it = old.find(now.topology->view.point[v]); it != old.end())
        moved = std::max(moved, double((now.x_mm[v] - it->second).norm()));
    EXPECT_LT(moved, 4e-6);  // single precision of coordinates of 30 mm
    settle(world);
    const uint64_t cut = world.state_hash();
    ASSERT_TRUE(world.apply(Incise{{{0.2, -9}, {0.4, 8}}, 5, 90}).done);  // under load, across divided cells
    settle(world);
    opening[refined] = width_at(world, 11.2);
    ASSERT_TRUE(world.apply(Undo{}).done);
    EXPECT_EQ(world.state_hash(), cut);
    ASSERT_TRUE(world.apply(Undo{}).done);
    EXPECT_EQ(world.state_hash(), before);
  }
  EXPECT_GT(opening[true], opening[false] + 0.05);
}

// The rim of a pocket is divided, or not as the scene wishes; that of an incision is either way.
TEST(World, PocketsNeedNotBeDivided) {
  size_t more[2] = {0, 0};
  for (const bool pockets : {false, true}) {
    InlineWorkers workers;
    WorldSpec spec = small_block(1.1);
    spec.refine_fronts = true, spec.refine_pockets = pockets;
    World world(spec, workers);
    const auto divided = [&] { return world.skin()->lattice()->tree.division.size(); };
    ASSERT_TRUE(world.apply(Incise{{{-9, 0.3}, {9, 0.3}}, 4, 90}).done);
    const size_t slit = divided();
    EXPECT_GT(slit, 0u);
    const Outcome o = world.apply(Undermine{{{-9, -7}, {9, -7}, {9, 7}, {-9, 7}}, 4});
    ASSERT_TRUE(o.done) << o.reason;
    more[pockets] = divided() - slit;
    const uint64_t hash = world.full_hash();
    ASSERT_TRUE(world.apply(Undo{}).done);
    EXPECT_EQ(divided(), slit);
    ASSERT_TRUE(world.apply(Redo{}).done);
    EXPECT_EQ(world.full_hash(), hash);
    const size_t pocket = divided();
    ASSERT_TRUE(world.apply(Incise{{{0.2, 8}, {0.4, 12}}, 3, 90}).done);
    EXPECT_GT(divided(), pocket);
  }
  EXPECT_EQ(more[false], 0u);
  EXPECT_GT(more[true], 0u);
}

}  // namespace test_world
}  // namespace limberg
