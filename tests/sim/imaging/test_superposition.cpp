// Known motions are found again: landmarks, ICP on partial and noisy surfaces, mirror plane, volumes of other contrast.
#include <gtest/gtest.h>

#include <cmath>

#include "sim/base/error.h"
#include "sim/imaging/fit/fit.h"
#include "sim/imaging/fit/prepare.h"
#include "sim/imaging/register/registration.h"
#include "sim/imaging/register/superposition.h"
#include "sim/skull/simplex/dual.h"
#include "sim/skull/simplex/generators.h"

namespace limberg {
namespace test_superposition {

constexpr double kDegree = 3.14159265358979 / 180;

/// Uneven in every direction, like a head: bumps on an ellipsoid.
Vec3 place(const Vec3& u) {
  double r = 1 + 0.12 * std::exp(-8 * (u - Vec3(0, -1, -0.2).normalized()).squaredNorm()) +
             0.1 * std::exp(-10 * (u - Vec3(0.8, 0.3, 0.5).normalized()).squaredNorm()) -
             0.08 * std::exp(-12 * (u - Vec3(-0.4, -0.8, 0.4).normalized()).squaredNorm());
  return (r * u).cwiseProduct(Vec3(70, 95, 80));
}
/// The same with the bumps on either side of x = 0.
Vec3 symmetric(const Vec3& u) {
  const Vec3 a(std::abs(u.x()), u.y(), u.z());
  const double r = 1 + 0.12 * std::exp(-8 * (a - Vec3(0, -1, -0.2)).squaredNorm()) +
                   0.1 * std::exp(-10 * (a - Vec3(0.8, 0.3, 0.5)).squaredNorm()) -
                   0.08 * std::exp(-12 * (a - Vec3(0.4, -0.8, 0.4)).squaredNorm());
  return (r * u).cwiseProduct(Vec3(70, 95, 80));
}

Surface head(Vec3 (*f)(const Vec3&), int levels) {
  const simplex::DualTriangles d = simplex::dual_triangles(simplex::make_sphere({0, 0, 0}, 1, levels));
  Surface s{d.X_mm, d.tri};
  for (Vec3& x : s.x_mm) x = f(x.normalized());
  return s;
}

Similarity known(double scale = 1) {
  Similarity s;
  s.R = Eigen::AngleAxisd(7 * kDegree, Vec3(1, 2, -1).normalized()).toRotationMatrix();
  s.t_mm = {6, -4, 5}, s.scale = scale;
  return s;
}

double noise(uint64_t& seed) {  // about normal: the sum of four even ones
  double sum = 0;
  for (int i = 0; i < 4; ++i) {
    seed = seed * 6364136223846793005ull + 1442695040888963407ull;
    sum += double(seed >> 11) * 0x1p-53 - 0.5;
  }
  return sum * std::sqrt(3.);
}

double worst(const Similarity& a, const Similarity& b, const std::vector<Vec3>& x) {
  double w = 0;
  for (const Vec3& p : x) w = std::max(w, (a(p) - b(p)).norm());
  return w;
}

TEST(Landmarks, AnExactMotionComesBack) {
  const std::vector<Vec3> from{{0, 0, 0}, {50, 3, 1}, {2, 60, 5}, {-20, 10, 40}, {30, 30, -30}};
  for (const double scale : {1., 1.13}) {
    std::vector<Vec3> to;
    for (const Vec3& x : from) to.push_back(known(scale)(x));
    const LandmarkFit f = fit_landmarks(from, to, scale != 1);
    ASSERT_TRUE(f) << f.reason;
    EXPECT_LT(worst(f.map, known(scale), from), 1e-9);
    EXPECT_NEAR(f.map.R.determinant(), 1, 1e-12);
    EXPECT_LT(worst(f.map * f.map.inverse(), {}, to), 1e-9);
  }
  // A reflected set is turned, never reflected.
  std::vector<Vec3> mirrored = from;
  for (Vec3& x : mirrored) x.x() = -x.x();
  EXPECT_NEAR(fit_landmarks(from, mirrored, false).map.R.determinant(), 1, 1e-12);
}

TEST(Landmarks, TooFewOrOnALineAreRefused) {
  const std::vector<Vec3> two{{0, 0, 0}, {1, 0, 0}}, line{{0, 0, 0}, {10, 0, 0}, {20, 0.05, 0}, {35, 0, 0.05}},
      same(4, Vec3(1, 2, 3)), good{{0, 0, 0}, {10, 0, 0}, {0, 10, 0}};
  EXPECT_NE(fit_landmarks(two, two, false).reason.find("at least 3"), std::string::npos);
  EXPECT_NE(fit_landmarks(line, line, false).reason.find("on a line"), std::string::npos);
  EXPECT_NE(fit_landmarks(same, same, false).reason.find("one place"), std::string::npos);
  EXPECT_NE(fit_landmarks(good, two, false).reason.find("pairs"), std::string::npos);
  EXPECT_NE(fit_landmarks({{NAN, 0, 0}, {1, 0, 0}, {0, 1, 0}}, good, false).reason.find("finite"), std::string::npos);
  EXPECT_TRUE(fit_landmarks(good, good, false));
}

TEST(Icp, AKnownMotionOnAPartialAndNoisySurface) {
  InlineWorkers w;
  const Surface whole = head(place, 5);
  const SurfaceTarget target(whole);
  // Half of it (the front), moved, with noise of 0.3 mm, and a part of it 6 mm out of its place (operated).
  const Similarity back = known().inverse();
  Surface part;
  uint64_t seed = 5;
  for (const Vec3& x : head(place, 5).x_mm)
    if (x.y() < 10) {
      Vec3 y = x + 0.3 * Vec3(noise(seed), noise(seed), noise(seed));
      if (x.z() > 45) y += 6 * x.normalized();  // outwards: what slides within the surface nothing can tell
      part.x_mm.push_back(back(y));
    }
  IcpSettings s;
  const IcpResult r = icp(part, target, {}, s, w);
  ASSERT_TRUE(r) << r.reason;
  EXPECT_TRUE(r.still);
  const double error = worst(r.map, known(), part.x_mm);
  std::printf("%zu points, %d iterations, rms %.3f mm, worst place %.3f mm off\n", part.x_mm.size(), r.iterations,
              r.rms_mm, error);
  EXPECT_LT(error, 0.1);
  // The same without the trimming is dragged away by the part that was moved: the trimming is what does it.
  s.keep = 1;
  EXPECT_GT(worst(icp(part, target, {}, s, w).map, known(), part.x_mm), 0.3);
  // From far away, by middles and axes (the whole surface).
  Similarity far;
  far.R = Eigen::AngleAxisd(150 * kDegree, Vec3(0.2, 1, 0.4).normalized()).toRotationMatrix(),
  far.t_mm = {300, -100, 50};
  Surface moved = head(place, 4);
  const std::vector<Vec3> at = moved.x_mm;
  for (Vec3& x : moved.x_mm) x = far(x);
  const IcpResult q = icp_from_anywhere(moved, target, whole, {}, w);
  ASSERT_TRUE(q) << q.reason;
  EXPECT_LT(worst(q.map * far, {}, at), 0.1);
}

TEST(Icp, WhatSlipsIsRefused) {
  InlineWorkers w;
  const simplex::FanTriangles f = simplex::fan_triangles(simplex::make_plane(60, 60, 4));
  const Surface plane{f.X_mm, f.tri};
  EXPECT_NE(icp(plane, SurfaceTarget(plane), {}, {}, w).reason.find("slip"), std::string::npos);
  EXPECT_NE(icp({{{0, 0, 0}}, {}}, SurfaceTarget(plane), {}, {}, w).reason.find("at least 10"), std::string::npos);
  EXPECT_THROW(SurfaceTarget(Surface{}), InputError);
}

TEST(Surfaces, WhatHasNoShapeSaysWhatItLacks) {
  const simplex::FanTriangles f = simplex::fan_triangles(simplex::make_sphere({1, 2, 3}, 60, 1));
  Surface s{f.X_mm, f.tri};
  EXPECT_EQ(lacks_shape(s), "");
  EXPECT_EQ(lacks_shape({s.x_mm, {}}), "");  // a cloud
  const Surface nine{{s.x_mm.begin(), s.x_mm.begin() + 9}, {}}, ten{{s.x_mm.begin(), s.x_mm.begin() + 10}, {}};
  EXPECT_EQ(lacks_shape(nine), "has 9 points; at least 10 were expected");
  EXPECT_EQ(lacks_shape(ten), "");
  // A plate has a shape (though it slips), a rod 2 % as wide as long has none; whatever their size.
  for (const double size : {1e-2, 1., 1e4}) {
    Surface plate = s, rod = s, place = s;
    for (Vec3& x : plate.x_mm) x = size * Vec3(x.x(), x.y(), 7);
    for (Vec3& x : rod.x_mm) x = size * Vec3(x.x(), 0.019 * (x.y() - 2), 0.001 * (x.z() - 3));
    for (Vec3& x : place.x_mm) x = size * Vec3(1, 2, 3);
    EXPECT_EQ(lacks_shape(plate), "");
    EXPECT_NE(lacks_shape(rod).find("on a line"), std::string::npos);
    EXPECT_NE(lacks_shape(place).find("at one place"), std::string::npos) << size << lacks_shape(place);
    // One triangle with an area is enough, none is not.
    Surface thin = plate;
    for (Tri& t : thin.tri) t = {t[0], t[1], t[0]};
    EXPECT_NE(lacks_shape(thin).find("no triangle with an area"), std::string::npos);
    thin.tri[5] = plate.tri[5];
    EXPECT_EQ(lacks_shape(thin), "");
  }
}

TEST(Mirror, ThePlaneOfASymmetricHeadAndItsAsymmetry) {
  InlineWorkers w;
  Surface s = head(symmetric, 4);
  for (size_t i = 0; i < s.x_mm.size(); ++i)
    if (const Vec3 x = s.x_mm[i]; x.x() > 40 && x.z() > 20) s.x_mm[i] += Vec3(4, 0, 0);  // one side grown
  const Similarity m = known();
  for (Vec3& x : s.x_mm) x = m(x);
  const MirrorPlane p = mirror_plane(s, Vec3::UnitX(), {}, w);
  ASSERT_TRUE(p) << p.reason;
  const Vec3 truth = m.R * Vec3::UnitX();
  EXPECT_LT(std::acos(std::min(1., std::abs(p.normal.dot(truth)))) / kDegree, 0.1);
  EXPECT_NEAR(truth.dot(p.point_mm - m.t_mm), 0, 0.1);
  EXPECT_LT((p.reflect(p.reflect({1, 2, 3})) - Vec3(1, 2, 3)).norm(), 1e-12);
}

TEST(DistanceMap, AGrownSphereIsFartherByWhatItGrew) {
  InlineWorkers w;
  const simplex::DualTriangles d = simplex::dual_triangles(simplex::make_sphere({0, 0, 0}, 50, 4));
  const Surface inner{d.X_mm, d.tri};
  const SurfaceTarget target(inner);
  for (const double grow : {2., -2.}) {
    Surface outer = inner;
    for (Vec3& x : outer.x_mm) x *= (50 + grow) / 50;
    const DistanceMap m = distance_map(outer, {}, target, w);
    EXPECT_NEAR(m.mean_mm, grow, 0.02);
    EXPECT_NEAR(m.rms_mm, 2, 0.02);
    EXPECT_NEAR(m.p95_mm, 2, 0.05);
    for (const double x : m.signed_mm) EXPECT_EQ(x > 0, grow > 0);
  }
  // A cloud has no sides.
  EXPECT_NEAR(distance_map(inner, {}, SurfaceTarget(Surface{inner.x_mm, {}}), w).max_mm, 0, 1e-12);
}

TEST(Scan, APointCloudIsFittedWhereItHasPoints) {
  InlineWorkers w;
  std::vector<Vec3> scan;
  for (const Vec3& x : head(place, 5).x_mm)
    if (x.y() < 30) scan.push_back(x);  // open behind
  Vec3 low = scan[0], high = low;
  for (const Vec3& x : scan) low = low.cwiseMin(x), high = high.cwiseMax(x);
  simplex::Mesh m = start_mesh(Start::sphere, low, high);
  FitSettings s;
  s.edge_mm = 5;
  const FitReport r = fit(m, scan, s, w);
  EXPECT_EQ(simplex::find_fault(m).value_or(""), "");
  std::printf("%d vertices, found %.3f, rms %.3f mm, reached %.3f, %zu openings, spacing %.2f mm\n", r.vertices,
              r.found, r.rms_mm, r.reached, r.hole.size(), r.voxel_mm);
  EXPECT_GT(r.found, 0.95);
  EXPECT_LT(r.rms_mm, 0.5 * r.voxel_mm);
  EXPECT_GT(r.reached, 0.95);
  EXPECT_GE(r.hole.size(), 1u);
}

TEST(Registration, AKnownMotionUnderAnotherContrast) {
  // Nested ellipsoids and blobs as tissues with numbers; the second image has other numbers, some the other way round.
  const auto tissue = [](const Vec3& x) {
    const auto in = [&](const Vec3& c, const Vec3& h) { return (x - c).cwiseQuotient(h).norm() < 1; };
    if (in({12, -30, 8}, {8, 7, 7}) || in({-12, -30, 8}, {8, 7, 7})) return 3;
    if (in({0, -42, -8}, {5, 9, 8})) return 4;
    if (in({0, 5, 6}, {30, 36, 28})) return in({6, 2, 10}, {8, 14, 7}) ? 4 : 3;
    if (in({0, 3, 4}, {34, 41, 32})) return 2;
    return in({0, 0, 0}, {40, 48, 40}) ? 1 : 0;
  };
  const auto sampled = [&](int n, double step, const Similarity& map, const double* number) {
    Volume v;
    v.size = {n, n, n}, v.step_mm = step * Mat3::Identity(), v.origin_mm = Vec3::Constant(-0.5 * step * (n - 1));
    const Similarity back = map.inverse();
    for (int k = 0; k < n; ++k)
      for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) v.value.push_back(float(number[tissue(back(v.place(Vec3(i, j, k))))]));
    return v;
  };
  const double ct[] = {-1000, 40, 1100, 35, -90}, mr[] = {0, 500, 60, 800, 950};
  Similarity truth;
  truth.R = Eigen::AngleAxisd(6 * kDegree, Vec3(1, -1, 2).normalized()).toRotationMatrix(), truth.t_mm = {4, -5, 3};
  InlineWorkers w;
  const Volume fixed = smoothed(sampled(40, 3, {}, ct), 0.5, w),
               moved = smoothed(sampled(36, 3.3, truth.inverse(), mr), 0.5, w);
  const RegistrationResult r = register_volumes(fixed, moved, {}, w);
  ASSERT_TRUE(r) << r.reason;
  std::vector<Vec3> skin;
  // Places on the skin, all round.
  for (int c = 0; c < 8; ++c)
    skin.push_back(Vec3(c & 1 ? 40 : -40, c & 2 ? 48 : -48, c & 4 ? 40 : -40) / std::sqrt(3.));
  for (const Vec3& p : {Vec3(40, 0, 0), Vec3(0, 48, 0), Vec3(0, 0, 40)}) skin.push_back(p), skin.push_back(-p);
  const double error = worst(r.map, truth, skin);
  std::printf("information %.4f from %.4f, %d evaluations, worst place of the skin %.2f mm off (voxel 3 mm)\n",
              r.information, r.at_start, r.evaluations, error);
  EXPECT_LT(error, 3);
  EXPECT_GT(r.information, r.at_start);
  const RegistrationResult again = register_volumes(fixed, moved, {}, w);
  EXPECT_EQ(again.map.R, r.map.R);
  EXPECT_EQ(again.map.t_mm, r.map.t_mm);
  Volume flat = fixed;
  for (float& x : flat.value) x = 7;
  EXPECT_NE(register_volumes(fixed, flat, {}, w).reason.find("contrast"), std::string::npos);
  EXPECT_THROW(register_volumes(fixed, Volume{}, {}, w), InputError);
}

}  // namespace test_superposition
}  // namespace limberg
