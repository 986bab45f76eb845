// Muscles in the tissue under a face: where a bundle lies, and how stiff it is along and across its fibres.
#include <gtest/gtest.h>

#include <cmath>

#include "sim/base/error.h"
#include "sim/skull/face/face_elasticity.h"
#include "tests/sim/skull/face/layers_of_boxes.h"

namespace limberg::simplex {
namespace test_face_bundle {

/// A bar of 2 x 2 x `layers` mm along z, of cubes of 1 mm.
Tissue bar(int layers) { return test::layers_of_boxes(2, 2, layers, 1, 1, Vec2(0, 0)); }

constexpr int kLayers = 41;

FaceBundle lower_half(const Vec3& along, double k1_kPa) {
  FaceBundle b;
  b.name = "m", b.young_kPa = 10, b.k1_kPa = k1_kPa, b.k2 = 0.2, b.radius_mm = 1;
  // Through the middle of each layer up to z = 20, whatever the fibres' way: a path that points along them.
  if (along == Vec3::UnitZ()) return b.radius_mm = 1.5, b.path_mm = {{1, 1, -0.4}, {1, 1, 19.2}}, b;
  b.radius_mm = 9.99, b.path_mm = {Vec3(1, 1, 10) - 0.5 * along, Vec3(1, 1, 10) + 0.5 * along};
  return b;
}

/// How far the place in the middle goes of what the upper end is pulled by, one per cent, the lower end held.
double share_of_pull(const std::vector<FaceBundle>& bundles, int* tetrahedra = nullptr) {
  const Tissue t = bar(kLayers);
  InlineWorkers w;
  ElasticitySettings e;
  e.poisson = 0.3, e.skin_kPa = 0, e.bundles = bundles;
  const FaceElasticity::Body body{&t, 10};
  FaceElasticity fe({&body, 1}, e, w);
  if (tetrahedra) *tetrahedra = fe.bundled()[0].tetrahedra;
  std::vector<uint8_t> held(fe.nodes(), 0);
  std::vector<Vec3> u(fe.nodes(), Vec3::Zero());
  const double pull_mm = 0.01 * 40;
  for (size_t i = 0; i < t.node_mm.size(); ++i) {
    const size_t n = size_t(fe.node(0, i));
    const double z = t.node_mm[i].z();
    held[n] = z < 0.5 || z > 39.5;  // the bar is 40 mm long: the topmost layer goes along
    u[n] = Vec3(0, 0, z > 39.5 ? pull_mm : 0);
  }
  fe.hold(held);
  for (int i = 0; i < 60; ++i)
    if (fe.step(u, 20, 1e-6).converged) break;
  double sum = 0;
  for (size_t i = 0; i < t.node_mm.size(); ++i)
    if (t.node_mm[i].z() == 20) sum += u[size_t(fe.node(0, i))].z() / 9;
  return sum / pull_mm;
}

// Two springs in a row. W = k1 / (2 k2) (exp(k2 E^2) - 1), E = l^2 - 1: near rest the stress along the fibres is
// 4 k1 (l - 1), so that Young's modulus along them is E0 + 4 k1, and the sides stay free.
TEST(FaceBundle, PullsAlongItsFibresAsTheSumOfTheStiffnesses) {
  EXPECT_NEAR(share_of_pull({}), 0.5, 0.005);
  int tetrahedra = 0;
  EXPECT_NEAR(share_of_pull({lower_half(Vec3::UnitZ(), 0)}, &tetrahedra), 0.5, 0.005) << "as soft as what is around it";
  EXPECT_NEAR(tetrahedra, 20 * 4 * 6, 24);
  for (const double k1 : {2.5, 10.}) {
    const double lower = 10 + 4 * k1 * 1.01, upper = 10;  // fibres stiffen a little over one per cent
    EXPECT_NEAR(share_of_pull({lower_half(Vec3::UnitZ(), k1)}), upper / (lower + upper), 0.012) << k1;
  }
}

TEST(FaceBundle, AcrossItsFibresItIsItsMatrix) {
  int tetrahedra = 0;
  EXPECT_NEAR(share_of_pull({lower_half(Vec3::UnitX(), 10)}, &tetrahedra), 0.5, 0.01);
  EXPECT_NEAR(tetrahedra, 20 * 4 * 6, 24);
}

TEST(FaceBundle, ALigamentIsAStifferCord) {
  FaceBundle b = lower_half(Vec3::UnitZ(), 0);
  b.young_kPa = 30;
  EXPECT_NEAR(share_of_pull({b}), 10. / 40, 0.012);
}

TEST(FaceBundle, TheNearestPieceAndTheLastBundleHaveAPlace) {
  FaceBundle bent, other;
  bent.path_mm = {{0, 0, 0}, {10, 0, 0}, {10, 10, 0}}, bent.radius_mm = 2;
  other.path_mm = {{0, -5, 0}, {0, 5, 0}}, other.radius_mm = 1;
  const std::vector<FaceBundle> both{bent, other};
  EXPECT_EQ(bundle_at(both, {5, 1, 0})->piece, 0u);
  EXPECT_EQ(bundle_at(both, {9, 6, 1})->piece, 1u);
  EXPECT_EQ(bundle_at(both, {0.5, 0, 0})->bundle, 1u);
  EXPECT_EQ(bundle_at(both, {1.5, 0, 0})->bundle, 0u);
  EXPECT_FALSE(bundle_at(both, {5, 2.1, 0}));
  EXPECT_FALSE(bundle_at(both, {-3, 0, 0}));
}

TEST(FaceBundle, TheTopmostLayerStaysSkin) {
  FaceBundle b;
  b.path_mm = {{1, 1, -5}, {1, 1, kLayers + 5}}, b.radius_mm = 3;
  const Tissue t = bar(kLayers);
  InlineWorkers w;
  ElasticitySettings e;
  e.bundles = {b};
  const FaceElasticity::Body body{&t, 10};
  const FaceElasticity fe({&body, 1}, e, w);
  EXPECT_EQ(fe.bundled()[0].tetrahedra, (kLayers - 1) * 24);
  EXPECT_NEAR(fe.bundled()[0].volume_mm3, (kLayers - 1) * 4, 1e-9);
}

TEST(FaceBundle, WhatIsNoBundleIsRefused) {
  FaceBundle good;
  good.path_mm = {{0, 0, 0}, {0, 0, 1}};
  EXPECT_TRUE(bundle_law(good, 0, 0.45));
  std::vector<FaceBundle> bad(7, good);
  bad[0].path_mm.pop_back(), bad[1].path_mm[1].z() = 0, bad[2].radius_mm = 0, bad[3].young_kPa = -1;
  bad[4].k1_kPa = -1, bad[5].k1_kPa = 1, bad[5].k2 = 0, bad[6].young_kPa = NAN;
  for (const FaceBundle& b : bad) EXPECT_THROW(bundle_law(b, 0, 0.45), InputError) << &b - bad.data();
}

}  // namespace test_face_bundle
}  // namespace limberg::simplex
