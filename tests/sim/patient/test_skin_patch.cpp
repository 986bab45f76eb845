// What the tip of a hook holds: places of skin around its middle, never across a wound's edge.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "sim/cutting/strokes/drawn_stroke.h"
#include "sim/patient/hooks.h"
#include "sim/patient/skin_patch.h"
#include "sim/patient/tissue_cut.h"
#include "sim/patient/world.h"
#include "tests/sim/patient/small_block.h"

namespace limberg {
namespace test_skin_patch {

using test::small_block;
using test::SmallBlock;

constexpr int kPlaces = 43;  // of a hook's tip

// A square of skin of n x n cells of two triangles, its vertices moved at random, bent to a ball of that radius (0:
// flat).
SurfaceView skin(int n, double cell_mm, double ball_mm) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> off(-0.3 * cell_mm, 0.3 * cell_mm);
  SurfaceView v;
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) {
      Vec3 x(cell_mm * (i - 0.5 * n) + off(random), cell_mm * (j - 0.5 * n) + off(random), 0);
      if (ball_mm > 0) {
        const double r = x.norm(), angle = r / ball_mm;
        if (r > 0) x *= ball_mm * std::sin(angle) / r;
        x.z() = ball_mm * std::cos(angle);
      }
      v.X_mm.push_back(x);
    }
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const int32_t a = j * (n + 1) + i, b = a + 1, c = b + n + 1, d = c - 1;
      v.tri.push_back({a, b, c}), v.tri.push_back({a, c, d});
    }
  for (size_t t = 0; t < v.tri.size(); ++t) v.kind.push_back(FaceKind::skin), v.rim.push_back(0);
  return v;
}

Vec3 place(const SurfaceView& v, const SurfacePoint& p) {
  Vec3 x = Vec3::Zero();
  for (int k = 0; k < 3; ++k) x += p.bary[k] * v.X_mm[size_t(v.tri[size_t(p.triangle)][size_t(k)])];
  return x;
}

TEST(SkinPatch, HasTheMeanAndTheSpreadOfADisc) {
  const SurfaceView v = skin(20, 0.7, 0);
  for (int32_t t : {420, 381, 422, 463})
    for (const double radius : {0.1, 1.0, 3.0}) {
      const SurfacePoint middle{t, {0.2, 0.5, 0.3}};
      const auto places = skin_patch(v, middle, radius);
      ASSERT_EQ(places.size(), size_t(kPlaces)) << t << " " << radius;
      Vec3 mean = Vec3::Zero();
      Mat3 spread = Mat3::Zero();
      for (const SurfacePoint& p : places) {
        EXPECT_GE(p.bary.minCoeff(), -1e-12);
        EXPECT_NEAR(p.bary.sum(), 1, 1e-12);
        const Vec3 d = place(v, p) - place(v, middle);
        mean += d / kPlaces, spread += d * d.transpose() / kPlaces;
      }
      // A walk starts a thousandth of a triangle beside the middle.
      EXPECT_LT(mean.norm(), 1e-3);
      const Mat3 disc = Vec3(1, 1, 0).asDiagonal() * (radius * radius / 4);
      EXPECT_LT((spread - disc).norm(), 2e-3 * radius) << spread;
    }
}

TEST(SkinPatch, FollowsCurvedSkin) {
  const double ball = 20, radius = 4;
  // How far the rings lie out: what a disc of `within` equal parts and half of the ring's own reaches.
  const double all = kPlaces, to = radius * std::sqrt(all / (all * all - 1));
  const double way[3] = {2 * to, std::sqrt(13.0) * to, std::sqrt(31.0) * to};
  const SurfaceView v = skin(24, 0.5, ball);
  const SurfacePoint middle{600, {0.3, 0.3, 0.4}};
  const auto places = skin_patch(v, middle, radius);
  ASSERT_EQ(places.size(), size_t(kPlaces));
  for (size_t i = 1; i < places.size(); ++i) {
    const Vec3 x = place(v, places[i]), X = place(v, middle);
    const double along = ball * std::acos(x.normalized().dot(X.normalized()));
    const double ring = way[i < 7 ? 0 : i < 19 ? 1 : 2];
    EXPECT_NEAR(along, ring, 0.01 * ring) << "as far along the skin as on a plane";
    EXPECT_NEAR(x.norm(), ball, 0.02);
    for (size_t k = 1; k < i; ++k) EXPECT_GT((x - place(v, places[k])).norm(), 0.15 * radius) << "one place twice";
  }
}

TEST(SkinPatch, ATipWithoutASizeIsAPlace) {
  const SurfaceView v = skin(4, 1, 0);
  EXPECT_EQ(skin_patch(v, {9, {0.2, 0.5, 0.3}}, 0).size(), 1u);
}

TEST(SkinPatch, EndsWhereTheSkinEnds) {
  const SurfaceView v = skin(4, 1, 0);
  for (size_t t = 0; t < v.tri.size(); ++t) {
    const auto places = skin_patch(v, {int32_t(t), {0.2, 0.5, 0.3}}, 40);
    EXPECT_EQ(places.size(), 1u) << "the square is 4 mm wide";
  }
}

