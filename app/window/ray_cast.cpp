#include "app/window/ray_cast.h"

#include <limits>

#include "sim/geometry/triangle.h"

namespace limberg {

RayHit cast_ray(const Snapshot& s, const Vec3f& o, const Vec3f& d, bool bone_only) {
  RayHit hit;
  if (!s.topology) return hit;
  const auto& tri = s.topology->view.tri;
  float nearest = std::numeric_limits<float>::max();
  for (size_t t = 0; t < tri.size(); ++t) {
    if (bone_only && !s.topology->is_ground(t, Ground::bone)) continue;
    const Tri k = tri[t];
    const Vec3f &a = s.x_mm[size_t(k[0])], &b = s.x_mm[size_t(k[1])], &c = s.x_mm[size_t(k[2])];
    const auto met = meet_ray(o, d, a, b, c);
    if (!met.met || met.at >= nearest) continue;
    nearest = met.at;
    hit.triangle = int32_t(t);
    hit.bary = {1 - met.u - met.v, met.u, met.v};
    hit.normal = (b - a).cross(c - a);
  }
  if (hit.triangle < 0) return hit;
  hit.distance_mm = nearest;
  hit.x_mm = o + nearest * d;
  hit.normal.normalize();
  if (hit.normal.dot(d) > 0) hit.normal = -hit.normal;
  return hit;
}

}  // namespace limberg
