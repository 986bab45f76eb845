#include "app/window/ray_cast.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace limberg {
namespace {

/// A ray that runs along the edge of two triangles meets one of them: in shares of a triangle, some thousandths of a
/// mm. Without it a stroke of the mouse fell through the skin where its way lay on an edge of the mesh.
constexpr double kEdge = 1e-5;

struct Met {
  bool met = false;
  double at = 0, u = 0, v = 0;
};
/// Moeller and Trumbore 1997.
Met meet(const Vec3& o, const Vec3& d, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 e1 = b - a, e2 = c - a, p = d.cross(e2);
  const double det = e1.dot(p);
  if (std::abs(det) < 1e-12) return {};
  const Vec3 s = o - a, q = s.cross(e1);
  const double u = s.dot(p) / det, v = d.dot(q) / det, t = e2.dot(q) / det;
  return {u >= -kEdge && v >= -kEdge && u + v <= 1 + kEdge && t > 0, t, u, v};
}

}  // namespace

RayHit cast_ray(const Snapshot& s, const Vec3f& origin, const Vec3f& towards, bool bone_only) {
  RayHit hit;
  if (!s.topology) return hit;
  const Vec3 o = origin.cast<double>(), d = towards.cast<double>();
  const auto& tri = s.topology->view.tri;
  double nearest = std::numeric_limits<double>::max();
  for (size_t t = 0; t < tri.size(); ++t) {
    if (bone_only && !s.topology->is_ground(t, Ground::bone)) continue;
    const Tri k = tri[t];
    const Vec3f &a = s.x_mm[size_t(k[0])], &b = s.x_mm[size_t(k[1])], &c = s.x_mm[size_t(k[2])];
    const Met met = meet(o, d, a.cast<double>(), b.cast<double>(), c.cast<double>());
    if (!met.met || met.at >= nearest) continue;
    nearest = met.at;
    hit.triangle = int32_t(t);
    const double u = std::clamp(met.u, 0.0, 1.0), v = std::clamp(met.v, 0.0, 1.0 - u);
    hit.bary = Vec3(1 - u - v, u, v).cast<float>();
    hit.normal = (b - a).cross(c - a);
  }
  if (hit.triangle < 0) return hit;
  hit.distance_mm = float(nearest);
  hit.x_mm = origin + float(nearest) * towards;
  hit.normal.normalize();
  if (hit.normal.dot(towards) > 0) hit.normal = -hit.normal;
  return hit;
}

}  // namespace limberg
