// A sphere fitted to isosurfaces whose truth is known, and to a real head where one is at hand.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstdlib>

#include "sim/error.h"
#include "sim/imaging/fit.h"
#include "sim/simplex/dual.h"
#include "sim/simplex/generators.h"

namespace limberg {
namespace {

using namespace simplex;

template <class F>
Volume sampled(int n, double step, F&& f) {
  Volume v;
  v.size = {n, n, n};
  v.step_mm = step * Mat3::Identity();
  v.origin_mm = Vec3::Constant(-0.5 * step * (n - 1));
  for (int k = 0; k < n; ++k)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) v.value.push_back(float(f(v.place({double(i), double(j), double(k)}))));
  return v;
}

/// Distance to an ellipsoid, to first order.
double ellipsoid(const Vec3& x, const Vec3& half) {
  const double q = x.cwiseQuotient(half).norm(), g = x.cwiseQuotient(half.cwiseProduct(half)).norm() / q;
  return g > 0 ? (q - 1) / g : -half.minCoeff();
}

TEST(Fit, AnEllipsoidFromASphereThatIsTooSmall) {
  const Vec3 half(40, 25, 30);
  const Volume v = sampled(64, 1.6, [&](const Vec3& x) { return std::clamp(-ellipsoid(x, half), -4., 4.) * 250; });  // a blurred edge
  InlineWorkers w;
  Mesh m = make_sphere({3, 2, -1}, 15, 2);
  FitSettings s;
  s.edge_mm = 3;
  int stages = 0;
  s.progress = [&](int, int32_t, double) { ++stages; };
  const FitReport r = fit(m, v, s, w);
  EXPECT_EQ(find_fault(m).value_or(""), "");
  EXPECT_EQ(stages, s.stages);
  EXPECT_GT(r.found, 0.99);
  EXPECT_LT(r.rms_mm, 0.25 * 1.6);
  EXPECT_EQ(r.holes, 0);
  double sum = 0;
  for (const Vec3& x : m.x_mm) sum += std::pow(ellipsoid(x, half), 2);
  std::printf("%d vertices, rms %.3f mm by the volume, %.3f mm by the truth, voxel 1.6 mm\n", r.vertices, r.rms_mm, std::sqrt(sum / m.vertices()));
  EXPECT_LT(std::sqrt(sum / m.vertices()), 0.5 * 1.6);
  EXPECT_NEAR(extent(m).volume_mm3, 4. / 3 * 3.14159265 * half.prod(), 0.03 * 125664);
  EXPECT_EQ(census(m).genus, 0);
}

TEST(Fit, WhatReachesOutOfTheVolumeBecomesAnEndContour) {
  // A cylinder that runs through the lower face of the volume: there is no surface there.
  const Volume v = sampled(48, 2, [](const Vec3& x) {
    const double side = 20 - x.head<2>().norm(), top = 20 - x.z();
    return std::clamp(std::min(side, top), -4., 4.) * 250;
  });
  InlineWorkers w;
  Mesh m = make_sphere({0, 0, -10}, 15, 3);
  FitSettings s;
  s.edge_mm = 4;
  const FitReport r = fit(m, v, s, w);
  EXPECT_EQ(find_fault(m).value_or(""), "");
  EXPECT_GE(r.holes, 1);
  EXPECT_EQ(census(m).end_contours, r.holes);
  EXPECT_LT(r.rms_mm, 0.5 * 2);
}

TEST(Fit, NonsenseIsRefused) {
  const Volume v = sampled(8, 1, [](const Vec3& x) { return 2 - x.norm(); });
  InlineWorkers w;
  Mesh m = make_sphere({0, 0, 0}, 1, 1);
  FitSettings s;
  s.edge_mm = 0;
  EXPECT_THROW(fit(m, v, s, w), InputError);
  s = {}, s.iso = NAN;
  EXPECT_THROW(fit(m, v, s, w), InputError);
  s = {}, s.stages = 0;
  EXPECT_THROW(fit(m, v, s, w), InputError);
  EXPECT_THROW(fit(m, Volume{}, FitSettings{}, w), InputError);
}

TEST(Fit, ARealHead) {
  const char* path = std::getenv("LIMBERG_CT_HEAD");  // (see volume_test.cpp)
  if (!path) GTEST_SKIP() << "LIMBERG_CT_HEAD is not set";
  const Volume v = load_volume(path);
  InlineWorkers w;
  for (double iso : {724., 1274.}) {  // stored = HU + 1024: skin at -300, bone at 250
    Mesh m = make_sphere_of_faces({0, 0, 0}, 1, 1002);
    for (Vec3& x : m.x_mm) x = v.place({31.5, 31.5, 46}) + x.cwiseProduct(Vec3(85, 95, 75));
    m.before_mm = m.x_mm;
    FitSettings s;
    s.iso = iso, s.edge_mm = 4;
    const auto t0 = std::chrono::steady_clock::now();
    const FitReport r = fit(m, v, s, w);
    const double t = std::chrono::duration<double>(std::chrono::steady_clock::now() - t0).count();
    std::printf("iso %g: %d vertices, %d iterations, %.2f s, found %.3f, rms %.3f mm, 95 %% %.3f mm, %d holes\n", iso, r.vertices, r.iterations, t, r.found, r.rms_mm, r.p95_mm, r.holes);
    EXPECT_EQ(find_fault(m).value_or(""), "");
    EXPECT_LT(r.rms_mm, 0.5 * 3.2);
  }
}

}  // namespace
}  // namespace limberg
