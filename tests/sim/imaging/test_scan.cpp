// A plane, deformed to range scans: a face-like bump with a nose, turned
// this way and that, noisy; and a real face where one is at hand.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "sim/base/error.h"
#include "sim/imaging/fit/fit.h"
#include "sim/imaging/fit/fit_parts.h"
#include "sim/imaging/io/surface_file.h"
#include "sim/skull/simplex/dual.h"

namespace limberg {
namespace test_scan {

struct Lcg {
  uint64_t s;
  double operator()() {  // -1..1
    s = s * 6364136223846793005ull + 1442695040888963407ull;
    return double(int64_t(s) >> 11) / double(1ll << 52);
  }
};

/// Height of a face of 140 x 180 mm above its rim, 70 mm deep:
/// half an ellipsoid with a nose of 25 mm and hollow orbits.
double face_height(double x, double y) {
  const double q = 1 - x * x / 4900 - y * y / 8100;
  const auto bump = [&](double cx, double cy, double sx, double sy) {
    return std::exp(-std::pow((x - cx) / sx, 2) - std::pow((y - cy) / sy, 2));
  };
  return 70 * std::sqrt(std::max(q, 0.)) + 25 * bump(0, -5, 11, 22) - 8 * bump(-30, 25, 14, 9) -
         8 * bump(30, 25, 14, 9);
}

std::vector<Vec3> face_scan(double spacing, double noise, uint64_t seed) {
  std::vector<Vec3> out;
  Lcg r{seed};
  for (double y = -88; y <= 88; y += spacing)
    for (double x = -68; x <= 68; x += spacing)
      if (x * x / 4900 + y * y / 8100 < 0.93)
        out.push_back(Vec3(x, y, face_height(x, y)) + noise * Vec3(r(), r(), r()));
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
    std::printf("%d vertices, found %.3f, reached %.3f, rms %.3f mm, spacing %.2f mm, %zu openings\n", r.vertices,
                r.found, r.reached, r.rms_mm, r.voxel_mm, r.hole.size());
    double rms = 0;  // to the truth, not to its noisy points; away from the rim, beyond which there is none
    int n = 0;
    for (const Vec3& p : m.x_mm) {
      const Vec3 q = R.transpose() * p;
      if (q.x() * q.x() / 4900 + q.y() * q.y() / 8100 > 0.85) continue;
      ++n;
      const double h = 1e-3, gx = (face_height(q.x() + h, q.y()) - face_height(q.x() - h, q.y())) / (2 * h),
                   gy = (face_height(q.x(), q.y() + h) - face_height(q.x(), q.y() - h)) / (2 * h);
      rms += std::pow((q.z() - face_height(q.x(), q.y())) / std::sqrt(1 + gx * gx + gy * gy), 2);
    }
    ASSERT_GT(n, 500);
    EXPECT_LT(std::sqrt(rms / n), 0.5 * r.voxel_mm);
    ASSERT_GE(r.hole.size(), 1u);
    EXPECT_NEAR(r.hole[0].around_mm, 488,
                0.1 * 488);  // Ramanujan: an ellipse of 67.5 x 86.8 mm, smooth, not to and fro
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

/// A ball of 60 mm, its points `above` mm apart over z = 0 and `below`
/// under it, without those within `bare_mm` of its lower pole.
std::vector<Vec3> ball_scan(double above, double below, double bare_mm = 0) {
  std::vector<Vec3> out;
  for (const double spacing : {above, below}) {
    const int n = int(4 * M_PI * 60 * 60 / (spacing * spacing));
    for (int i = 0; i < n; ++i) {  // Fibonacci's spiral: as dense everywhere
      const double z = 1 - (2 * i + 1.) / n, r = std::sqrt(1 - z * z), a = i * M_PI * (3 - std::sqrt(5.));
      const Vec3 x = 60 * Vec3(r * std::cos(a), r * std::sin(a), z);
      if ((above == below || (z > 0) == (spacing == above)) && (x + Vec3(0, 0, 60)).norm() > bare_mm) out.push_back(x);
    }
    if (above == below) break;
  }
  return out;
}

FitReport fit_ball(const std::vector<Vec3>& scan) {
  InlineWorkers w;
  FitSettings s;
  s.edge_mm = 4, s.range_mm = 30;
  simplex::Mesh m = start_mesh(Start::sphere, {-60, -60, -60}, {60, 60, 60});
  const FitReport r = fit(m, scan, s, w);
  EXPECT_EQ(find_fault(m).value_or(""), "");
  return r;
}

TEST(Scan, WhereItsPointsAreFourTimesSparserItIsReachedAsWell) {
  const std::vector<double> around = spacings_of(PointTree(ball_scan(3, 12)));
  EXPECT_NEAR(around.front(), 3, 0.5);
  EXPECT_NEAR(around.back(), 12, 2);
  std::vector<Vec3> stray = ball_scan(3, 12);
  stray.push_back({0, 0, 500});
  EXPECT_LT(spacings_of(PointTree(stray)).back(), 4);  // its nearest are dense
  const FitReport alike = fit_ball(ball_scan(3, 3)), mixed = fit_ball(ball_scan(3, 12));
  EXPECT_TRUE(alike.hole.empty());
  EXPECT_TRUE(mixed.hole.empty());  // with one spacing for all its lower half is taken for a hole
  EXPECT_NEAR(mixed.reached, alike.reached, 0.005);
  EXPECT_NEAR(mixed.found, alike.found, 0.01);
  EXPECT_LT(mixed.rms_mm, 0.5 * mixed.voxel_mm);
}

TEST(Scan, AHoleAmongSparsePointsIsStillOne) {
  const FitReport r = fit_ball(ball_scan(3, 12, 40));
  ASSERT_EQ(r.hole.size(), 1u);
  EXPECT_LT(r.hole[0].centre_mm.z(), -40);
  // 40 mm from the pole the ball is 37.7 mm wide: 237 mm around, and as much as a spacing within.
  EXPECT_LT(r.hole[0].around_mm, 1.1 * 237);
  EXPECT_GT(r.hole[0].around_mm, 237 - 2 * M_PI * 12);
}

/// A ball of 60 mm on a neck that widens from 45 to 75 mm at its end, 160 mm below, and is open there: a shell 4 mm
/// thick, as a scan of a head may be. The neck's rings are four times as far apart as the ball's.
Surface shell() {
  std::vector<Vec2> outline;  // radius and height, up along the outside
  for (int i = 0; i < 10; ++i) outline.push_back({75 - 3 * i, -160 + 12 * i});
  for (int i = 0; i <= 40; ++i) {
    const double a = -0.73 + i * (0.73 + M_PI / 2) / 40;  // the ball begins 40 mm below its middle
    outline.push_back({60 * std::cos(a), 60 * std::sin(a)});
  }
  Surface s;
  constexpr int n = 60;
  const int rows = int(outline.size());
  for (const double r : {1., 56. / 60})
    for (const Vec2& q : outline)
      for (int k = 0; k < n; ++k)
        s.x_mm.push_back({r * q.x() * std::cos(k * 2 * M_PI / n), r * q.x() * std::sin(k * 2 * M_PI / n),
                          q.y() > -40.1 ? r * q.y() : q.y()});
  const auto at = [&](int side, int row, int k) { return int32_t((side * rows + row) * n + k % n); };
  for (int k = 0; k < n; ++k) {
    for (int row = 0; row + 1 < rows; ++row) {
      s.tri.push_back({at(0, row, k), at(0, row, k + 1), at(0, row + 1, k)}),
          s.tri.push_back({at(0, row, k + 1), at(0, row + 1, k + 1), at(0, row + 1, k)});
      s.tri.push_back({at(1, row, k), at(1, row + 1, k), at(1, row, k + 1)}),
          s.tri.push_back({at(1, row, k + 1), at(1, row + 1, k), at(1, row + 1, k + 1)});
    }
    s.tri.push_back({at(0, 0, k), at(1, 0, k), at(0, 0, k + 1)}),
        s.tri.push_back({at(0, 0, k + 1), at(1, 0, k), at(1, 0, k + 1)});
  }
  return s;
}

bool on_outside(const Vec3& x) {
  return x.z() > -40.1 ? x.norm() > 58 : std::hypot(x.x(), x.y()) > 43 - 0.25 * (x.z() + 40);
}

TEST(Scan, TheDeepSideOfAShellIsHidden) {
  Surface s = shell();
  for (int turned = 0; turned < 2; ++turned) {  // triangles that all look inwards say as much
    const SeenScan seen = seen_from_around(s.x_mm, s.tri);
    ASSERT_EQ(seen.looks.size(), seen.x_mm.size());
    size_t outer = 0, deep = 0, outwards = 0;
    for (size_t i = 0; i < seen.x_mm.size(); ++i) {
      const Vec3& x = seen.x_mm[i];
      const bool out = on_outside(x);
      outer += out, deep += !out && x.z() > -40;
      outwards += out && seen.looks[i].dot(Vec3(x.x(), x.y(), std::max(x.z(), 0.))) > 0;
    }
    EXPECT_EQ(outer, s.x_mm.size() / 2);
    EXPECT_EQ(outwards, outer);
    EXPECT_EQ(deep, 0u);  // the inside of the neck is seen from below, through its wide end
    for (Tri& t : s.tri) std::swap(t[0], t[1]);
  }
  for (size_t i = 0; i < s.tri.size(); i += 10) std::swap(s.tri[i][0], s.tri[i][1]);  // they do not agree
  EXPECT_EQ(seen_from_around(s.x_mm, s.tri).x_mm.size(), s.x_mm.size());
  EXPECT_TRUE(seen_from_around(s.x_mm, s.tri).looks.empty());
}

TEST(Scan, OnlyPointsThatLookTheWayOfTheMeshDrawIt) {
  // Two sheets 4 mm apart that look away from each other; places between them, nearer to either.
  std::vector<Vec3> points, looks;
  for (const double z : {0., -4.})
    for (int i = -10; i <= 10; ++i)
      for (int j = -10; j <= 10; ++j) points.push_back({2. * i, 2. * j, z}), looks.push_back({0, 0, z + 2});
  for (Vec3& n : looks) n.normalize();
  const std::vector<Vec3> unknown;
  const imaging::PointSight knows(points, nullptr, looks), blind(points, nullptr, unknown);
  for (const double z : {-1., -3.})
    for (const double N : {1., -1.}) {
      bool seen = false;
      const Vec3 x(0.3, 0.2, z), to = N > 0 ? Vec3(0, 0, 0 - z) : Vec3(0, 0, -4 - z);
      EXPECT_LT((knows.pull(x, {0, 0, N}, 1, 30, seen) - to).norm(), 1e-9) << z << " " << N;
      EXPECT_TRUE(seen);
      // Where it is not known which way they look the nearest draws, whatever its side.
      EXPECT_LT((blind.pull(x, {0, 0, N}, 1, 30, seen) - Vec3(0, 0, z > -2 ? 0 - z : -4 - z)).norm(), 1e-9)
          << z << " " << N;
    }
}

TEST(Scan, ASphereGoesDownANeckToItsEnd) {
  const Surface s = shell();
  SeenScan seen = seen_from_around(s.x_mm, s.tri);
  for (const bool deep : {false, true}) {
    if (deep)  // points on both sides, which look away from each other
      for (const Vec3& x : s.x_mm)
        if (!on_outside(x) && x.z() > -90)
          seen.x_mm.push_back(x), seen.looks.push_back(-Vec3(x.x(), x.y(), std::max(x.z(), 0.)).normalized());
    InlineWorkers w;
    FitSettings f;
    f.edge_mm = 5, f.range_mm = 50;
    simplex::Mesh m = start_mesh(Start::sphere, {-75, -75, -160}, {75, 75, 60});
    const FitReport r = fit(m, seen.x_mm, f, w, nullptr, seen.looks);
    EXPECT_EQ(find_fault(m).value_or(""), "");
    double square = 0, lowest = 0;
    int above = 0;
    for (int32_t v = 0; v < m.slots(); ++v) {
      if (!m.alive(v)) continue;
      const Vec3& x = m.x_mm[size_t(v)];
      if (x.z() > 0) square += (x.norm() - 60) * (x.norm() - 60), ++above;
      lowest = std::min(lowest, x.z());
    }
    const double off = std::sqrt(square / above);  // of the upper half
    std::printf(
        "%d vertices, found %.3f, reached %.3f, rms %.3f mm, off %.3f mm, lowest %.0f mm, spacing %.2f mm, %zu "
        "openings\n",
        r.vertices, r.found, r.reached, r.rms_mm, off, lowest, r.voxel_mm, r.hole.size());
    EXPECT_LT(off, 1);  // the deep side is 4 mm away
    if (deep) continue;
    EXPECT_GT(r.found, 0.95);  // as app/commands/fit.cpp wants them
    EXPECT_GT(r.reached, 0.95);
    EXPECT_LT(r.rms_mm, 0.5 * r.voxel_mm);
    EXPECT_GE(r.hole.size(), 1u);
    EXPECT_LT(lowest, -160 + 12);
  }
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
  EXPECT_THROW(fit(m, line, s, w, nullptr, {Vec3::UnitZ()}), InputError);  // one direction for 50 points
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
  // Half a tube with a back, deeper than wide: along its least spread,
  // from the side, half as much of it is seen as from the front.
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
    std::printf(
        "%zu of %zu points seen, %d vertices, found %.3f, reached %.3f, rms %.3f mm, spacing %.2f mm, %zu openings, "
        "the first %.0f mm around\n",
        seen.size(), x.size(), r.vertices, r.found, r.reached, r.rms_mm, r.voxel_mm, r.hole.size(),
        r.hole.empty() ? 0 : r.hole[0].around_mm);
    EXPECT_GT(r.found, 0.95);  // as app/commands/fit.cpp wants it
    EXPECT_GT(r.reached, 0.95);
    EXPECT_LT(r.rms_mm, 0.5 * r.voxel_mm);
    ASSERT_GE(r.hole.size(), 1u);
    EXPECT_LT(r.hole[0].around_mm, 1500);  // 25 x 32 cm and 10 cm deep: about 1.1 m around
  }
}

}  // namespace test_scan
}  // namespace limberg
