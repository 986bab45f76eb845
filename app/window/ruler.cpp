#include "app/window/ruler.h"

#include <cmath>

#include "sim/geometry/triangle.h"

namespace limberg {

void Ruler::add(const Snapshot& s, const RayHit& hit) {
  if (hit.triangle < 0) return;
  if (points_.size() == 3) points_.clear();
  Point p;
  p.version = s.topology->version, p.triangle = hit.triangle, p.bary = hit.bary, p.x_mm = hit.x_mm;
  const SurfaceView& view = s.topology->view;
  p.kind = view.kind[size_t(hit.triangle)];
  const Tri k = view.tri[size_t(hit.triangle)];
  for (int i = 0; i < 3; ++i) p.X_mm += double(hit.bary[i]) * view.X_mm[size_t(k[size_t(i)])];
  points_.push_back(p);
}

// After a cut: the triangle of the same kind of surface that lies nearest at rest.
void Ruler::find_again(Point& p, const Snapshot& s) {
  const SurfaceView& view = s.topology->view;
  double nearest2 = 1e30;
  for (size_t t = 0; t < view.tri.size(); ++t) {
    if (view.kind[t] != p.kind) continue;
    const Tri k = view.tri[t];
    const TrianglePoint c =
        closest_on_triangle(p.X_mm, view.X_mm[size_t(k[0])], view.X_mm[size_t(k[1])], view.X_mm[size_t(k[2])]);
    const double d2 = (c.point - p.X_mm).squaredNorm();
    if (d2 < nearest2)
      nearest2 = d2, p.triangle = int32_t(t), p.bary = Vec3f(float(c.bary[0]), float(c.bary[1]), float(c.bary[2]));
  }
  p.version = s.topology->version;
}

Ruler::Reading Ruler::read(const Snapshot& s) {
  Reading r;
  if (!s.topology) return r;
  for (Point& p : points_) {
    if (p.version != s.topology->version) find_again(p, s);
    const Tri k = s.topology->view.tri[size_t(p.triangle)];
    p.x_mm = p.bary[0] * s.x_mm[size_t(k[0])] + p.bary[1] * s.x_mm[size_t(k[1])] + p.bary[2] * s.x_mm[size_t(k[2])];
    r.at_mm.push_back(p.x_mm);
  }
  const size_t n = points_.size();
  if (n >= 2) {
    r.length_mm = double((r.at_mm[n - 1] - r.at_mm[n - 2]).norm());
    r.rest_mm = (points_[n - 1].X_mm - points_[n - 2].X_mm).norm();
  }
  if (n == 3) {
    const Vec3f a = r.at_mm[0] - r.at_mm[1], b = r.at_mm[2] - r.at_mm[1];
    r.angle_deg = std::atan2(double(a.cross(b).norm()), double(a.dot(b))) * 180 / M_PI;
  }
  return r;
}

}  // namespace limberg
