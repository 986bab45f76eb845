// Components of the sided surface and the mesh that is read off the gluing.
#include <algorithm>
#include <limits>

#include "sim/cutting/store.h"
#include "sim/geometry/triangle.h"

namespace limberg {

namespace {

void find_components(const ArrangementStore& s) {
  if (s.components_known) return;
  s.component.clear();
  s.component_of.assign(2 * s.face.size(), -1);
  const double unit = s.grid.half_unit_mm();
  std::vector<int32_t> stack;
  for (int32_t start = 0; start < int32_t(2 * s.face.size()); ++start) {
    if (s.component_of[start] >= 0 || !s.face[start / 2].has_side(start % 2)) continue;
    const int32_t id = int32_t(s.component.size());
    SurfaceComponent c;
    c.first_sided_face = start;
    double sum = 0, lost = 0;  // compensated: 6 V in half-units^3
    stack.push_back(start);
    s.component_of[start] = id;
    while (!stack.empty()) {
      const int32_t sided = stack.back();
      stack.pop_back();
      const Face& f = s.face[sided / 2];
      ++c.sided_faces;
      c.touches_fixed = c.touches_fixed || (s.is_body(f.orig) && s.tag[f.orig] == SurfaceTag::fixed);
      const Vec3 &a = s.points.approx(f.v[0]), &b = s.points.approx(f.v[1]), &d = s.points.approx(f.v[2]);
      const double term = (sided % 2 == 1 ? 1.0 : -1.0) * a.dot(b.cross(d)) - lost;
      const double next = sum + term;
      lost = (next - sum) - term;
      sum = next;
      for (int k = 0; k < 3; ++k) {
        const int32_t m = s.mate[sided / 2][size_t(3 * (sided % 2) + k)];
        if (m < 0 || s.component_of[m / 3] >= 0) continue;
        s.component_of[m / 3] = id;
        stack.push_back(m / 3);
      }
    }
    c.volume_mm3 = sum * unit * unit * unit / 6;
    s.component.push_back(c);
  }
  s.components_known = true;
}

}  // namespace

const std::vector<SurfaceComponent>& Arrangement::components() const {
  find_components(*store_);
  return store_->component;
}

int32_t Arrangement::component_of(int32_t sided) const {
  find_components(*store_);
  return store_->component_of[sided];
}

int32_t Arrangement::loose_component_near(const Vec3& at_mm, double max_distance_mm) const {
  find_components(*store_);
  const auto& all = store_->component;
  size_t largest = 0;
  for (size_t i = 1; i < all.size(); ++i)
    if (all[i].volume_mm3 > all[largest].volume_mm3) largest = i;
  int32_t best[2] = {-1, -1};  // loose; touching the held side
  double distance[2] = {max_distance_mm, max_distance_mm};
  for (int32_t sided = 0; sided < int32_t(2 * store_->face.size()); ++sided) {
    const int32_t c = store_->component_of[sided];
    if (c < 0 || size_t(c) == largest || all[size_t(c)].volume_mm3 <= 0) continue;
    const Face& f = store_->face[sided / 2];
    const double d =
        (closest_on_triangle(at_mm, point_mm(f.v[0]), point_mm(f.v[1]), point_mm(f.v[2])).point - at_mm).norm();
    const int held = all[size_t(c)].touches_fixed;
    if (d < distance[held] || (d == distance[held] && best[held] < 0)) distance[held] = d, best[held] = c;
  }
  return best[0] >= 0 ? best[0] : best[1];
}

int Arrangement::pieces() const {
  int n = 0;
  for (const SurfaceComponent& c : components()) n += c.volume_mm3 > 0;
  return n;
}

double Arrangement::volume_mm3() const {
  double v = 0;
  for (const SurfaceComponent& c : components()) v += c.volume_mm3;
  return v;
}

}  // namespace limberg
