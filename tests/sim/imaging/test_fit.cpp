// A sphere fitted to isosurfaces whose truth is known, and to a real head where one is at hand.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "sim/base/error.h"
#include "sim/imaging/fit/fit.h"
#include "sim/skull/simplex/dual.h"
#include "sim/skull/simplex/generators.h"

namespace limberg {
namespace test_fit {

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
  const Volume v = sampled(
      64, 1.6, [&](const Vec3& x) { return std::clamp(-ellipsoid(x, half), -4., 4.) * 250; });  // a blurred edge
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
  std::printf("%d vertices, rms %.3f mm by the volume, %.3f mm by the truth, voxel 1.6 mm\n", r.vertices, r.rms_mm,
              std::sqrt(sum / m.vertices()));
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

TEST(Fit, FromAroundFromAPlaneAndFromACylinder) {
  // A round bar through the lower and the upper border of the
  // volume, with a dent in its side that the sphere must go round.
  const Volume v = sampled(40, 2, [](const Vec3& x) {
    const double side = 20 - x.head<2>().norm(), dent = (x - Vec3(20, 0, 5)).norm() - 9;
    return std::clamp(std::min(side, dent), -4., 4.) * 250;
  });
  InlineWorkers w;
  PrepareSettings q;
  q.seal_mm = 4, q.sigma_voxels = 0.5;
  const Prepared p = prepare(v, q, w);
  for (const Start kind : {Start::sphere, Start::cylinder, Start::plane}) {
    Mesh m = start_mesh(kind, p.low_mm, p.high_mm);
    EXPECT_EQ(find_fault(m).value_or(""), "");
    FitSettings s;
    s.edge_mm = 4;
    const FitReport r = fit(m, p, s, w);
    EXPECT_EQ(find_fault(m).value_or(""), "");
    EXPECT_GT(r.found, 0.95) << int(kind);
    EXPECT_LT(r.rms_mm, 0.5 * 2) << int(kind);
    EXPECT_EQ(census(m).genus, 0);
    std::printf("start %d: %d vertices, found %.3f, rms %.3f mm, reached %.3f, %zu openings\n", int(kind), r.vertices,
                r.found, r.rms_mm, r.reached, r.hole.size());
    for (const FitHole& h : r.hole) std::printf("  %s, %.0f mm\n", h.place.c_str(), h.around_mm);
    if (kind == Start::plane) {
      EXPECT_GT(r.reached, 0.25);  // the side that it comes from
      continue;
    }
    EXPECT_GT(r.reached, 0.97) << int(kind);
    ASSERT_EQ(r.hole.size(), 2u) << int(kind);
    std::vector<std::string> places{r.hole[0].place, r.hole[1].place};
    std::sort(places.begin(), places.end());
    EXPECT_EQ(places[0], "volume border, inferior");
    EXPECT_EQ(places[1], "volume border, superior");
    for (const FitHole& h : r.hole) EXPECT_NEAR(std::abs(h.centre_mm.z()), 39, 2.);
  }
}

TEST(Fit, TheGenusOfATorusComesFromASphere) {
  const Volume v = sampled(
      56, 2, [](const Vec3& x) { return std::clamp(12 - Vec2(x.head<2>().norm() - 34, x.z()).norm(), -4., 4.) * 250; });
  InlineWorkers w;
  PrepareSettings q;
  q.seal_mm = 4;
  const Prepared p = prepare(v, q, w);
  Mesh m = start_mesh(Start::sphere, p.low_mm, p.high_mm);
  const FitReport r = fit(m, p, {}, w);
  EXPECT_EQ(find_fault(m).value_or(""), "");
  EXPECT_EQ(r.joined, 1);
  EXPECT_EQ(census(m).genus, 1);
  EXPECT_EQ(r.hole.size(), 0u);
  EXPECT_GT(r.found, 0.99);
  EXPECT_GT(r.reached, 0.99);
  EXPECT_LT(r.rms_mm, 0.5);
}

TEST(Fit, WhatIsTwoBodiesBecomesTwoParts) {
  const Volume v = sampled(48, 2, [](const Vec3& x) {
    return std::clamp(std::max(18 - (x - Vec3(24, 0, 0)).norm(), 16 - (x + Vec3(24, 0, 0)).norm()), -4., 4.) * 250;
  });
  InlineWorkers w;
  PrepareSettings q;
  q.seal_mm = 3, q.sigma_voxels = 0;
  const Prepared one = prepare(v, q, w);
  EXPECT_EQ(one.parts, 2);
  EXPECT_EQ(one.kept_parts, 1);
  EXPECT_NEAR(one.low_mm.x(), 6, 3);  // the larger
  q.least_part = 0.5;
  const Prepared both = prepare(v, q, w);
  EXPECT_EQ(both.kept_parts, 2);
  Mesh m = start_mesh(Start::sphere, both.low_mm, both.high_mm);
  const FitReport r = fit(m, both, {}, w);
  EXPECT_EQ(find_fault(m).value_or(""), "");
  std::printf("%d vertices, found %.3f, rms %.3f mm, reached %.3f, %d cut, %zu openings, %zu notes\n", r.vertices,
              r.found, r.rms_mm, r.reached, r.cut, r.hole.size(), r.notes.size());
  std::vector<int32_t> of;
  const int32_t parts = components(m, of);
  for (int32_t c = 0; c < parts; ++c) {
    Vec3 lo = Vec3::Constant(1e9), hi = -lo;
    for (size_t u = 0; u < of.size(); ++u)
      if (of[u] == c) lo = lo.cwiseMin(m.x_mm[u]), hi = hi.cwiseMax(m.x_mm[u]);
    std::printf("  part %d: %d vertices, x %.0f to %.0f, y %.0f to %.0f, z %.0f to %.0f mm\n", c,
                int(std::count(of.begin(), of.end(), c)), lo.x(), hi.x(), lo.y(), hi.y(), lo.z(), hi.z());
  }
  for (const FitHole& h : r.hole)
    std::printf("  %s, (%.0f, %.0f, %.0f), %.0f mm\n", h.place.c_str(), h.centre_mm.x(), h.centre_mm.y(),
                h.centre_mm.z(), h.around_mm);
  EXPECT_GE(r.cut, 1);
  EXPECT_EQ(census(m).components, 2);
  EXPECT_EQ(census(m).genus, 0);
  EXPECT_EQ(r.hole.size(), 0u);
  EXPECT_GT(r.found, 0.95);
  EXPECT_GT(r.reached, 0.97);
}

TEST(Prepare, AirwayAndInnerTableAreBehindTheSeal) {
  // A shell with a narrow way in: sealed; a ball that fits through it finds the inside.
  const Volume v = sampled(50, 2, [](const Vec3& x) {
    const double shell = 5 - std::abs(x.norm() - 32), hole = std::hypot(x.y(), x.z()) - 7;
    return std::clamp(x.x() > 0 ? std::min(shell, hole) : shell, -4., 4.) * 250;
  });
  InlineWorkers w;
  PrepareSettings q;
  q.sigma_voxels = 0;
  for (const double seal : {3., 12.}) {
    q.seal_mm = seal;
    const Prepared p = prepare(v, q, w);
    const VolumeSampler guide(p.guide);
    EXPECT_NEAR(guide.value({0, 0, 37}), 0, 2.) << seal;
    EXPECT_NEAR(guide.value({0, 0, 47}), 10, 2.) << seal;
    if (seal > 7)
      EXPECT_LT(guide.value({0, 0, 0}), -25);
    else
      EXPECT_GT(guide.value({0, 0, 0}), 20);
    for (const Vec3& x : p.surface_mm) EXPECT_TRUE(seal < 7 || x.norm() > 30);
  }
}

TEST(Prepare, DistancesAreExactAndSmoothingKeepsTheSum) {
  std::vector<uint8_t> set(9 * 7 * 5, 0);
  const std::array<int32_t, 3> n{9, 7, 5};
  const std::vector<std::array<int, 3>> at{{1, 2, 3}, {7, 5, 0}, {4, 4, 4}};
  for (const auto& a : at) set[size_t(a[0] + 9 * (a[1] + 7 * a[2]))] = 1;
  InlineWorkers w;
  const std::vector<float> d = squared_distance(n, set, w);
  for (int k = 0; k < 5; ++k)
    for (int j = 0; j < 7; ++j)
      for (int i = 0; i < 9; ++i) {
        int best = 1 << 20;
        for (const auto& a : at)
          best = std::min(best, (a[0] - i) * (a[0] - i) + (a[1] - j) * (a[1] - j) + (a[2] - k) * (a[2] - k));
        EXPECT_EQ(d[size_t(i + 9 * (j + 7 * k))], float(best));
      }
  const Volume v = sampled(15, 1, [](const Vec3& x) { return x.norm() < 0.5 ? 1000. : 0.; });
  const Volume s = smoothed(v, 1, w);
  double sum = 0, second = 0;
  for (size_t i = 0; i < s.value.size(); ++i) sum += s.value[i];
  for (int i = 0; i < 15; ++i)
    second += double(s.value[s.index(i, 7, 7)]) * (i - 7) * (i - 7) / double(s.value[s.index(7, 7, 7)]);
  EXPECT_NEAR(sum, 1000, 0.1);
  EXPECT_NEAR(second / std::sqrt(2 * 3.14159265), 1, 0.03);  // sum of i^2 exp(-i^2 / 2) = sqrt(2 pi)
}

TEST(Prepare, SaysWhatIsWrong) {
  InlineWorkers w;
  const Volume v = sampled(8, 1, [](const Vec3& x) { return 2 - x.norm(); });
  PrepareSettings q;
  const auto message = [&] {
    try {
      prepare(v, q, w);
    } catch (const InputError& e) {
      return std::string(e.what());
    }
    return std::string("accepted");
  };
  EXPECT_EQ(message(), "accepted");
  q.iso = 1000;
  EXPECT_NE(message().find("nothing in the volume"), std::string::npos);
  q.iso = -1000;
  EXPECT_NE(message().find("air around"), std::string::npos);
  q.iso = 0, q.seal_mm = -1;
  EXPECT_NE(message().find("ball"), std::string::npos);
}

TEST(Fit, ARealHead) {
  const char* path = std::getenv("LIMBERG_CT_HEAD");  // (see volume_test.cpp)
  if (!path) GTEST_SKIP() << "LIMBERG_CT_HEAD is not set";
  const Volume v = load_volume(path);
  InlineWorkers w;
  for (const bool bone : {false, true}) {
    PrepareSettings q;
    q.iso = bone ? 1274 : 724, q.seal_mm = bone ? 10 : 6;  // stored = HU + 1024: skin at -300, bone at 250
    if (bone) q.mouth_mm = 20, q.thin = 1124;              // as `fit --tissue bone` does
    const Prepared p = prepare(v, q, w);
    Mesh m = start_mesh(Start::sphere, p.low_mm, p.high_mm);
    FitSettings s;
    s.iso = q.iso, s.skull = bone;
    const FitReport r = fit(m, p, s, w);
    std::printf(
        "iso %g: %d vertices, %d iterations, found %.3f, rms %.3f mm, 95 %% %.3f mm, reached %.3f, %zu openings\n",
        q.iso, r.vertices, r.iterations, r.found, r.rms_mm, r.p95_mm, r.reached, r.hole.size());
    EXPECT_EQ(find_fault(m).value_or(""), "");
    EXPECT_GE(r.found, 0.95);
    EXPECT_LE(r.rms_mm, 0.5 * 1.5);
    EXPECT_GT(r.reached, 0.97);  // measured .986 and .992 on 2026-11-22
    const auto has = [&](const char* name) {
      return std::any_of(r.hole.begin(), r.hole.end(), [&](const FitHole& h) { return h.place.starts_with(name); });
    };
    EXPECT_TRUE(has("volume border, superior") && has("volume border, inferior"));
    if (bone)
      EXPECT_TRUE(has("orbit, left") && has("orbit, right") && has("nose"));
    else
      EXPECT_EQ(r.hole.size(), 2u);
  }
}

}  // namespace test_fit
}  // namespace limberg
