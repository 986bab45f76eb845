#include "app/window/ray_cast.h"

#include <limits>

namespace limberg {

RayHit cast_ray(const Snapshot& s, const Vec3f& o, const Vec3f& d, bool bone_only) {
  RayHit hit;
  if (!s.topology) return hit;
  const auto& tri = s.topology->view.tri;
  float nearest = std::numeric_limits<float>::max();
  for (size_t t = 0; t < tri.size(); ++t) {
    if (bone_only && !s.topology->is_ground(t, Ground::bone)) continue;
    const Tri k = tri[t];
    const Vec3f &a = s.x_mm[size_t(k[0])], e1 = s.x_mm[size_t(k[1])] - a, e2 = s.x_mm[size_t(k[2])] - a;
    const Vec3f p = d.cross(e2);
    const float det = e1.dot(p);
    if (det == 0) continue;
    const Vec3f from = o - a;
    const float u = from.dot(p) / det;
    if (!(u >= 0 && u <= 1)) continue;
    const Vec3f q = from.cross(e1);
    const float v = d.dot(q) / det, at = e2.dot(q) / det;
    if (!(v >= 0 && u + v <= 1 && at > 0 && at < nearest)) continue;
    nearest = at;
    hit.triangle = int32_t(t);
    hit.bary = {1 - u - v, u, v};
    hit.normal = e1.cross(e2);
  }
  if (hit.triangle < 0) return hit;
  hit.distance_mm = nearest;
  hit.x_mm = o + nearest * d;
  hit.normal.normalize();
  if (hit.normal.dot(d) > 0) hit.normal = -hit.normal;
  return hit;
}

}  // namespace limberg