// ---- what a stitch holds

// Of a wedge: triangles around its tip (vertex 0) between two edges of a wound.
SurfaceView wedge(double angle, int parts, double size_mm) {
  SurfaceView v;
  v.X_mm.push_back(Vec3::Zero());
  for (int k = 0; k <= parts; ++k)
    v.X_mm.push_back(size_mm * Vec3(std::cos(angle * k / parts), std::sin(angle * k / parts), 0));
  for (int32_t k = 0; k < parts; ++k) {
    v.tri.push_back({0, k + 1, k + 2});
    v.kind.push_back(FaceKind::skin);
    v.rim.push_back(uint8_t((k == 0 ? 1 : 0) | (k == parts - 1 ? 4 : 0)));
  }
  return v;
}

// Sum of the shares, first moment about the middle, and what pulls the wrong way.
struct Bite {
  double sum = 0, against = 0;
  Vec3 first = Vec3::Zero();
};
Bite bite_of(const SurfaceView& v, const SurfacePoint& middle, const std::vector<PatchPlace>& places) {
  Bite b;
  for (const auto& [at, share] : places) {
    b.sum += share, b.against += std::max(0.0, -share);
    b.first += share * (place(v, at) - place(v, middle));
  }
  return b;
}

TEST(BitePatch, StandsForItsMiddleWhateverTheSkinAroundIt) {
  const double pi = std::numbers::pi;
  // From a narrow tip over a straight edge to a corner that goes in, held at the corner and beside it.
  for (const double angle : {0.3, pi / 3, pi / 2, pi, 1.5 * pi, 1.9 * pi})
    for (const double along : {0.0, 0.02, 0.2}) {
      const SurfaceView v = wedge(angle, 12, 10);
      const SurfacePoint middle{0, {1 - along, along, 0}};
      const auto places = bite_patch(v, middle, 2);
      ASSERT_GT(places.size(), 1u) << angle << " " << along;
      const Bite b = bite_of(v, middle, places);
      EXPECT_NEAR(b.sum, 1, 1e-9) << angle << " " << along;
      EXPECT_LT(b.first.norm(), 1e-8) << angle << " " << along;
      // Half a disc has a third of it against the pull: it reaches 2.4 times as far back as its centroid lies.
      EXPECT_LT(b.against, 3) << angle << " " << along;
      for (const auto& [at, share] : places) {
        EXPECT_LT((place(v, at) - place(v, middle)).norm(), 2);
        EXPECT_GE(at.bary.minCoeff(), -1e-12);
      }
    }
}

TEST(BitePatch, IsADiscAwayFromEdgesAndOnePlaceWithoutSkin) {
  const SurfaceView v = skin(20, 0.7, 0);
  const SurfacePoint middle{421, {0.2, 0.5, 0.3}};
  const auto places = bite_patch(v, middle, 2);
  const Bite b = bite_of(v, middle, places);
  EXPECT_NEAR(b.sum, 1, 1e-12);
  EXPECT_LT(b.first.norm(), 1e-9);
  EXPECT_EQ(b.against, 0);
  SurfaceView none = wedge(1, 1, 1);
  none.X_mm[2] = none.X_mm[1];  // a triangle without an area
  EXPECT_EQ(bite_patch(none, {0, {1, 0, 0}}, 2).size(), 1u);
  EXPECT_EQ(bite_patch(wedge(0.05, 1, 10), {0, {1, 0, 0}}, 2).size(), 1u) << "between two of the rays";
}

TEST(BitePatch, ABuriedOneStaysInTheWall) {
  SurfaceView v = skin(20, 0.7, 0);
  // The square stands: its lower half is the wall below the upper one.
  for (size_t t = 0; t < v.tri.size() / 2; ++t) v.kind[t] = FaceKind::wall;
  const SurfacePoint middle{360, {0.2, 0.5, 0.3}};
  for (const auto& [at, share] : bite_patch(v, middle, 3)) EXPECT_EQ(v.kind[size_t(at.triangle)], FaceKind::wall);
  EXPECT_LT(bite_patch(v, middle, 3).size(), bite_patch(skin(20, 0.7, 0), middle, 3).size());
}

// What a stitch in the middle of a slit across the tension takes to close it, in N.
double stitch_N(double bite_mm, double cell_mm) {
  InlineWorkers workers;
  SmallBlock block;
  block.side_mm = 30, block.cell_mm = cell_mm, block.fat = false, block.along = 1.1, block.across = 1.1;
  WorldSpec spec = small_block(block);
  spec.suture_bite_mm = bite_mm;
  World world(spec, workers);
  StepSettings settings;
  settings.max_iterations = 200, settings.tolerance = 1e-4;
  const auto rest = [&] {
    for (int n = 0; n < 40 && world.step(settings).residual > settings.tolerance; ++n) continue;
  };
  EXPECT_TRUE(world.apply(Incise{{{-8, 0.1}, {8, 0.1}}, 4, 90}).done);
  rest();
  EXPECT_TRUE(world.apply(Suture{{0, -0.5}, {0, 0.7}}).done);
  for (int n = 0; n < 200 && !world.settled(); ++n) world.step(settings);
  rest();
  Snapshot s;
  world.fill(s);
  return double(s.sutures.at(0).force_N);
}

