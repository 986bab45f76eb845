#include "sim/skull/bone/surface.h"

#include <algorithm>

#include "sim/geometry/triangle.h"
#include "sim/skull/simplex/dual.h"

namespace limberg::bone {

using simplex::Mesh;

Vec3 BoneSurface::normal(int32_t t) const {
  const Tri& i = tri[size_t(t)];
  return area_vector2(X_mm[size_t(i[0])], X_mm[size_t(i[1])], X_mm[size_t(i[2])]).normalized();
}

bool BoneSurface::contains(const Vec3& x) const {
  // Directions that no plane of an axis contains. A line through a shared edge meets both triangles there: the same
  // sense at the same place counts once.
  static const Vec3 direction[] = {
      Vec3(0.2718281828, 0.3141592654, 0.9097).normalized(), Vec3(-0.8123, 0.2511, 0.5267).normalized(),
      Vec3(0.4409, -0.8731, 0.2117).normalized(), Vec3(-0.3313, -0.5279, -0.7822).normalized(),
      Vec3(0.6731, 0.7013, -0.2351).normalized()};
  int votes = 0;
  for (const Vec3& d : direction) {
    int net = 0;
    double at_in = -1, at_out = -1;
    for (const Bvh::LineHit& h : bvh.line(x, d, 0, 1e6)) {
      double& at = h.from_outside ? at_in : at_out;
      if (at >= 0 && h.t <= at + 1e-9) continue;
      at = h.t, net += h.from_outside ? -1 : 1;
    }
    if (net == 0 || net == 1) return net == 1;
    votes += net > 0 ? 1 : -1;
  }
  return votes > 0;
}

Vec3 fan_centre(const Mesh& m, int32_t f) {
  if (!is_end(m.kind(f))) return simplex::face_centre(m, f);
  Vec3 c = Vec3::Zero();
  m.around(f, [&](int32_t h) { c += m.x_mm[size_t(h / 3)] / m.face_size[size_t(f)]; });
  return c;
}

BoneSurface bone_surface(const Mesh& m, std::span<const uint8_t> in) {
  BoneSurface out;
  out.X_mm = m.x_mm;
  for (int32_t f = 0; f < m.face_slots(); ++f) {
    if (!m.alive_face(f) || !in[size_t(m.face_edge[size_t(f)] / 3)]) continue;
    const int32_t c = int32_t(out.X_mm.size());
    out.X_mm.push_back(fan_centre(m, f));
    m.around(f, [&](int32_t h) { out.tri.push_back({c, m.from(h), m.to(h)}), out.face.push_back(f); });
  }
  out.bvh = Bvh(out.X_mm, out.tri);
  return out;
}

std::vector<uint8_t> component_of(const Mesh& m, int32_t v) {
  std::vector<uint8_t> in(m.nbr.size(), 0);
  std::vector<int32_t> stack{v};
  in[size_t(v)] = 1;
  while (!stack.empty()) {
    const int32_t u = stack.back();
    stack.pop_back();
    for (int32_t w : m.nbr[size_t(u)])
      if (!in[size_t(w)]) in[size_t(w)] = 1, stack.push_back(w);
  }
  return in;
}

std::vector<Bulk> bulks(const Mesh& m, std::span<const int32_t> component, int32_t count) {
  std::vector<Bulk> out(size_t(std::max(count, 0)));
  for (int32_t f = 0; f < m.face_slots(); ++f) {
    if (!m.alive_face(f)) continue;
    Bulk& b = out[size_t(component[size_t(m.face_edge[size_t(f)] / 3)])];
    const Vec3 c = fan_centre(m, f);
    m.around(f, [&](int32_t h) {
      const Vec3 &p = m.x_mm[size_t(h / 3)], &q = m.x_mm[size_t(m.to(h))];
      const double v = c.dot(p.cross(q)) / 6;
      b.volume_mm3 += v, b.centre_mm += v / 4 * (c + p + q);
    });
  }
  for (Bulk& b : out)
    if (b.volume_mm3 != 0) b.centre_mm /= b.volume_mm3;
  return out;
}

}  // namespace limberg::bone
