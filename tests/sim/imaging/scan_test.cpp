// A plane, deformed to range scans: a face-like bump with a nose, turned this way and that, noisy; and a real face where one is at hand.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "sim/error.h"
#include "sim/imaging/fit.h"
#include "sim/imaging/surface_file.h"
#include "sim/simplex/dual.h"

namespace limberg {
namespace {

struct Lcg {
  uint64_t s;
  double operator()() {  // -1..1
    s = s * 6364136223846793005ull + 1442695040888963407ull;
    return double(int64_t(s) >> 11) / double(1ll << 52);
  }
};

/// Height of a face of 140 x 180 mm above its rim, 70 mm deep: half an ellipsoid with a nose of 25 mm and hollow orbits.
double face_height(double x, double y) {
  const double q = 1 - x * x / 4900 - y * y / 8100;
  const auto bump = [&](double cx, double cy, double sx, double sy) { return std::exp(-std::pow((x - cx) / sx, 2) - std::pow((y - cy) / sy, 2)); };
  return 70 * std::sqrt(std::max(q, 0.)) + 25 * bump(0, -5, 11, 22) - 8 * bump(-30, 25, 14, 9) - 8 * bump(30, 25, 14, 9);
}

std::vector<Vec3> face_scan(double spacing, double noise, uint64_t seed) {
  std::vector<Vec3> out;
  Lcg r{seed};
  for (double y = -88; y <= 88; y += spacing)
    for (double x = -68; x <= 68; x += spacing)
      if (x * x / 4900 + y * y / 8100 < 0.93) out.push_back(Vec3(x, y, face_height(x, y)) + noise * Vec3(r(), r(), r()));
  return out;
}

std::vector<Mat3> turns() {
  std::vector<Mat3> out{Mat3::Identity()};
  Lcg r{7};
  for (int i = 0; i < 2; ++i) {
    Eigen::Quaterniond q(r(), r(), r(), r());
    out.push_back(q.normalized().toRotationMatrix());
  }
  return out;
}

TEST(Scan, IsSeenFromItsFrontHoweverItIsTurned) {
  const std::vector<Vec3> scan = face_scan(4, 0.3, 1);
  for (const Mat3& R : turns()) {
    std::vector<Vec3> x;
    for (const Vec3& p : scan) x.push_back(R * p + Vec3(30, -400, 12));
    const ScanView v = view_of(x);
    EXPECT_GT(v.front.dot(R.col(2)), 0.99);  // within 8 degrees: the nose and the orbits are not alike above and below
    EXPECT_NEAR(v.across.cross(v.up).dot(v.front), 1, 1e-12);
    const simplex::Mesh m = start_plane(v);
    double nearest = -1e300;
    for (const Vec3& p : x) nearest = std::max(nearest, v.local(p).z());
    for (const Vec3& p : m.x_mm) EXPECT_GT(v.local(p).z(), nearest);
    EXPECT_GT(m.frame(m.slots() / 2).N.dot(v.front), 0.99);
  }
  // Triangles say which side it is seen from, also when it is a hollow.
  const std::vector<Vec3> hollow{{0, 0, 5}, {10, 0, 5}, {10, 10, 5}, {0, 10, 5}, {5, 5, 0}};
  EXPECT_LT(view_of(hollow).front.z(), -0.99);
  EXPECT_GT(view_of(hollow, {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}}).front.z(), 0.99);
}

TEST(Scan, APlaneReachesAFaceHoweverItIsTurned) {
  // The noise is a quarter of the spacing: as of a hand-held scanner, 0.5 mm at 2 mm.
  const std::vector<Vec3> scan = face_scan(2, 0.5, 2);
  InlineWorkers w;
  for (const Mat3& R : turns()) {
    std::vector<Vec3> x;
    for (const Vec3& p : scan) x.push_back(R * p);
    const ScanView view = view_of(x);
    simplex::Mesh m = start_plane(view);
    FitSettings s;
    s.edge_mm = 4, s.range_mm = 45;
    const FitReport r = fit(m, x, s, w, &view);
    EXPECT_EQ(find_fault(m).value_or(""), "");
    EXPECT_GT(r.found, 0.95);
    EXPECT_GT(r.reached, 0.95);
    EXPECT_LT(r.rms_mm, 0.5 * r.voxel_mm);
    std::printf("%d vertices, found %.3f, reached %.3f, rms %.3f mm, spacing %.2f mm, %zu openings\n", r.vertices, r.found, r.reached, r.rms_mm, r.voxel_mm, r.hole.size());
    double rms = 0;  // to the truth, not to its noisy points; away from the rim, beyond which there is none
    int n = 0;
    for (const Vec3& p : m.x_mm) {
      const Vec3 q = R.transpose() * p;
      if (q.x() * q.x() / 4900 + q.y() * q.y() / 8100 > 0.85) continue;
      ++n;
      const double h = 1e-3, gx = (face_height(q.x() + h, q.y()) - face_height(q.x() - h, q.y())) / (2 * h), gy = (face_height(q.x(), q.y() + h) - face_height(q.x(), q.y() - h)) / (2 * h);
      rms += std::pow((q.z() - face_height(q.x(), q.y())) / std::sqrt(1 + gx * gx + gy * gy), 2);
    }
    ASSERT_GT(n, 500);
    EXPECT_LT(std::sqrt(rms / n), 0.5 * r.voxel_mm);
    ASSERT_GE(r.hole.size(), 1u);
    EXPECT_NEAR(r.hole[0].around_mm, 488, 0.1 * 488);  // Ramanujan: an ellipse of 67.5 x 86.8 mm, smooth, not to and fro
    EXPECT_EQ(simplex::census(m).genus, 0);
  }
}

TEST(Scan, RimsStayAtItsEdge) {
  // A flat sheet: the rim of the mesh is that of the scan, within two spacings.
  std::vector<Vec3> x;
  for (int j = 0; j <= 40; ++j)
    for (int i = 0; i <= 60; ++i) x.push_back({2. * i, 2. * j, 0.02 * (i % 3)});
  const ScanView view = view_of(x);
  simplex::Mesh m = start_plane(view);
  InlineWorkers w;
  FitSettings s;
  s.edge_mm = 4, s.range_mm = 30;
  const FitReport r = fit(m, x, s, w, &view);
  EXPECT_GT(r.reached, 0.98);
  ASSERT_EQ(r.hole.size(), 1u);
  EXPECT_NEAR(r.hole[0].around_mm, 400, 0.1 * 400);
}

TEST(Scan, NonsenseIsRefused) {
  EXPECT_THROW(view_of({}), InputError);
  EXPECT_THROW(view_of({{0, 0, 0}, {1, 0, 0}}), InputError);
  EXPECT_THROW(view_of({{1, 1, 1}, {1, 1, 1}, {1, 1, 1}}), InputError);
  EXPECT_THROW(view_of({{1, 1, 1}, {1, NAN, 1}, {1, 2, 1}}), InputError);
  // A line has a view, if no good one.
  InlineWorkers w;
  std::vector<Vec3> line;
  for (int i = 0; i < 50; ++i) line.push_back({double(i), 0, 0});
  const ScanView view = view_of(line);
  simplex::Mesh m = start_plane(view);
  FitSettings s;
  s.stages = 3, s.iterations = 5;
  EXPECT_NO_THROW(fit(m, line, s, w, &view));
  EXPECT_EQ(find_fault(m).value_or(""), "");
}

TEST(Scan, WhatLiesBehindIsHidden) {
  // A face with a back: the same 12 mm (four spacings are 11.3) and more behind it, with triangles or without.
  const std::vector<Vec3> front = face_scan(2, 0, 3);
  std::vector<Vec3> both = front;
  for (const Vec3& p : front) both.push_back(p - Vec3(0, 0, 16));
  const ScanView view = view_of(both, {}, Vec3::UnitZ());
  EXPECT_GT(view.front.z(), 0.999);
  const auto share = [&](const std::vector<Vec3>& seen, bool back) {
    size_t n = 0;
    for (const Vec3& p : seen) n += (p.z() < face_height(p.x(), p.y()) - 8) == back;
    return double(n) / double(front.size());
  };
  const std::vector<Vec3> cloud = seen_from_front(both, {}, view);
  EXPECT_GT(share(cloud, false), 0.97);
  EXPECT_LT(share(cloud, true), 0.03);
  EXPECT_EQ(seen_from_front(front, {}, view).size(), front.size());
  // Every point of the front carries a small triangle, three spacings wide, so that they overlap.
  std::vector<Vec3> x = both;
  std::vector<Tri> tri;
  for (const Vec3& p : front) {
    const int32_t n = int32_t(x.size());
    for (const double a : {0., 2.1, 4.2}) x.push_back(p + 3 * Vec3(std::cos(a), std::sin(a), 0));
    tri.push_back({n, n + 1, n + 2});
  }
  const std::vector<Vec3> surface = seen_from_front(x, tri, view);
  size_t back = 0;
  for (const Vec3& p : surface) back += p.z() < face_height(p.x(), p.y()) - 14;
  EXPECT_LT(double(back), 0.03 * double(front.size()));
}

TEST(Scan, ADeepFaceIsSeenFromTheFront) {
  // Half a tube with a back, deeper than wide: along its least spread, from the side, half as much of it is seen as from the front.
  std::vector<Vec3> x;
  for (double y = -100; y <= 100; y += 4)
    for (double a = 0; a <= M_PI; a += 0.05)
      for (const double r : {1., 0.5}) x.push_back({r * 70 * std::cos(a), y, r * 110 * std::sin(a)});
  const ScanView v = view_of(x);
  EXPECT_GT(v.front.z(), 0.95);
}

TEST(Scan, ARealFace) {
  const char* data = std::getenv("LIMBERG_DATA");
  if (!data) GTEST_SKIP() << "LIMBERG_DATA does not name the folder of the test data";
  const std::string path = std::string(data) + "/face/wholeFace_NasalCartilage.obj";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not there";
  const Surface face = load_surface(path);  // skin and deep side, in cm
  InlineWorkers w;
  for (const Mat3& R : turns()) {
    std::vector<Vec3> x;
    for (const Vec3& p : face.x_mm) x.push_back(10 * R * p);
    const ScanView view = view_of(x, face.tri);
    EXPECT_GT(view.front.dot(R.col(2)), 0.9);
    const std::vector<Vec3> seen = seen_from_front(x, face.tri, view);
    simplex::Mesh m = start_plane(view);
    FitSettings s;
    s.edge_mm = 5, s.range_mm = 80;
    const FitReport r = fit(m, seen, s, w, &view);
    EXPECT_EQ(find_fault(m).value_or(""), "");
    std::printf("%zu of %zu points seen, %d vertices, found %.3f, reached %.3f, rms %.3f mm, spacing %.2f mm, %zu openings, the first %.0f mm around\n", seen.size(), x.size(), r.vertices, r.found, r.reached, r.rms_mm,
                r.voxel_mm, r.hole.size(), r.hole.empty() ? 0 : r.hole[0].around_mm);
    EXPECT_GT(r.found, 0.95);    // as app/commands/fit.cpp wants it
    EXPECT_GT(r.reached, 0.95);
    EXPECT_LT(r.rms_mm, 0.5 * r.voxel_mm);
    ASSERT_GE(r.hole.size(), 1u);
    EXPECT_LT(r.hole[0].around_mm, 1500);  // 25 x 32 cm and 10 cm deep: about 1.1 m around
  }
}

}  // namespace
}  // namespace limberg
