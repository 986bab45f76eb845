// Chart points, depths and frames against what a flat block and a sphere-like body say in closed form.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "sim/body/block.h"
#include "sim/body/skin.h"

namespace limberg {
namespace test_skin {

std::shared_ptr<Body> block() {
  BlockSpec s;
  s.size_mm = {40, 30, 10};
  s.skin_cell_mm = 1;
  s.layers = {{"skin", 1.5, {}}, {"fat", 8.5, {}}};
  return std::make_shared<Body>(make_block(s));
}

// A hemisphere-like dome: the block bent upwards, z = -r^2/200 on top.
std::shared_ptr<Body> dome() {
  auto b = block();
  for (Vec3& X : b->surface.X_mm) X.z() -= X.head<2>().squaredNorm() / 200;
  return b;
}

TEST(Skin, ChartPointsOfABlock) {
  const Skin skin(block());
  std::mt19937_64 rng(1);
  std::uniform_real_distribution<double> u(-1, 1);
  for (int n = 0; n < 1000; ++n) {
    const ChartPoint p(20 * u(rng), 15 * u(rng));
    const auto hit = skin.at(p);
    ASSERT_TRUE(hit);
    EXPECT_LT((hit->X_mm - Vec3(p.x(), p.y(), 0)).norm(), 1e-12 * 100);
    EXPECT_EQ(hit->normal, Vec3::UnitZ());
    EXPECT_EQ(skin.body().surface.tag[size_t(hit->triangle)], SurfaceTag::skin);
  }
  for (const Vec3& X : skin.body().surface.X_mm) EXPECT_TRUE(skin.at({X.x(), X.y()})) << X.transpose();
  EXPECT_FALSE(skin.at({20.01, 0}));
  EXPECT_FALSE(skin.at({0, -15.01}));
  EXPECT_FALSE(skin.at({NAN, 0}));
  EXPECT_FALSE(skin.at({1e300, INFINITY}));
}

TEST(Skin, DepthAndLayersOfABlock) {
  const Skin skin(block());
  EXPECT_DOUBLE_EQ(skin.area_mm2(), 1200);
  std::mt19937_64 rng(2);
  std::uniform_real_distribution<double> u(-1, 1);
  for (int n = 0; n < 1000; ++n) {
    const Vec3 X(20 * u(rng), 15 * u(rng), 10 * u(rng));
    EXPECT_NEAR(skin.depth_mm(X), -X.z(), 1e-12);
  }
  for (const Vec3& X : skin.body().surface.X_mm)  // nearest features are corners and edges here
    if (std::abs(X.x()) < 20 && std::abs(X.y()) < 15) {
      EXPECT_DOUBLE_EQ(skin.depth_mm({X.x(), X.y(), -3}), 3);
      EXPECT_DOUBLE_EQ(skin.depth_mm({X.x(), X.y(), 3}), -3);
    }
  EXPECT_EQ(skin.layer_at(-1), 0);
  EXPECT_EQ(skin.layer_at(1.49), 0);
  EXPECT_EQ(skin.layer_at(1.5), 1);
  EXPECT_EQ(skin.layer_at(99), 1);
}

TEST(Skin, DepthIsSignedOnACurvedSurface) {
  const Skin skin(dome());
  std::mt19937_64 rng(3);
  std::uniform_real_distribution<double> u(-1, 1);
  for (int n = 0; n < 2000; ++n) {
    const Vec3 p(15 * u(rng), 10 * u(rng), 0);
    const double z = -p.squaredNorm() / 200, offset = 4 * u(rng);
    if (std::abs(offset) < 0.02) continue;  // the facets lie up to h^2 / 8r = 1/800 mm off the paraboloid
    EXPECT_EQ(skin.depth_mm({p.x(), p.y(), z + offset}) < 0, offset > 0);
  }
}

TEST(Skin, DepthIsSignedAboveASharpRidge) {
  // A roof z = -1.5 |x|: its faces' normals are 113 degrees apart,
  // so above the ridge a single face would take the wrong side.
  auto b = block();
  for (Vec3& X : b->surface.X_mm) X.z() -= 1.5 * std::abs(X.x());
  const Skin skin(b);
  std::mt19937_64 rng(5);
  std::uniform_real_distribution<double> u(-1, 1);
  for (int n = 0; n < 2000; ++n) {
    const double y = 12 * u(rng), a = 0.98 * u(rng) * std::atan(1.5), r = 3 * std::abs(u(rng)) + 0.01;
    EXPECT_NEAR(skin.depth_mm({r * std::sin(a), y, r * std::cos(a)}), -r, 1e-9);  // in the fan over the ridge
    EXPECT_GT(skin.depth_mm({0, y, -r}), 0);
  }
}

TEST(Skin, FramesAreOrthonormalAndFollowTheTensionLines) {
  for (const auto& body : {block(), dome()}) {
    body->tension_direction = Vec3(0.6, 0.8, 0);
    const Skin skin(body);
    std::mt19937_64 rng(4);
    std::uniform_real_distribution<double> u(-1, 1);
    for (int n = 0; n < 200; ++n) {
      const Vec3 X(12 * u(rng), 9 * u(rng), -3);
      const auto f = skin.frame(X);
      Mat3 R;
      R << f.along, f.across, f.normal;
      EXPECT_LT((R.transpose() * R - Mat3::Identity()).norm(), 1e-12);
      EXPECT_NEAR(R.determinant(), 1, 1e-12);
      EXPECT_GT(f.along.dot(body->tension_direction), 0.9);
      const SkinHit near = skin.nearest(X);
      EXPECT_GT(near.normal.dot(f.normal), std::cos(0.02));  // facets of 1 mm on a curvature of 1/100 mm
    }
  }
  auto upright = block();
  upright->tension_direction = Vec3::UnitZ();
  EXPECT_TRUE(Skin(upright).frame({0, 0, -1}).along.isApprox(Vec3::UnitX()));
}

}  // namespace test_skin
}  // namespace limberg
