// Skin that slides on bone: how hard a layer of loose tissue resists, and how far a pull reaches over it.
#include <gtest/gtest.h>

#include <cmath>

#include "sim/base/error.h"
#include "sim/skull/face/face_elasticity.h"
#include "tests/sim/skull/face/layers_of_boxes.h"

namespace limberg::simplex {
namespace test_face_slide {

/// Boxes of `edge_mm` by 2 mm, about x = y = 0.
Tissue slab(int nx, int ny, double edge_mm, int layers = 2) {
  return test::layers_of_boxes(nx, ny, layers, edge_mm, 2, -0.5 * edge_mm * Vec2(nx, ny));
}

struct Made {
  Tissue tissue;
  InlineWorkers workers;
  ElasticitySettings settings;
  std::unique_ptr<FaceElasticity> fe;
  std::vector<Vec3> u;
  Made(Tissue t, double fat_kPa, const ElasticitySettings& s) : tissue(std::move(t)), settings(s) {
    const FaceElasticity::Body body{&tissue, fat_kPa};
    fe = std::make_unique<FaceElasticity>(std::span(&body, 1), settings, workers);
    u.assign(fe->nodes(), Vec3::Zero());
  }
  void rest() {
    for (int i = 0; i < 200; ++i)
      if (fe->step(u, 20, 1e-5).converged) return;
    ADD_FAILURE() << "no rest";
  }
};

FaceSlide everywhere(double kPa_per_mm) { return {"scalp", {0, 0, 0}, 1000, kPa_per_mm}; }

// Skin drawn along over bone: fat and loose tissue are two springs in a row, mu / t and kPa_per_mm. Thickness counts in
// steps of a twentieth: k is off by half of one at most.
TEST(FaceSlide, ResistsSlidingAsSpringsSpreadOverTheBone) {
  for (const double k : {0.05, 0.5}) {
    ElasticitySettings e;
    e.skin_kPa = 0, e.slides = {everywhere(k)};
    Made m(slab(30, 30, 2), 15, e);
    std::vector<uint8_t> held(m.u.size(), 0);
    for (size_t i = 0; i < m.tissue.node_mm.size(); ++i) {
      const double z = m.tissue.node_mm[i].z();
      const size_t n = size_t(m.fe->node(0, i));
      held[n] = z != 2;
      if (z == 4) m.u[n] = Vec3(0.1, 0, 0);
    }
    m.fe->hold(held);
    m.rest();
    const double fat = 15 / (2 * 1.45) / 2;  // kPa a mm
    const double middle_mm = [&] {
      for (size_t i = 0; i < m.tissue.node_mm.size(); ++i)
        if (m.tissue.node_mm[i] == Vec3(0, 0, 2)) return m.u[size_t(m.fe->node(0, i))].x();
      return -1.0;
    }();
    EXPECT_NEAR(middle_mm, 0.1 * fat / (fat + k), 0.025 * 0.1 * fat * k / std::pow(fat + k, 2) + 1e-5) << k;
  }
}

/// Bone to the right goes d along x, bone to the left stays. The sheet's displacement at x.
std::vector<double> drawn(const std::vector<FaceSlide>& slides, const std::vector<double>& at, double d) {
  ElasticitySettings e;
  e.skin_mm = 2, e.skin_kPa = 60, e.slides = slides;
  Made m(slab(80, 2, 4), 1, e);
  for (size_t i = 0; i < m.tissue.node_mm.size(); ++i)
    if (const Vec3& X = m.tissue.node_mm[i]; X.z() == 0 && X.x() >= 0) m.u[size_t(m.fe->node(0, i))].x() = d;
  m.rest();
  std::vector<double> out;
  for (const double x : at) {
    double sum = 0;
    int n = 0;
    for (size_t i = 0; i < m.tissue.node_mm.size(); ++i)
      if (const Vec3& X = m.tissue.node_mm[i]; X.z() > 0 && X.x() == x) sum += m.u[size_t(m.fe->node(0, i))].x(), ++n;
    out.push_back(sum / n);
  }
  return out;
}

// Volkersen's shear lag. With l^2 = E h / k, a sheet on bone that parts by d at x = 0 and free ends at -L and L:
// u = d - d/2 cosh((L - x) / l) / cosh(L / l) to the right, and what is missing from d to the left. Fat of 1 kPa beside
// skin of 60, so that what its volume adds (lambda t / (E h), 5 % at most) stays small.
TEST(FaceSlide, APullReachesAsFarAsTheShearLagOfASheetSays) {
  const double d = 0.2, h = 2, L = 160;
  const std::vector<double> at{-80, -40, -20, 20, 40, 80};
  for (const double k : {0.05, 0.15}) {
    const double l = std::sqrt(60 * h / k);
    const std::vector<double> u = drawn({everywhere(k)}, at, d);
    for (size_t i = 0; i < at.size(); ++i) {
      const double missing = d / 2 * std::cosh((L - std::abs(at[i])) / l) / std::cosh(L / l);
      EXPECT_NEAR(u[i], at[i] > 0 ? d - missing : missing, 0.05 * d / 2) << "k " << k << " at " << at[i];
    }
  }
  const std::vector<double> held = drawn({}, at, d);  // fat of 1 kPa alone: .17 kPa a mm, and as far
  EXPECT_LT(std::abs(held[2] - drawn({everywhere(1e4)}, at, d)[2]), 1e-4) << "loose tissue is never stiffer than fat";
}

TEST(FaceSlide, LiesOnBoneOnlyAndMusclesStay) {
  ElasticitySettings e;
  e.slides = {{"near", {-6, 0, 1}, 6, 0.05}, {"far", {500, 0, 0}, 6, 0.05}};
  FaceBundle b;
  b.name = "m", b.path_mm = {{-6, -9, 1}, {-6, 9, 1}}, b.radius_mm = 1.5;
  Made plain(slab(12, 4, 2), 15, e);
  EXPECT_GT(plain.fe->sliding()[0].tetrahedra, 60);
  EXPECT_EQ(plain.fe->sliding()[1].tetrahedra, 0);
  EXPECT_LT(plain.fe->sliding()[0].volume_mm3, 12 * 8 * 2) << "of the lower layer";
  e.bundles = {b};
  Made with(slab(12, 4, 2), 15, e);
  EXPECT_EQ(with.fe->sliding()[0].tetrahedra + with.fe->bundled()[0].tetrahedra, plain.fe->sliding()[0].tetrahedra);
  Made one(slab(12, 4, 2, 1), 15, e);
  EXPECT_EQ(one.fe->sliding()[0].tetrahedra, 0) << "one layer is skin";
  for (FaceSlide bad : {FaceSlide{"a", {0, 0, 0}, 0, 1}, {"b", {0, 0, 0}, 5, -1}, {"c", {0, 0, 0}, 5, NAN}})
    EXPECT_THROW(slide_law(bad, 1, 15, 0.45), InputError) << bad.name;
  EXPECT_THROW(slide_law(everywhere(1), 0, 15, 0.45), InputError);
}

}  // namespace test_face_slide
}  // namespace limberg::simplex
