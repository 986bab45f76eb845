// Incisions that open while they are drawn are the incisions of their whole paths.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>

#include "sim/commands/strokes.h"
#include "sim/cutting/arrangement/arrangement.h"
#include "sim/patient/soft_tissue.h"
#include "sim/patient/world.h"
#include "tests/sim/drawn_pieces.h"
#include "tests/sim/patient/small_block.h"

namespace limberg {
namespace test_drawing {

WorldSpec block() { return test::small_block({.side_mm = 80}); }

/// What must not depend on how a path was divided.
struct Shape {
  int pieces = 0, chi = 0;
  double volume_mm3 = 0, removed_mm3 = 0, wall_mm2 = 0;
  std::vector<double> piece_mm3;
};

Shape shape(const World& world) {
  Shape s;
  s.pieces = world.skin()->pieces();
  s.volume_mm3 = world.skin()->volume_mm3();
  s.removed_mm3 = world.skin()->removed_volume_mm3();
  const SurfaceView& v = world.topology()->view;
  std::map<int32_t, double> volume;
  const std::vector<int32_t> component = surface_components(v);
  for (size_t t = 0; t < v.tri.size(); ++t) {
    const Vec3 &a = v.X_mm[size_t(v.tri[t][0])], &b = v.X_mm[size_t(v.tri[t][1])], &c = v.X_mm[size_t(v.tri[t][2])];
    volume[component[t]] += a.dot(b.cross(c)) / 6;
    if (v.kind[t] == FaceKind::wall) s.wall_mm2 += (b - a).cross(c - a).norm() / 2;
  }
  s.chi = int(v.X_mm.size()) - int(v.tri.size()) / 2;  // closed: three edges to two triangles
  for (const auto& [id, mm3] : volume) s.piece_mm3.push_back(mm3);
  std::sort(s.piece_mm3.begin(), s.piece_mm3.end());
  return s;
}

void expect_same(const Shape& a, const Shape& b, double relative, double wall_relative) {
  EXPECT_EQ(a.pieces, b.pieces);
  EXPECT_EQ(a.chi, b.chi);
  EXPECT_NEAR(a.volume_mm3 / b.volume_mm3, 1, relative);
  EXPECT_NEAR(a.removed_mm3, b.removed_mm3, relative * a.volume_mm3);
  EXPECT_NEAR(a.wall_mm2 / b.wall_mm2, 1, wall_relative);
  ASSERT_EQ(a.piece_mm3.size(), b.piece_mm3.size());
  for (size_t i = 0; i < a.piece_mm3.size(); ++i) EXPECT_NEAR(a.piece_mm3[i] / b.piece_mm3[i], 1, relative);
}

void draw(World& world, const std::vector<ChartPoint>& path, double piece_mm, double depth, double angle,
          int stroke = 1) {
  const auto pieces = test::drawn_pieces(path, piece_mm);
  for (size_t i = 0; i < pieces.size(); ++i) {
    const Outcome o = world.apply(InciseMore{stroke, pieces[i], depth, angle, i + 1 == pieces.size()});
    ASSERT_TRUE(o.done) << "piece " << i + 1 << " of " << pieces.size() << ": " << o.reason;
  }
}
/// The same points in one piece.
void draw_at_once(World& world, const std::vector<ChartPoint>& path, double piece_mm, double depth, double angle) {
  std::vector<ChartPoint> all;
  for (const auto& p : test::drawn_pieces(path, piece_mm)) all.insert(all.end(), p.begin(), p.end());
  const Outcome o = world.apply(InciseMore{1, all, depth, angle, true});
  ASSERT_TRUE(o.done) << o.reason;
}

struct Case {
  const char* name;
  std::vector<Command> before;
  std::vector<ChartPoint> path;
  double depth = 4, angle = 90;
};

std::vector<Case> cases() {
  const std::vector<ChartPoint> line{{-20, 1.3}, {20, 1.3}}, bent{{-20, -6}, {-2, -7}, {6, 8}, {19, 11}};
  std::vector<ChartPoint> curve;
  for (int i = 0; i <= 24; ++i) curve.push_back({-18 + 1.5 * i, 7 * std::sin(0.25 * i)});
  const Incise across{{{3.1, -16}, {2.2, 15}}, 4, 90};
  return {
      {"straight", {}, line},
      {"leaning", {}, line, 4, 55},
      {"bent", {}, bent},
      {"bent and leaning", {}, bent, 3.5, 70},
      {"bent and leaning the other way", {}, bent, 4, 125},
      {"sharp and leaning", {}, {{-20, 0}, {3, 1}, {-12, 9}}, 4, 60},
      {"curve", {}, curve},
      {"leaning curve", {}, curve, 3, 75},
      {"through an older wall", {across}, line},
      {"through a deeper one and a shallower one",
       {Incise{{{-9, -9}, {-8, 12}}, 6, 90}, Incise{{{8, -9}, {7, 12}}, 2.5, 70}},
       line,
       4,
       90},
      {"onto an older wall", {across}, {{-24, 0.4}, {2.4, 1}}},
      {"a little across an older wall", {across}, {{-24, 0.4}, {2.9, 1}}},
      {"from an older wall", {across}, {{2.9, -3}, {25, 4}}},
      {"from wall to wall", {across, Incise{{{22, -16}, {23, 15}}, 4, 90}}, {{2.9, 2}, {22.3, 4}}},
      {"over a hole", {Excise{{{-5, -5}, {5, -5}, {5, 6}, {-5, 6}}, 4}}, line, 3},
      {"into a hole", {Excise{{{-5, -5}, {5, -5}, {5, 6}, {-5, 6}}, 3}}, {{-22, 1}, {2, 1.5}}, 4},
      {"out of a hole", {Excise{{{-5, -5}, {5, -5}, {5, 6}, {-5, 6}}, 3}}, {{1, 1}, {22, 1.5}}, 4},
  };
}

TEST(Drawing, PiecesMakeTheCutOfTheWholePath) {
  InlineWorkers workers;
  for (const Case& c : cases())
    for (const double piece_mm : {5.0, 2.3, 0.7}) {
      SCOPED_TRACE(std::string(c.name) + ", pieces of " + std::to_string(piece_mm) + " mm");
      World whole(block(), workers), pieces(block(), workers);
      for (World* w : {&whole, &pieces})
        for (const Command& k : c.before) {
          const Outcome o = w->apply(k);
          ASSERT_TRUE(o.done) << o.reason;
        }
      ASSERT_NO_FATAL_FAILURE(draw_at_once(whole, c.path, piece_mm, c.depth, c.angle));
      ASSERT_NO_FATAL_FAILURE(draw(pieces, c.path, piece_mm, c.depth, c.angle));
      expect_same(shape(pieces), shape(whole), 1e-9, 1e-9);
    }
}

TEST(Drawing, IsTheIncisionOfTheSamePath) {
  // Incise divides a path in its own way, and a drawn blade's corners are moved aside by up to 8 micrometres: with 3 to
  // 4 mm of depth the same wall within 2 * 0.008 / 4 = 4e-3.
  InlineWorkers workers;
  for (const Case& c : cases()) {
    if (std::string(c.name).ends_with("curve") || c.angle != 90) continue;  // other columns on a curve, other mitres
    SCOPED_TRACE(c.name);
    World at_once(block(), workers), pieces(block(), workers);
    for (World* w : {&at_once, &pieces})
      for (const Command& k : c.before) ASSERT_TRUE(w->apply(k).done);
    const Outcome o = at_once.apply(Incise{c.path, c.depth, c.angle});
    ASSERT_TRUE(o.done) << o.reason;
    ASSERT_NO_FATAL_FAILURE(draw(pieces, c.path, 5, c.depth, c.angle));
    expect_same(shape(pieces), shape(at_once), 1e-9, 4e-3);
  }
}

/// Strokes that meet earlier cuts, or themselves, otherwise than by crossing them.
std::vector<Case> meeting_cases() {
  const Incise line{{{-20, 1.3}, {20, 1.3}}, 4, 90};
  const Incise deep{{{-20, 1.3}, {20, 1.3}}, 6.5, 90};
  const std::vector<ChartPoint> alpha{{-20, 0}, {10, 0}, {14, 8}, {4, 12}, {-4, -12}};
  const std::vector<ChartPoint> nine{{-20, 0}, {10, 0}, {14, 8}, {4, 12}, {0, 0.3}},
      six{{0, 0.3}, {4, 12}, {14, 8}, {10, 0}, {-20, 0}};
  const std::vector<ChartPoint> ring{{-12, -9}, {12, -10}, {11, 10}, {-11, 9}, {-12, -9}};
  std::vector<ChartPoint> eight, past_ring = ring;
  for (int i = 0; i <= 32; ++i) eight.push_back({20 * std::sin(M_PI * i / 16), 11 * std::sin(M_PI * i / 8)});
  past_ring.back() = {-12.1, -10.2};
  return {
      {"all of a wall deeper", {line}, {{-20, 1.3}, {20, 1.3}}, 7},
      {"the same the other way round", {line}, {{20, 1.3}, {-20, 1.3}}, 7},
      {"beside it, as a hand does", {line}, {{-20, 1.5}, {-9, 1.1}, {3, 1.4}, {20, 1.2}}, 7},
      {"the middle of a wall deeper", {line}, {{-9, 1.3}, {9, 1.4}}, 7},
      {"deeper and on beyond its end", {line}, {{-4, 1.3}, {20, 1.3}, {33, 4}}, 7},
      {"onto a wall and deeper along it", {line}, {{-34, 1}, {-20, 1.3}, {6, 1.3}}, 7},
      {"past both ends", {line}, {{-33, 1.3}, {33, 1.3}}, 7},
      {"past both ends, not deeper", {line}, {{-33, 1.3}, {33, 1.3}}, 4},
      {"leaving the wall in its middle", {line}, {{-18, 1.3}, {0, 1.3}, {14, 14}}, 7},
      {"two walls, one after the other",
       {Incise{{{-25, 1.3}, {-5, 1.3}}, 3, 90}, Incise{{{5, 1.3}, {25, 1.3}}, 4, 90}},
       {{-25, 1.3}, {25, 1.3}},
       6},
      {"a wall that another crosses", {line, Incise{{{1, -15}, {3, 17}}, 5, 90}}, {{-20, 1.3}, {20, 1.3}}, 7},
      {"on from an end", {line}, {{20.2, 1.4}, {34, 8}}, 4},
      {"on from an end, deeper", {line}, {{19.8, 1.2}, {34, 8}}, 6.5},
      {"on from an end, shallower", {deep}, {{20, 1.3}, {33, -6}}, 3},
      {"onto an end", {line}, {{33, 9}, {20.3, 1.2}}, 4},
      {"from an end to another", {line, Incise{{{-20, 20}, {20, 21}}, 5, 90}}, {{20, 1.3}, {24, 11}, {20, 21}}, 4},
      {"across itself", {}, alpha},
      {"across itself, through", {}, alpha, 12},
      {"onto its own middle", {}, nine, 12},
      {"beginning beside its own middle", {}, six, 12},
      {"a ring", {}, ring},
      {"a ring, through", {}, ring, 12},
      {"a ring, past its beginning", {}, past_ring, 12},
      {"an eight", {}, eight},
      {"an eight, through", {}, eight, 12},
  };
}

TEST(Drawing, MeetsWhatIsThereAsTheIncisionDoes) {
  InlineWorkers workers;
  for (const Case& c : meeting_cases()) {
    SCOPED_TRACE(c.name);
    World at_once(block(), workers);
    for (const Command& k : c.before) ASSERT_TRUE(at_once.apply(k).done);
    const Outcome o = at_once.apply(Incise{c.path, c.depth, c.angle});
    ASSERT_TRUE(o.done) << o.reason;
    for (const double piece_mm : {5.0, 1.7}) {
      SCOPED_TRACE("in pieces of " + std::to_string(piece_mm) + " mm");
      World whole(block(), workers), pieces(block(), workers);
      for (World* w : {&whole, &pieces})
        for (const Command& k : c.before) ASSERT_TRUE(w->apply(k).done);
      ASSERT_NO_FATAL_FAILURE(draw_at_once(whole, c.path, piece_mm, c.depth, c.angle));
      ASSERT_NO_FATAL_FAILURE(draw(pieces, c.path, piece_mm, c.depth, c.angle));
      // Corners within half a millimetre (points of a drawn path keep that distance), ends pushed through a wall by a
      // tenth, feet of a deepened wall 0.04 apart; a stub that is cut before the end comes back past it; a bend of half
      // a millimetre (of 20 across) where a path passes its own beginning.
      expect_same(shape(whole), shape(at_once), 1.5e-2, 2.5e-2);
      expect_same(shape(pieces), shape(whole), 1e-4, 1e-2);
      EXPECT_EQ(pieces.skin()->arrangement()->check_all(), "");
    }
  }
}

// A leaning blade cannot turn a sharp corner as deep as it is elsewhere. Drawn in pieces it goes on past the corner as
// the stroke that is made at once does, whether it is new or runs along a wall and deepens it.
TEST(Drawing, LeaningStrokesTurnSharpCornersInShortPieces) {
  InlineWorkers workers;
  int deepened = 0, made = 0, bridges = 0;
  for (const double turn_deg : {60.0, 100.0, 140.0})
    for (const double angle : {45.0, 60.0, 125.0})
      for (const bool along : {false, true}) {
        const double t = turn_deg * M_PI / 180;
        const std::vector<ChartPoint> path{{-17, -3}, {2, -3}, {2 + 15 * std::cos(t), -3 + 15 * std::sin(t)}};
        World at_once(block(), workers);
        if (along) {
          ASSERT_TRUE(at_once.apply(Incise{path, 2.5, angle}).done);
        }
        const double depth = along ? 5 : 4;
        const bool possible = at_once.apply(Incise{path, depth, angle}).done;
        const Shape expected = shape(at_once);
        for (const double piece_mm : {5.0, 1.7, 0.8}) {
          SCOPED_TRACE("turned by " + std::to_string(turn_deg) + ", leaning at " + std::to_string(angle) +
                       (along ? ", deepened" : ", new") + ", in pieces of " + std::to_string(piece_mm));
          World pieces(block(), workers);
          if (along) {
            ASSERT_TRUE(pieces.apply(Incise{path, 2.5, angle}).done);
          }
          int refused = 0;
          std::string why;
          for (const std::vector<ChartPoint>& p : test::drawn_pieces(path, piece_mm)) {
            const Outcome o = pieces.apply(InciseMore{1, p, depth, angle, false});
            if (!o.done) ++refused, why = o.reason;
          }
          const Outcome o = pieces.apply(InciseMore{1, {path.back()}, depth, angle, true});
          if (!o.done) ++refused, why = o.reason;
          EXPECT_TRUE(!possible || refused == 0) << refused << " refused: " << why;
          if (!possible || refused) continue;
          const Shape got = shape(pieces);
          // Deepened walls have their columns already; new ones turn upright at the corner, each in its own way
          // (2026-11-21: up to 3.2 and 20.6 % of the wall).
          EXPECT_NEAR(got.wall_mm2 / expected.wall_mm2, 1, along ? 0.04 : 0.22);
          EXPECT_EQ(got.pieces, expected.pieces);
          if (along) {
            EXPECT_LE(got.chi, expected.chi);
            bridges += got.chi < expected.chi;
          }
          EXPECT_EQ(pieces.skin()->arrangement()->check_all(), "");
          ++(along ? deepened : made);
        }
      }
  EXPECT_GT(deepened, 25);
  EXPECT_GT(made, 25);
  EXPECT_EQ(
      bridges,
      0);  // tissue left across the cut at the corner (many more of them: tests/sim/cutting/test_leaning_strokes.cpp)
}

TEST(Drawing, AStrokeThatClosesAFlapFreesIt) {
  InlineWorkers workers;
  World whole(block(), workers), pieces(block(), workers);
  for (World* w : {&whole, &pieces}) {
    ASSERT_TRUE(w->apply(Incise{{{-12, -12}, {-12.5, 10}, {12, 10.5}, {12, -12}}, 4, 90}).done);
    const Outcome o = w->apply(Undermine{{{-12, -9}, {12, -9}, {12, 10}, {-12, 10}}, 4});
    ASSERT_TRUE(o.done) << o.reason;
  }
  const std::vector<ChartPoint> path{{-12, -4}, {0, -6}, {11.9, -3}};
  ASSERT_NO_FATAL_FAILURE(draw_at_once(whole, path, 5, 4, 90));
  ASSERT_NO_FATAL_FAILURE(draw(pieces, path, 5, 4, 90));
  EXPECT_EQ(pieces.skin()->pieces(), 2);
  expect_same(shape(pieces), shape(whole), 1e-9, 1e-9);
}

TEST(Drawing, UndoAndRedoTakeTheWholeStroke) {
  InlineWorkers workers;
  World world(block(), workers);
  StepSettings s;
  s.max_iterations = 5;
  world.step(s);
  ASSERT_TRUE(world.apply(Incise{{{3.1, -16}, {2.2, 15}}, 4, 90}).done);
  world.step(s);
  uint64_t before = 0;  // the first piece that cuts
  const uint64_t topology = world.topology_hash();
  for (const auto& p : test::drawn_pieces({{-24, 0.4}, {2.4, 1}}, 5)) {
    if (world.topology_hash() == topology) before = world.full_hash();
    ASSERT_TRUE(world.apply(InciseMore{7, p, 4, 80, false}).done);
    world.step(s);
    world.step(s);
  }
  ASSERT_TRUE(world.apply(InciseMore{7, {{2.5, 1.1}}, 4, 80, true}).done);
  world.step(s);
  const uint64_t after = world.full_hash();
  ASSERT_TRUE(world.apply(Undo{}).done);
  EXPECT_EQ(world.full_hash(), before);
  ASSERT_TRUE(world.apply(Redo{}).done);
  EXPECT_EQ(world.full_hash(), after);
  ASSERT_TRUE(world.apply(Undo{}).done);
  EXPECT_EQ(world.full_hash(), before);
}

TEST(Drawing, OpensWhileItIsDrawn) {
  InlineWorkers workers;
  World world(block(), workers);
  double wall = 0;
  int opened = 0;
  const auto pieces = test::drawn_pieces({{-20, 1.3}, {20, 1.3}}, 5);
  for (size_t i = 0; i < pieces.size(); ++i) {
    ASSERT_TRUE(world.apply(InciseMore{1, pieces[i], 4, 90, i + 1 == pieces.size()}).done);
    const double now = shape(world).wall_mm2;
    // Both banks, 4.2 mm deep: what is drawn, but for what is held back and what a piece of two quads at least leaves.
    EXPECT_GE(now, 2 * 4.1 * (5.0 * double(i + 1) - 3.2 - 3.9));
    opened += now > wall;
    wall = now;
  }
  EXPECT_GE(opened, 7);
}

TEST(Drawing, AStrokeThatCannotGoOnStopsThere) {
  InlineWorkers workers;
  World world(block(), workers);
  ASSERT_TRUE(world.apply(InciseMore{1, {{20, 0}, {30, 1}}, 4, 90, false}).done);
  const uint64_t hash = world.full_hash();
  const Outcome off = world.apply(InciseMore{1, {{45, 1}}, 4, 90, false});
  EXPECT_FALSE(off.done);
  EXPECT_NE(off.reason.find("not on the skin"), std::string::npos) << off.reason;
  EXPECT_EQ(world.full_hash(), hash);
  EXPECT_FALSE(world.apply(InciseMore{1, {{30, 5}}, 4, 90, false}).done) << "the rest of it is refused";
  EXPECT_FALSE(world.apply(InciseMore{1, {{25, 5}}, 4, 90, true}).done);
  EXPECT_EQ(world.full_hash(), hash);
  EXPECT_GT(shape(world).wall_mm2, 30) << "what was cut stays";
  EXPECT_TRUE(world.apply(InciseMore{1, {{-20, 0}, {-5, 1}}, 4, 90, true}).done) << "the number is free again";
  ASSERT_TRUE(world.apply(Undo{}).done);
  EXPECT_EQ(world.full_hash(), hash);
  ASSERT_TRUE(world.apply(Undo{}).done);
  EXPECT_EQ(shape(world).wall_mm2, 0);
}

TEST(Drawing, OtherActsEndAStroke) {
  InlineWorkers workers;
  World world(block(), workers);
  ASSERT_TRUE(world.apply(InciseMore{4, {{-20, 0}, {-5, 1}}, 4, 90, false}).done);
  ASSERT_TRUE(world.apply(Incise{{{0, 20}, {20, 22}}, 4, 90}).done);
  EXPECT_FALSE(world.apply(InciseMore{4, {{5, 1}}, 4, 90, false}).done);
  EXPECT_TRUE(world.apply(InciseMore{5, {{-20, -10}, {-5, -9}}, 4, 90, false}).done);
  ASSERT_TRUE(world.apply(Undo{}).done);
  EXPECT_FALSE(world.apply(InciseMore{5, {{5, -9}}, 4, 90, true}).done) << "taken back while it was drawn";
  EXPECT_TRUE(world.apply(SetHook{1, {0, 0}}).done);
  EXPECT_TRUE(world.apply(InciseMore{6, {{-20, -10}, {-5, -9}}, 4, 90, false}).done);
  EXPECT_TRUE(world.apply(MoveHook{1, {0, 0, 3}, 0}).done) << "the other hand may move";
  EXPECT_TRUE(world.apply(InciseMore{6, {{5, -9}}, 4, 90, true}).done);
  EXPECT_FALSE(world.apply(InciseMore{0, {{5, -9}, {8, 9}}, 4, 90, true}).done);
  EXPECT_FALSE(world.apply(InciseMore{9, {{5, 15}, {5.5, 15}}, 4, 90, true}).done) << "half a millimetre";
}

TEST(Drawing, RandomStrokesStaySound) {
  // Tremor, loops and crossings of their own path: done or refused, volume balanced, and undone to the bit.
  InlineWorkers workers;
  int pieces = 0, refused = 0;
  for (uint64_t seed = 1; seed <= 6; ++seed) {
    std::mt19937_64 rng(seed);
    const auto real = [&](double lo, double hi) { return lo + (hi - lo) * double(rng() >> 11) / 9007199254740992.0; };
    WorldSpec spec = block();
    spec.refine_fronts = seed % 2;
    World world(spec, workers);
    const uint64_t first = world.full_hash();
    const double volume = world.skin()->volume_mm3();
    int strokes = 0;
    for (int stroke = 1; stroke <= 4; ++stroke) {
      Vec2 at(real(-25, 25), real(-25, 25));
      double heading = real(0, 6.28);
      const double angle = real(60, 120);
      bool going = true;
      for (int i = 0; i < 10 && going; ++i) {
        std::vector<ChartPoint> points;
        for (int k = 0; k < 4; ++k) {
          heading += real(-0.5, 0.5);
          at += Vec2(std::cos(heading), std::sin(heading)) * real(0.8, 1.6);
          points.push_back(at);
        }
        const uint64_t before = world.full_hash();
        going = world.apply(InciseMore{stroke, points, 4, angle, i == 9}).done;
        ++pieces;
        if (!going) {
          EXPECT_EQ(world.full_hash(), before);
          ++refused;
        }
      }
      EXPECT_NEAR((world.skin()->volume_mm3() + world.skin()->removed_volume_mm3()) / volume, 1, 1e-9);
    }
    while (world.apply(Undo{}).done) ++strokes;
    EXPECT_LE(strokes, 4);
    EXPECT_EQ(world.full_hash(), first);
  }
  RecordProperty("pieces", pieces);
  EXPECT_LT(refused, pieces / 4) << refused << " of " << pieces;
}

TEST(Drawing, StrokesAreJoinedForAHand) {
  const std::vector<Command> c{Stage{"a"}, InciseMore{3, {{0, 0}, {5, 0}}, 5, 80, false}, MoveHook{1, {0, 0, 1}, 0},
                               InciseMore{3, {{5, 0}, {9, 0}}, 4, 90, true},
                               InciseMore{3, {{0, 9}, {9, 9}}, 3, 90, true}};
  const std::vector<Command> joined = join_strokes(c);
  ASSERT_EQ(joined.size(), 4u);
  const auto& a = std::get<Incise>(joined[1]);
  EXPECT_EQ(a.path, (std::vector<ChartPoint>{{0, 0}, {5, 0}, {9, 0}}));
  EXPECT_EQ(a.depth_mm, 5);
  EXPECT_EQ(a.angle_deg, 80);
  EXPECT_EQ(std::get<Incise>(joined[3]).path.size(), 2u);
}

}  // namespace test_drawing
}  // namespace limberg
