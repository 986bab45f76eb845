// Distances between a surface and an isosurface, against balls whose distance is known.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/base/elementary.h"
#include "sim/base/error.h"
#include "sim/geometry/triangle.h"
#include "sim/imaging/fit/surface_distances.h"

namespace limberg {
namespace test_surface_distances {

constexpr double kBall = 20, kApart = 0.3;  // mm: radius of the voxels' ball, how much larger the mesh is
constexpr double kIso = 250;

/// Balls of radius kBall about the places: kIso on their surfaces, and 200 more for each mm that a voxel lies deeper.
/// In voxels that are neither even nor upright: .7 x .8 x .9 mm. `mirror`: the third axis points down.
Volume balls(const std::vector<Vec3>& centre, bool mirror = false) {
  Volume v;
  Mat3 turn;
  turn << 0.6, -0.8, 0, 0.8, 0.6, 0, 0, 0, mirror ? -1 : 1;
  v.step_mm = turn * Vec3(0.7, 0.8, 0.9).asDiagonal();
  Vec3 low = centre[0], high = centre[0];
  for (const Vec3& c : centre) low = low.cwiseMin(c), high = high.cwiseMax(c);
  const double around = 1.5 * kBall + 0.8 * (high - low).norm();
  for (size_t a = 0; a < 3; ++a) v.size[a] = int32_t(2 * around / v.step_mm.col(Eigen::Index(a)).norm());
  v.origin_mm = 0.5 * (low + high) - 0.5 * v.step_mm * Vec3(v.size[0], v.size[1], v.size[2]);
  for (int32_t k = 0; k < v.size[2]; ++k)
    for (int32_t j = 0; j < v.size[1]; ++j)
      for (int32_t i = 0; i < v.size[0]; ++i) {
        double best = -1e9;
        for (const Vec3& c : centre) best = std::max(best, kBall - (v.place(Vec3(i, j, k)) - c).norm());
        v.value.push_back(float(kIso + 200 * best));
      }
  return v;
}

/// A ball of triangles by latitude and longitude, less the cap within `cap` (radians) of its upper pole.
Surface ball(double radius, double cap = 0, int rings = 90, int around = 180) {
  Surface s;
  for (int r = 0; r <= rings; ++r) {
    const double polar = cap + (std::numbers::pi - cap) * r / rings;
    for (int a = 0; a < around; ++a) {
      const double turn = 2 * std::numbers::pi * a / around, q = radius * elementary::sin(polar);
      s.x_mm.emplace_back(q * elementary::cos(turn), q * elementary::sin(turn), radius * elementary::cos(polar));
    }
  }
  for (int r = 0; r < rings; ++r)
    for (int a = 0; a < around; ++a) {
      const int32_t p = r * around + a, q = r * around + (a + 1) % around;
      s.tri.push_back({p, p + around, q}), s.tri.push_back({q, p + around, q + around});
    }
  return s;
}

TEST(SurfaceDistances, ABallThreeTenthsLargerBothWays) {
  InlineWorkers w;
  const Surface iso = isosurface(balls({Vec3::Zero()}), kIso, w);
  const DistancesBothWays d = surface_distances(ball(kBall + kApart), iso, {}, w);
  for (const SurfaceDistances& one : {d.to_isosurface, d.from_isosurface}) {
    EXPECT_NEAR(one.mean_mm, kApart, 0.02);
    EXPECT_NEAR(one.rms_mm, kApart, 0.02);
    EXPECT_NEAR(one.p95_mm, kApart, 0.02);
    EXPECT_NEAR(one.max_mm, kApart, 0.035);  // a flat face over a voxel's diagonal of 1.4 mm is .012 mm within the ball
    EXPECT_GE(one.max_mm, one.p95_mm);
    EXPECT_GE(one.rms_mm, one.mean_mm);
    EXPECT_EQ(one.reached, 1);
    EXPECT_EQ(one.reached_rms_mm, one.rms_mm);
  }
  const double area = 4 * std::numbers::pi * kBall * kBall;
  EXPECT_NEAR(d.isosurface_mm2, area, 0.005 * area);
  EXPECT_NEAR(double(d.from_isosurface.samples), d.isosurface_mm2, 1);
  EXPECT_NEAR(double(d.to_isosurface.samples), d.surface_mm2, 1);
  std::printf("%.1f mm apart: mean %.4f, rms %.4f, at most %.4f mm to the isosurface; %.4f, %.4f, %.4f mm from it\n",
              kApart, d.to_isosurface.mean_mm, d.to_isosurface.rms_mm, d.to_isosurface.max_mm,
              d.from_isosurface.mean_mm, d.from_isosurface.rms_mm, d.from_isosurface.max_mm);
}

// A coarse mesh with every vertex on the ball is wrong between them only: figures of vertices alone would say 0.
TEST(SurfaceDistances, FacesCountNotOnlyVertices) {
  InlineWorkers w;
  const Surface iso = isosurface(balls({Vec3::Zero()}), kIso, w);
  const Surface coarse = ball(kBall, 0, 6, 12);
  const SurfaceDistances at_vertices = distances_to(Bvh(iso.x_mm, iso.tri), coarse.x_mm, 1, w);
  EXPECT_LT(at_vertices.max_mm, 0.03);
  double mean = 0;  // of the truth, over the same points
  const std::vector<Vec3> points = spread_points(coarse.x_mm, coarse.tri, 1, 100'000);
  for (const Vec3& p : points) mean += (kBall - p.norm()) / double(points.size());
  const DistancesBothWays d = surface_distances(coarse, iso, {}, w);
  EXPECT_GT(mean, 0.7);
  EXPECT_NEAR(d.to_isosurface.mean_mm, mean, 0.02);
}

// What the mesh leaves out shows from the isosurface, and from there only.
TEST(SurfaceDistances, AHoleIsTheShareThatIsNotReached) {
  InlineWorkers w;
  const Surface iso = isosurface(balls({Vec3::Zero()}), kIso, w);
  const double cap = 0.9, within = 0.5, far = kBall + kApart;
  const DistancesBothWays d = surface_distances(ball(far, cap), iso, {within, 10, 200'000}, w);
  // The rim reaches over the hole: a place of the ball is `within` of it up to the angle delta.
  const double delta = elementary::acos((kBall * kBall + far * far - within * within) / (2 * kBall * far));
  const double left_out = 0.5 * (1 - elementary::cos(cap - delta));
  EXPECT_NEAR(1 - d.from_isosurface.reached, left_out, 0.01 * left_out);
  EXPECT_NEAR(d.from_isosurface.reached_rms_mm, kApart, 0.02);
  EXPECT_GT(d.from_isosurface.max_mm, 0.9 * 2 * kBall * elementary::sin(0.5 * cap));  // the pole to the rim
  EXPECT_EQ(d.to_isosurface.reached, 1);
  EXPECT_NEAR(d.to_isosurface.mean_mm, kApart, 0.02);
  std::printf("a hole of %.2f %% of the ball: %.2f %% not reached\n", 100 * left_out,
              100 * (1 - d.from_isosurface.reached));
}

// Of two balls in the volume only the one that counts is meant, both ways.
TEST(SurfaceDistances, OnlyWhatCountsIsMeant) {
  InlineWorkers w;
  const Volume v = balls({Vec3::Zero(), Vec3(50, 0, 0)});
  const Surface mine = isosurface(v, kIso, w, [](const Vec3& x) { return x.x() < 25; });
  for (const Vec3& x : mine.x_mm) ASSERT_LT(x.x(), 25);
  const DistancesBothWays one = surface_distances(ball(kBall + kApart), mine, {}, w);
  EXPECT_EQ(one.from_isosurface.reached, 1);
  const DistancesBothWays all = surface_distances(ball(kBall + kApart), isosurface(v, kIso, w), {}, w);
  EXPECT_NEAR(all.from_isosurface.reached, 0.5, 0.001);
  EXPECT_NEAR(all.to_isosurface.mean_mm, one.to_isosurface.mean_mm, 1e-9);
}

// Triangles look to where the volume is below, whichever way its axes turn, and go on over the seams of the slabs.
TEST(SurfaceDistances, TheIsosurfaceIsWholeAndLooksOutwards) {
  InlineWorkers w;
  for (const bool mirror : {false, true}) {
    const Surface s = isosurface(balls({Vec3::Zero()}, mirror), kIso, w);
    double volume = 0, area = 0;
    for (const Tri& t : s.tri) {
      const Vec3 &a = s.x_mm[size_t(t[0])], &b = s.x_mm[size_t(t[1])], &c = s.x_mm[size_t(t[2])];
      volume += a.dot(b.cross(c)) / 6, area += 0.5 * area_vector2(a, b, c).norm();
    }
    EXPECT_NEAR(volume, 4. / 3 * std::numbers::pi * kBall * kBall * kBall, 0.003 * 33510);
    EXPECT_NEAR(area, 4 * std::numbers::pi * kBall * kBall, 0.005 * 5027);
  }
}

// The points are as dense on small triangles as on large ones.
TEST(SurfaceDistances, PointsAreSpreadByArea) {
  const std::vector<Vec3> x{{0, 0, 0}, {40, 0, 0}, {0, 40, 0}, {40, 40, 0}, {41, 40, 0}, {40, 41, 0}};
  std::vector<Tri> tri{{0, 1, 2}, {1, 3, 2}};
  for (int i = 0; i < 400; ++i) tri.push_back({3, 4, 5});
  const std::vector<Vec3> p = spread_points(x, tri, 2, 100'000);
  ASSERT_EQ(p.size(), size_t(2 * (1600 + 200)));
  int low = 0, small = 0;
  std::array<int, 16> square{};
  for (const Vec3& q : p) {
    if (q.x() > 40 && q.y() > 40) {
      ++small;
      continue;
    }
    low += q.x() + q.y() < 40;
    ++square[size_t(std::min(3., q.x() / 10)) + 4 * size_t(std::min(3., q.y() / 10))];
  }
  EXPECT_NEAR(small, 400, 1);
  EXPECT_NEAR(low, 1600, 1);
  for (const int n : square) EXPECT_NEAR(n, 200, 12);  // 14 is the standard deviation of points by chance
  EXPECT_EQ(spread_points(x, tri, 2, 100).size(), 100u);
  EXPECT_TRUE(spread_points(x, {}, 2, 100).empty());
}

// Points 1 to 100 mm above a plane: every figure in closed form.
TEST(SurfaceDistances, Figures) {
  InlineWorkers w;
  const std::vector<Vec3> x{{-9, -9, 0}, {9, -9, 0}, {0, 9, 0}};
  const std::vector<Tri> tri{{0, 1, 2}};
  std::vector<Vec3> from;
  for (int i = 0; i < 100; ++i) from.emplace_back(0, 0, 1 + i * 37 % 100);
  const SurfaceDistances d = distances_to(Bvh(x, tri), from, 30, w);
  EXPECT_EQ(d.samples, 100);
  EXPECT_DOUBLE_EQ(d.mean_mm, 50.5);
  EXPECT_DOUBLE_EQ(d.rms_mm, std::sqrt(101 * 201 / 6.));
  EXPECT_EQ(d.p95_mm, 95);
  EXPECT_EQ(d.max_mm, 100);
  EXPECT_DOUBLE_EQ(d.reached, 0.3);
  EXPECT_DOUBLE_EQ(d.reached_rms_mm, std::sqrt(31 * 61 / 6.));
  EXPECT_EQ(distances_to(Bvh(x, tri), {}, 30, w).samples, 0);
}

/// The chunks last to first.
class Backwards final : public Workers {
 public:
  int count() const override { return 3; }
  void parallel_for(size_t n, size_t grain, const std::function<void(size_t, size_t)>& body) override {
    for (size_t c = (n + grain - 1) / grain; c-- > 0;) body(c * grain, std::min(n, (c + 1) * grain));
  }
  std::shared_ptr<Job> submit(std::function<void()> job) override { return InlineWorkers().submit(std::move(job)); }
};

TEST(SurfaceDistances, DoNotDependOnTheWorkers) {
  InlineWorkers one;
  Backwards other;
  const Volume v = balls({Vec3::Zero()});
  const Surface a = isosurface(v, kIso, one), b = isosurface(v, kIso, other), mesh = ball(kBall + kApart);
  EXPECT_EQ(a.x_mm, b.x_mm);
  EXPECT_EQ(a.tri, b.tri);
  const DistancesBothWays p = surface_distances(mesh, a, {}, one), q = surface_distances(mesh, b, {}, other);
  EXPECT_EQ(p.from_isosurface.rms_mm, q.from_isosurface.rms_mm);
  EXPECT_EQ(p.to_isosurface.p95_mm, q.to_isosurface.p95_mm);
}

TEST(SurfaceDistances, RefuseWhatHasNoArea) {
  InlineWorkers w;
  const Volume v = balls({Vec3::Zero()});
  const Surface none = isosurface(v, 1e5, w);
  EXPECT_TRUE(none.tri.empty());
  EXPECT_THROW(surface_distances(ball(kBall), none, {}, w), InputError);
  EXPECT_THROW(surface_distances(none, isosurface(v, kIso, w), {}, w), InputError);
  EXPECT_THROW(surface_distances(ball(kBall), ball(kBall), {0, 1, 10}, w), InputError);
  Volume thin = v;
  thin.size = {v.size[0], v.size[1], 1};
  EXPECT_TRUE(isosurface(thin, kIso, w).tri.empty());
}

}  // namespace test_surface_distances
}  // namespace limberg
