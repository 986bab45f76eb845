// Stretch glyphs against homogeneous deformations.
#include <gtest/gtest.h>

#include <cmath>

#include "render/glyphs.h"
#include "tests/render/sample_snapshot.h"

namespace limberg {
namespace test_glyphs {

Snapshot deformed(const Mat3& F) {
  Snapshot s = testing::sample_snapshot({.wound = false, .wave_mm = 0, .sutures = 0, .hooks = 0});
  for (size_t v = 0; v < s.x_mm.size(); ++v) s.x_mm[v] = (F * s.topology->view.X_mm[v]).cast<float>();
  return s;
}

TEST(StretchGlyphs, AHomogeneousStretchIsTheSameEverywhere) {
  const double w = 0.4;
  Mat3 R = Eigen::AngleAxisd(w, Vec3::UnitZ()).toRotationMatrix();
  const Mat3 F = R * Vec3(1.2, 0.9, 1 / (1.2 * 0.9)).asDiagonal();
  const Snapshot s = deformed(F);
  const Material& skin = s.topology->body->layers[0].material;
  const std::vector<StretchGlyph> all = stretch_glyphs(s, 6);
  ASSERT_GT(all.size(), 50u);  // 60 mm of skin in squares of 6
  const Vec3f along = (R * Vec3::UnitX()).cast<float>();
  for (const StretchGlyph& g : all) {
    EXPECT_NEAR(g.largest, 1.2 * skin.prestretch_along, 1e-4);
    EXPECT_NEAR(g.least, 0.9 * skin.prestretch_across, 1e-4);
    EXPECT_NEAR(std::abs(g.first.dot(along)), 1, 1e-4);
    EXPECT_NEAR(g.first.dot(g.second), 0, 1e-5);
  }
}

TEST(StretchGlyphs, ShearTurnsThem) {
  Mat3 F = Mat3::Identity();
  F(0, 1) = 0.2;  // simple shear: stretches (sqrt(4 + k^2) +- k) / 2, the larger at atan(2 / k) / 2 at rest
  Snapshot s = deformed(F);
  auto body = std::make_shared<Body>(*s.topology->body);
  body->layers[0].material.prestretch_along = body->layers[0].material.prestretch_across = 1;
  auto topology = std::make_shared<SurfaceTopology>(*s.topology);
  topology->body = body, s.topology = topology;
  const double k = 0.2, largest = (std::sqrt(4 + k * k) + k) / 2;
  const Vec3f want =
      (F * Vec3(std::cos(0.5 * std::atan2(2, k)), std::sin(0.5 * std::atan2(2, k)), 0)).cast<float>().normalized();
  for (const StretchGlyph& g : stretch_glyphs(s, 6)) {
    EXPECT_NEAR(g.largest, largest, 1e-4);
    EXPECT_NEAR(g.least, 1 / largest, 1e-4);
    // At rest the principal direction has angle (pi/2 + atan(k/2)) / 2 to the shear; its image is what is drawn.
    EXPECT_GT(std::abs(g.first.dot(want)), 0.99);
  }
}

TEST(StretchGlyphs, ArmsAreAsLongAsTheStretch) {
  const Snapshot s = deformed(Vec3(1.1, 1, 1).asDiagonal());
  std::vector<StretchGlyph> one{stretch_glyphs(s, 6).front()};
  one[0].largest = 1 + kFullStretch, one[0].least = 1;
  PropMesh mesh;
  add_glyphs(mesh, one, 6);
  ASSERT_FALSE(mesh.vertex.empty());
  float far = 0;
  for (const PropVertex& v : mesh.vertex) far = std::max(far, std::abs((v.x_mm - one[0].at_mm).dot(one[0].first)));
  EXPECT_NEAR(far, 3, 0.3);  // half the spacing, and the round end
  one[0].largest = 1;
  mesh.clear();
  add_glyphs(mesh, one, 6);
  EXPECT_TRUE(mesh.vertex.empty());  // nothing where nothing is stretched
}

TEST(StretchGlyphs, NoPatientNoGlyphs) { EXPECT_TRUE(stretch_glyphs(Snapshot{}).empty()); }

}  // namespace test_glyphs
}  // namespace limberg