TEST(BitePatch, TheForceOfAStitchHasALimitAsCellsShrink) {
  // A point cuts the deeper into its cell the smaller that is (Kelvin's solution: by F / (mu r)).
  EXPECT_NEAR(stitch_N(0, 1.25) / stitch_N(0, 2.5), 0.5, 0.1);
  // A bite of 2 mm gives .089, .071 and .063 N at 2.5, 1.25 and .8 mm (2026-11-26), and would settle in the end.
  EXPECT_GT(stitch_N(2, 1.25) / stitch_N(2, 2.5), 0.75);
}

// What a hook holds, as places at rest.
std::vector<Vec3> held(const Tissue& tissue, const Hook& hook) {
  const FemModel& m = tissue.solver().model();
  std::vector<Vec3> at;
  for (const EmbeddedPoint& p : hook.anchor.wide) {
    Vec3 x = Vec3::Zero();
    for (size_t i = 0; i < 8; ++i) x += double(p.w[i]) * m.X_mm[size_t(p.node[i])];
    at.push_back(x);
  }
  return at;
}

TEST(SkinPatch, AHookBesideAWoundHoldsItsOwnBankOnly) {
  InlineWorkers workers;
  Tissue tissue(small_block(), workers);
  Holding holding;
  Hooks hooks(tissue, holding);
  ASSERT_TRUE(hooks.act(SetHook{1, {0, 0.5}}).done);
  EXPECT_EQ(held(tissue, holding.hooks[0]).size(), size_t(kPlaces));
  TissueCut cut(tissue);
  const std::vector<ChartPoint> line{{-15, 0}, {15, 0}};
  ASSERT_TRUE(cut_whole(tissue.blade_context(), line, 4, 90, false, [&](const Blade& blade) {
                return cut.cut(blade, 7);
              }).ok());
  ASSERT_TRUE(cut.build().done);
  cut.enter();
  cut.keep();
  hooks.carry();
  ASSERT_EQ(holding.hooks.size(), 1u);
  const auto one = held(tissue, holding.hooks[0]);
  EXPECT_LT(one.size(), size_t(kPlaces)) << "the cut has taken the far part of the piece";
  EXPECT_GE(one.size(), size_t(kPlaces) / 2);
  for (const Vec3& x : one) EXPECT_GT(x.y(), 0) << x.transpose();
  ASSERT_TRUE(hooks.act(SetHook{2, {0, -0.5}}).done);
  for (const Vec3& x : held(tissue, holding.hooks[1])) EXPECT_LT(x.y(), 0) << x.transpose();
}

// What drags skin aside by .5 mm, in N: the mean over places, for it depends on where the tip lies in its cell.
double drag_N(double tip_mm, double cell_mm) {
  InlineWorkers workers;
  SmallBlock block;
  block.side_mm = 30, block.cell_mm = cell_mm, block.fat = false, block.along = block.across = 1;
  WorldSpec spec = small_block(block);
  spec.hook_tip_mm = tip_mm, spec.hook_k_N_per_mm = 1000, spec.can_cut = false;
  World world(spec, workers);
  StepSettings settings;
  settings.max_iterations = 100, settings.tolerance = 1e-4;
  double sum = 0;
  const std::vector<Vec2> places{{0.2, 0.1}, {1.3, 0.6}, {2.4, 1.7}, {0.7, 2.3}, {1.9, 1.1}};
  for (const Vec2& at : places) {
    EXPECT_TRUE(world.apply(SetHook{1, at}).done);
    EXPECT_TRUE(world.apply(MoveHook{1, {at.x(), at.y() + 0.5, 0}, 0}).done);
    for (int n = 0; n < 20 && world.step(settings).residual > settings.tolerance; ++n) continue;
    Snapshot s;
    world.fill(s);
    sum += double(s.hooks.at(0).force_N.norm());
    EXPECT_TRUE(world.apply(ReleaseHook{1}).done);
    for (int n = 0; n < 20 && world.step(settings).residual > settings.tolerance; ++n) continue;
  }
  return sum / double(places.size());
}

TEST(SkinPatch, TheForceOnATipHasALimitAsCellsShrink) {
  // What a point drags is as large as a cell, and so is its force (Kelvin's solution: a move of F / (mu r)).
  EXPECT_NEAR(drag_N(0, 1.25) / drag_N(0, 2.5), 0.5, 0.1);
  // Of a tip wider than the cells it is .84 (2026-11-24), and would be 1 in the end.
  EXPECT_GT(drag_N(2, 1.25) / drag_N(2, 2.5), 0.75);
}

TEST(SkinPatch, AHookThatIsSetPullsNothing) {
  InlineWorkers workers;
  World world(small_block(), workers);
  ASSERT_TRUE(world.apply(SetHook{1, {3.2, -4.1}}).done);
  world.step({});
  Snapshot s;
  world.fill(s);
  EXPECT_LT(s.hooks.at(0).force_N.norm(), 1e-4);
}

}  // namespace test_skin_patch
}  // namespace limberg
