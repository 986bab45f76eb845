#include "sim/imaging/fit/surface_distances.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/base/error.h"
#include "sim/geometry/triangle.h"
#include "sim/imaging/fit/level_set.h"

namespace limberg {
namespace {

constexpr int32_t kSlab = 16;  // slices marched at a time: what is not meant never fills the memory all at once
constexpr double kR2[2] = {0.7548776662466927, 0.5698402909980532};  // 1 / p and 1 / p^2, p^3 = p + 1

double triangle_mm2(std::span<const Vec3> x, const Tri& t) {
  return 0.5 * area_vector2(x[size_t(t[0])], x[size_t(t[1])], x[size_t(t[2])]).norm();
}

double area_mm2(const Surface& s) {
  double sum = 0;
  for (const Tri& t : s.tri) sum += triangle_mm2(s.x_mm, t);
  return sum;
}

}  // namespace

Surface isosurface(const Volume& v, double iso, Workers& workers, const std::function<bool(const Vec3&)>& counts) {
  Surface out;
  if (*std::min_element(v.size.begin(), v.size.end()) < 2) return out;
  const bool mirrored = v.step_mm.determinant() < 0;
  for (int32_t k0 = 0; k0 + 1 < v.size[2]; k0 += kSlab) {
    LevelSet slab;  // in voxels, so that every sample is a voxel's own value; it has no bound, and no block is skipped
    slab.distance_mm = [&](const Vec3& voxel) {
      std::array<int32_t, 3> i{};
      for (size_t a = 0; a < 3; ++a) i[a] = std::clamp(int32_t(std::lround(voxel[Eigen::Index(a)])), 0, v.size[a] - 1);
      return iso - double(v.value[v.index(i[0], i[1], i[2])]);
    };
    slab.lipschitz = std::numeric_limits<double>::infinity();
    slab.low_mm = Vec3(0, 0, k0);
    slab.high_mm = Vec3(v.size[0] - 1, v.size[1] - 1, std::min(k0 + kSlab, v.size[2] - 1));
    std::vector<Vec3> x;
    std::vector<Tri> tri;
    march(slab, 1, workers, x, tri);
    for (Vec3& p : x) p = v.place(p);
    std::vector<int32_t> number(x.size(), -1);
    for (Tri t : tri) {
      if (counts && !counts((x[size_t(t[0])] + x[size_t(t[1])] + x[size_t(t[2])]) / 3)) continue;
      if (mirrored) std::swap(t[1], t[2]);
      for (int32_t& c : t) {
        int32_t& n = number[size_t(c)];
        if (n < 0) n = int32_t(out.x_mm.size()), out.x_mm.push_back(x[size_t(c)]);
        c = n;
      }
      out.tri.push_back(t);
    }
  }
  return out;
}

std::vector<Vec3> spread_points(std::span<const Vec3> x, std::span<const Tri> tri, double per_mm2, int64_t most) {
  double all = 0;
  for (const Tri& t : tri) all += triangle_mm2(x, t);
  std::vector<Vec3> points;
  if (!(all > 0) || !std::isfinite(all)) return points;
  const auto n = int64_t(std::max(1., std::min(std::ceil(all * per_mm2), double(most))));
  points.reserve(size_t(n));
  double before = 0;
  for (const Tri& t : tri) {
    before += triangle_mm2(x, t);  // in the order of `all`, so that the last one ends there
    while (int64_t(points.size()) < n && (double(points.size()) + 0.5) / double(n) * all < before) {
      const double i = double(points.size()) + 1;
      double u = i * kR2[0] - std::floor(i * kR2[0]), w = i * kR2[1] - std::floor(i * kR2[1]);
      if (u + w > 1) u = 1 - u, w = 1 - w;  // the square's other half
      points.push_back((1 - u - w) * x[size_t(t[0])] + u * x[size_t(t[1])] + w * x[size_t(t[2])]);
    }
  }
  return points;
}

SurfaceDistances distances_to(const Bvh& faces, std::span<const Vec3> from, double within_mm, Workers& workers) {
  SurfaceDistances r;
  r.samples = int64_t(from.size());
  if (from.empty()) return r;
  std::vector<double> d(from.size());
  workers.parallel_for(from.size(), 256, [&](size_t first, size_t last) {
    for (size_t i = first; i < last; ++i) d[i] = faces.closest(from[i]).distance_mm;
  });
  double sum = 0, squares = 0, near_squares = 0;
  int64_t near = 0;
  for (const double x : d) {
    sum += x, squares += x * x;
    if (x <= within_mm) ++near, near_squares += x * x;
  }
  const double n = double(d.size());
  r.mean_mm = sum / n, r.rms_mm = std::sqrt(squares / n), r.reached = double(near) / n;
  r.reached_rms_mm = near > 0 ? std::sqrt(near_squares / double(near)) : 0;
  r.max_mm = *std::max_element(d.begin(), d.end());
  const auto p95 = d.begin() + std::ptrdiff_t((d.size() * 19 + 19) / 20 - 1);  // the least that 95 % do not exceed
  std::nth_element(d.begin(), p95, d.end());
  r.p95_mm = *p95;
  return r;
}

DistancesBothWays surface_distances(const Surface& surface, const Surface& iso, const SurfaceDistanceSettings& s,
                                    Workers& workers) {
  if (!(s.within_mm > 0 && s.per_mm2 > 0 && s.most_samples > 0) || !std::isfinite(s.within_mm + s.per_mm2))
    throw InputError("", 0, "a distance, a density and a number of points above 0 were expected");
  DistancesBothWays both;
  both.surface_mm2 = area_mm2(surface), both.isosurface_mm2 = area_mm2(iso);
  const auto one_way = [&](const Surface& from, const Surface& to) {
    return distances_to(Bvh(to.x_mm, to.tri), spread_points(from.x_mm, from.tri, s.per_mm2, s.most_samples),
                        s.within_mm, workers);
  };
  for (const double area : {both.surface_mm2, both.isosurface_mm2})
    if (!(area > 0) || !std::isfinite(area))
      throw InputError("", 0, "two surfaces with an area were expected, to tell how far they lie apart");
  both.to_isosurface = one_way(surface, iso), both.from_isosurface = one_way(iso, surface);
  return both;
}

}  // namespace limberg
