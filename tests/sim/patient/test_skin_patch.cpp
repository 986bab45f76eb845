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
      ASSERT_EQ(places.size(), 7u) << t << " " << radius;
      Vec3 mean = Vec3::Zero();
      Mat3 spread = Mat3::Zero();
      for (const SurfacePoint& p : places) {
        EXPECT_GE(p.bary.minCoeff(), -1e-12);
        EXPECT_NEAR(p.bary.sum(), 1, 1e-12);
        const Vec3 d = place(v, p) - place(v, middle);
        mean += d / 7, spread += d * d.transpose() / 7;
      }
      // A walk starts a thousandth of a triangle beside the middle.
      EXPECT_LT(mean.norm(), 1e-3);
      const Mat3 disc = Vec3(1, 1, 0).asDiagonal() * (radius * radius / 4);
      EXPECT_LT((spread - disc).norm(), 2e-3 * radius) << spread;
    }
}

TEST(SkinPatch, FollowsCurvedSkin) {
  const double ball = 20, radius = 4, way = std::sqrt(7.0 / 12) * radius;
  const SurfaceView v = skin(24, 0.5, ball);
  const SurfacePoint middle{600, {0.3, 0.3, 0.4}};
  const auto places = skin_patch(v, middle, radius);
  ASSERT_EQ(places.size(), 7u);
  for (size_t i = 1; i < places.size(); ++i) {
    const Vec3 x = place(v, places[i]), X = place(v, middle);
    const double along = ball * std::acos(x.normalized().dot(X.normalized()));
    EXPECT_NEAR(along, way, 0.01 * way) << "as far along the skin as on a plane";
    EXPECT_NEAR(x.norm(), ball, 0.02);
    for (size_t k = 1; k < i; ++k) EXPECT_GT((x - place(v, places[k])).norm(), 0.9 * way) << "one place twice";
  }
}

TEST(SkinPatch, ATipWithoutASizeIsAPlace) {
  const SurfaceView v = skin(4, 1, 0);
  EXPECT_EQ(skin_patch(v, {9, {0.2, 0.5, 0.3}}, 0).size(), 1u);
}

TEST(SkinPatch, EndsWhereTheSkinEnds) {
  const SurfaceView v = skin(4, 1, 0);
  for (size_t t = 0; t < v.tri.size(); ++t) {
    const auto places = skin_patch(v, {int32_t(t), {0.2, 0.5, 0.3}}, 6);
    EXPECT_EQ(places.size(), 1u) << "the square is 4 mm wide";
  }
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
  EXPECT_EQ(held(tissue, holding.hooks[0]).size(), 7u);
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
  EXPECT_LT(one.size(), 7u) << "the cut has taken the far part of the piece";
  EXPECT_GE(one.size(), 4u);
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
