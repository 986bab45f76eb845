#include "sim/measure/penetration.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/base/elementary.h"
#include "sim/geometry/bvh.h"
#include "sim/geometry/triangle.h"

namespace limberg {
namespace {

constexpr double kSpacing_mm = 1;
constexpr double kInside_mm = 1e-3;  // a place is moved so far into its own tissue; rounding of float positions is 1e-5
constexpr double kReach_mm = 30;     // overlaps are not followed farther
constexpr double kSeen_mm = 0.02;    // an overlap that counts as area

struct Ways {
  std::array<Vec3, 17> along;  // around +z: the axis, then 8 at 30 and 8 at 60 degrees
  Ways() {
    along[0] = Vec3::UnitZ();
    for (size_t k = 0; k < 8; ++k)
      for (size_t ring = 0; ring < 2; ++ring) {
        const double tilt = (ring + 1.0) * std::numbers::pi / 6,
                     turn = (double(k) + 0.5 * double(ring)) * std::numbers::pi / 4;
        along[1 + 2 * k + ring] = {elementary::sin(tilt) * elementary::cos(turn),
                                   elementary::sin(tilt) * elementary::sin(turn), elementary::cos(tilt)};
      }
  }
};

class Probe {
 public:
  explicit Probe(const Bvh& surface) : surface_(surface) {}

  int winding(const Vec3& p, const Vec3& direction) {
    hits_ = surface_.line(p, direction, 0, 1e4);
    int w = 0;
    for (const Bvh::LineHit& h : hits_) w += h.from_outside ? -1 : 1;
    return w;
  }

  /// Length until the cover that is `w` at p has fallen to 1; kReach_mm at most.
  double way_out(const Vec3& p, const Vec3& direction, int w, double limit) {
    hits_ = surface_.line(p, direction, 0, limit);
    for (const Bvh::LineHit& h : hits_)
      if ((w += h.from_outside ? 1 : -1) <= 1) return h.t;
    return limit;
  }

 private:
  const Bvh& surface_;
  std::vector<Bvh::LineHit> hits_;
};

/// 1 for triangles to look at: walls, and skin that shares a corner with one.
std::vector<uint8_t> wounded(const SurfaceView& view) {
  std::vector<uint8_t> corner(view.X_mm.size(), 0), out(view.tri.size(), 0);
  for (size_t t = 0; t < view.tri.size(); ++t)
    if (view.kind[t] == FaceKind::wall)
      for (int32_t v : view.tri[t]) corner[size_t(v)] = 1;
  for (size_t t = 0; t < view.tri.size(); ++t) {
    const Tri& c = view.tri[t];
    out[t] = view.kind[t] == FaceKind::wall ||
             (view.kind[t] == FaceKind::skin && (corner[size_t(c[0])] || corner[size_t(c[1])] || corner[size_t(c[2])]));
  }
  return out;
}

}  // namespace

Penetration penetration(const SurfaceView& view, std::span<const Vec3f> x_mm) {
  Penetration found;
  if (std::none_of(view.kind.begin(), view.kind.end(), [](FaceKind k) { return k == FaceKind::wall; })) return found;
  std::vector<Vec3> x;
  x.reserve(x_mm.size());
  for (const Vec3f& p : x_mm) x.push_back(p.cast<double>());
  const Bvh surface(x, view.tri.flat());
  const std::vector<uint8_t> look = wounded(view);
  static const Ways ways;
  Probe probe(surface);
  std::vector<std::pair<double, double>> depth;  // depth, rest area
  for (size_t t = 0; t < view.tri.size(); ++t) {
    if (!look[t]) continue;
    const Tri& c = view.tri[t];
    const Vec3 &A = view.X_mm[size_t(c[0])], &B = view.X_mm[size_t(c[1])], &C = view.X_mm[size_t(c[2])];
    const Vec3 &a = x[size_t(c[0])], &b = x[size_t(c[1])], &d = x[size_t(c[2])];
    const Vec3 n2 = area_vector2(a, b, d);
    const double area = 0.5 * area_vector2(A, B, C).norm();
    if (!(n2.norm() > 0) || !(area > 0)) continue;
    const Vec3 n = n2.normalized();
    const int parts =
        std::clamp(int(std::ceil(std::max({(B - A).norm(), (C - B).norm(), (A - C).norm()}) / kSpacing_mm)), 1, 1000);
    Vec3 across = n.cross(std::abs(n.x()) < 0.7 ? Vec3::UnitX() : Vec3::UnitY()).normalized();
    const Vec3 along = n.cross(across);
    const auto at = [&](double i, double j) {  // the middle of a part
      const double u = i / parts, v = j / parts, w = 1 - u - v;
      const Vec3 p = w * a + u * b + v * d - kInside_mm * n;
      double deep = 0;
      // Two rays that are no multiples of anything in the scene; a true overlap shows along both.
      const int cover = probe.winding(p, -n + 0.0131 * across + 0.0071 * along);
      if (cover >= 2 && probe.winding(p, -0.83 * n - 0.37 * across + 0.29 * along) >= 2) {
        deep = kReach_mm;
        for (const Vec3& way : ways.along)
          deep = std::min(deep, probe.way_out(p, way.x() * across + way.y() * along - way.z() * n, cover, deep));
        deep += kInside_mm;
      }
      depth.push_back({deep, area / (parts * parts)});
      if (deep > found.max_mm) found.max_mm = deep, found.at_mm = p;
    };
    for (int i = 0; i < parts; ++i)
      for (int j = 0; i + j < parts; ++j) {
        at(i + 1.0 / 3, j + 1.0 / 3);
        if (i + j + 1 < parts) at(i + 2.0 / 3, j + 2.0 / 3);
      }
  }
  for (const auto& [deep, area] : depth) {
    found.area_mm2 += area;
    if (deep > kSeen_mm) found.overlapping_mm2 += area;
  }
  std::sort(depth.begin(), depth.end());
  double above = 0;
  for (size_t i = depth.size(); i-- > 0;) {
    above += depth[i].second;
    if (above > 0.01 * found.area_mm2) {
      found.p99_mm = depth[i].first;
      break;
    }
  }
  return found;
}

double winding_number(const SurfaceView& view, std::span<const Vec3f> x_mm, const Vec3& p) {
  double sum = 0;  // solid angle of a triangle: van Oosterom and Strackee 1983
  for (const Tri& c : view.tri) {
    const Vec3 a = x_mm[size_t(c[0])].cast<double>() - p, b = x_mm[size_t(c[1])].cast<double>() - p,
               d = x_mm[size_t(c[2])].cast<double>() - p;
    const double la = a.norm(), lb = b.norm(), ld = d.norm();
    sum += 2 * elementary::atan2(a.dot(b.cross(d)), la * lb * ld + a.dot(b) * ld + b.dot(d) * la + d.dot(a) * lb);
  }
  return sum / (4 * std::numbers::pi);
}

}  // namespace limberg
