// Slices in between by shape: nearer to the surface than grey values straight up, and the slices stay what they were.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "sim/base/error.h"
#include "sim/imaging/fit/shape_interpolation.h"

namespace limberg {
namespace test_shape_interpolation {

constexpr double kIso = 250;

/// Signed distance of a body, in mm, above 0 inside.
using Body = std::function<double(const Vec3&)>;

/// Bone of 1000 HU in soft tissue of 50, blurred over 2 mm; `tall`: the axis with steps of 6 mm, the others have 1 mm.
Volume voxels_of(const Body& body, int tall = 2) {
  Volume v;
  for (int k = 0; k < 3; ++k) {
    const double step = k == tall ? 6 : 1;
    v.size[size_t(k)] = int32_t(78 / step) + 1, v.step_mm(k, k) = step, v.origin_mm[k] = -39;
  }
  for (int32_t k = 0; k < v.size[2]; ++k)
    for (int32_t j = 0; j < v.size[1]; ++j)
      for (int32_t i = 0; i < v.size[0]; ++i)
        v.value.push_back(float(50 + 950 * std::clamp(0.5 + body(v.place(Vec3(i, j, k))) / 2, 0., 1.)));
  return v;
}

/// Where the body's surface shows at the isovalue: 250 is 0.58 mm outside of the middle of its rim.
double offset() { return 2 * ((kIso - 50) / 950 - 0.5); }

/// Straight up: what the grey values alone say.
Volume linear(const Volume& v, int parts) {
  Volume out = v;
  out.size[2] = (v.size[2] - 1) * parts + 1;
  out.step_mm.col(2) /= parts;
  out.value.clear();
  const VolumeSampler s(v);
  for (int32_t k = 0; k < out.size[2]; ++k)
    for (int32_t j = 0; j < out.size[1]; ++j)
      for (int32_t i = 0; i < out.size[0]; ++i) out.value.push_back(float(s.value(out.place(Vec3(i, j, k)))));
  return out;
}

struct Error {
  double rms_mm = 0, most_mm = 0;
  int places = 0;
};
/// Of the places on the lines between voxels where the volume falls through the isovalue.
Error error_of(const Volume& v, const Body& body) {
  Error e;
  for (int32_t k = 0; k < v.size[2]; ++k)
    for (int32_t j = 0; j < v.size[1]; ++j)
      for (int32_t i = 0; i < v.size[0]; ++i)
        for (int a = 0; a < 3; ++a) {
          const Vec3 p(i, j, k), q = p + Vec3::Unit(a);
          if (q[a] >= v.size[size_t(a)]) continue;
          const double f = double(v.value[v.index(i, j, k)]) - kIso,
                       h = double(v.value[v.index(int(q[0]), int(q[1]), int(q[2]))]) - kIso;
          if ((f >= 0) == (h >= 0)) continue;
          const double d = std::abs(body(v.place(p + f / (f - h) * (q - p))) - offset());
          e.rms_mm += d * d, e.most_mm = std::max(e.most_mm, d), ++e.places;
        }
  e.rms_mm = std::sqrt(e.rms_mm / std::max(1, e.places));
  return e;
}

double ball(const Vec3& x) { return 30.3 - (x - Vec3(0.3, -0.2, 0.7)).norm(); }
double cylinder(const Vec3& x) {  // slanted by 45 degrees
  const Vec3 way = Vec3(1, 0.2, 1).normalized(), p = x - Vec3(0.4, 0.1, 0.2);
  return 12.2 - (p - way * way.dot(p)).norm();
}

// Measured on 2026-11-27, voxels of 1 x 1 x 6 mm made 1 x 1 x 1 mm, rms distance of the places at the isovalue to the
// body: ball 0.211 mm by shape, 1.035 mm by grey values straight up; slanted cylinder 0.072 mm and 0.808 mm.
TEST(ShapeInterpolation, IsNearerToTheSurfaceThanGreyValues) {
  InlineWorkers workers;
  struct Case {
    const char* name;
    Body body;
    double shape_rms_mm, linear_rms_mm;  // the one less than, the other more
  };
  for (const Case& c : {Case{"ball", ball, 0.22, 0.9}, Case{"cylinder", cylinder, 0.08, 0.7}}) {
    const Volume v = voxels_of(c.body);
    const Volume s = interpolated_by_shape(v, kIso, 1, workers);
    ASSERT_EQ(s.size, (std::array<int32_t, 3>{79, 79, 79}));
    EXPECT_NEAR(s.step_mm(2, 2), 1, 1e-12);
    const Error shape = error_of(s, c.body), grey = error_of(linear(v, 6), c.body);
    EXPECT_GT(shape.places, 10'000) << c.name;
    EXPECT_LT(shape.rms_mm, c.shape_rms_mm) << c.name;
    EXPECT_GT(grey.rms_mm, c.linear_rms_mm) << c.name;
  }
}

TEST(ShapeInterpolation, SlicesThatWereThereStay) {
  InlineWorkers workers;
  for (int tall = 0; tall < 3; ++tall) {
    const Volume v = voxels_of(ball, tall), s = interpolated_by_shape(v, kIso, 1.4, workers);  // 6 / 4 = 1.5
    EXPECT_EQ(s.size[size_t(tall)], 4 * (v.size[size_t(tall)] - 1) + 1);
    EXPECT_NEAR(s.step_mm(tall, tall), 1.5, 1e-12);
    EXPECT_EQ(s.origin_mm, v.origin_mm);
    for (int32_t k = 0; k < v.size[2]; ++k)
      for (int32_t j = 0; j < v.size[1]; ++j)
        for (int32_t i = 0; i < v.size[0]; ++i) {
          std::array<int32_t, 3> at{i, j, k};
          at[size_t(tall)] *= 4;
          ASSERT_EQ(s.value[s.index(at[0], at[1], at[2])], v.value[v.index(i, j, k)]);
        }
    EXPECT_LT(error_of(s, ball).rms_mm, 0.5) << tall;
  }
}

TEST(ShapeInterpolation, GreyValuesFarFromTheSurfaceGoStraightUp) {
  // Two tissues within one body, and noise without.
  const Body body = [](const Vec3& x) { return 30 - x.norm(); };
  Volume v = voxels_of(body);
  for (int32_t k = 0; k < v.size[2]; ++k)
    for (int32_t j = 0; j < v.size[1]; ++j)
      for (int32_t i = 0; i < v.size[0]; ++i)
        if (std::abs(body(v.place(Vec3(i, j, k)))) > 2) v.value[v.index(i, j, k)] += float(7 * k + (i * j) % 5);
  InlineWorkers workers;
  const Volume s = interpolated_by_shape(v, kIso, 1, workers), g = linear(v, 6);
  const float low = *std::min_element(v.value.begin(), v.value.end()),
              high = *std::max_element(v.value.begin(), v.value.end());
  for (const float x : s.value) ASSERT_TRUE(x >= low && x <= high) << x;  // no value that no slice has
  int seen = 0;
  for (int32_t k = 0; k < s.size[2]; ++k)
    for (int32_t j = 0; j < s.size[1]; ++j)
      for (int32_t i = 0; i < s.size[0]; ++i) {
        // Farther than 12 mm from the contours of both slices.
        const Vec3 x = s.place(Vec3(i, j, k));
        if (x.norm() > 12 || std::abs(x.z()) > 12) continue;
        ASSERT_NEAR(s.value[s.index(i, j, k)], g.value[g.index(i, j, k)], 1e-2);
        ++seen;
      }
  EXPECT_GT(seen, 5000);
}

TEST(ShapeInterpolation, EvenVoxelsComeBackAsTheyAre) {
  InlineWorkers workers;
  Volume v = voxels_of(ball);
  v.step_mm.col(2) *= 1.5 / 6;  // no more than 1.5 times the others
  const Volume same = interpolated_by_shape(v, kIso, 0.5, workers);
  EXPECT_EQ(same.size, v.size);
  EXPECT_EQ(same.step_mm, v.step_mm);
  EXPECT_TRUE(same.value == v.value);
  v.step_mm.col(2) *= 4;
  EXPECT_EQ(interpolated_by_shape(v, kIso, 6, workers).size, v.size);  // wanted as tall as they are
  EXPECT_NE(interpolated_by_shape(v, kIso, 3, workers).size, v.size);
}

TEST(ShapeInterpolation, ABodyEndsBetweenSlices) {
  // One slice has a disc, the next nothing: it ends between them, and nothing is where nothing was.
  const Volume v = voxels_of([](const Vec3& x) { return 30.5 - Vec3(x.x(), x.y(), 1.2 * x.z()).norm(); });
  InlineWorkers workers;
  const Volume s = interpolated_by_shape(v, kIso, 1, workers);
  const Error e = error_of(s, [](const Vec3& x) { return 30.5 - Vec3(x.x(), x.y(), 1.2 * x.z()).norm(); });
  EXPECT_LT(e.most_mm, 3);
  double area = 1e9;
  for (int32_t k = 39; k < s.size[2]; ++k) {  // from the middle upwards it only shrinks
    double now = 0;
    for (int32_t j = 0; j < s.size[1]; ++j)
      for (int32_t i = 0; i < s.size[0]; ++i) now += double(s.value[s.index(i, j, k)]) >= kIso;
    EXPECT_LE(now, area + 1) << k;
    area = now;
  }
  EXPECT_EQ(area, 0);
}

TEST(ShapeInterpolation, AThinPartGrowsIntoAThickOne) {
  // A disc of 2 mm in one slice, of 16 mm in the next: half way it is one of 9 mm, although the line through a pixel
  // there leaves the thin disc again on its other side. The isovalue is high, so that a mixture would fall below it.
  Volume v;
  v.size = {41, 41, 2}, v.step_mm(2, 2) = 6;
  for (const double radius : {2., 16.})
    for (int j = -20; j <= 20; ++j)
      for (int i = -20; i <= 20; ++i)
        v.value.push_back(float(1000 * std::clamp(0.5 + radius - std::hypot(i, j), 0., 1.)));
  InlineWorkers workers;
  const Volume s = interpolated_by_shape(v, 900, 3, workers);
  ASSERT_EQ(s.size[2], 3);
  int inside = 0;
  for (int j = 0; j < 41; ++j)
    for (int i = 0; i < 41; ++i) inside += s.value[s.index(i, j, 1)] >= 900;
  EXPECT_NEAR(inside, M_PI * 8.6 * 8.6, 12);  // 900 is 0.4 mm within
}

/// Chunks in reverse order, as any order of several workers might be.
class BackwardWorkers final : public Workers {
 public:
  int count() const override { return 2; }
  void parallel_for(size_t n, size_t grain, const std::function<void(size_t, size_t)>& body) override {
    for (size_t chunks = (n + grain - 1) / grain; chunks-- > 0;)
      body(chunks * grain, std::min(n, (chunks + 1) * grain));
  }
  std::shared_ptr<Job> submit(std::function<void()> job) override { return InlineWorkers().submit(std::move(job)); }
};

TEST(ShapeInterpolation, DoesNotDependOnTheWorkers) {
  InlineWorkers one;
  BackwardWorkers two;
  const Volume v = voxels_of(cylinder);
  EXPECT_TRUE(interpolated_by_shape(v, kIso, 1, one).value == interpolated_by_shape(v, kIso, 1, two).value);
}

TEST(ShapeInterpolation, NonsenseIsRefused) {
  InlineWorkers workers;
  const Volume v = voxels_of(ball);
  EXPECT_THROW(interpolated_by_shape(v, std::nan(""), 1, workers), InputError);
  EXPECT_THROW(interpolated_by_shape(v, kIso, 0, workers), InputError);
  EXPECT_THROW(interpolated_by_shape(v, kIso, 1e-5, workers), InputError);  // too many voxels
}

}  // namespace test_shape_interpolation
}  // namespace limberg
