#include "sim/skull/bone/shape.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <limits>

#include "sim/geometry/triangle.h"
#include "sim/skull/simplex/dual.h"

namespace limberg::bone {

using simplex::FaceKind;
using simplex::Mesh;

FragmentShape fragment_shape(const Mesh& m, int32_t vertex) {
  FragmentShape out;
  out.surface = bone_surface(m, component_of(m, vertex));
  const BoneSurface& s = out.surface;
  std::vector<int32_t> walls;
  out.lo_mm = Vec3::Constant(std::numeric_limits<double>::infinity()), out.hi_mm = -out.lo_mm;
  for (size_t t = 0; t < s.tri.size(); ++t) {
    const Vec3 &a = s.X_mm[size_t(s.tri[t][0])], &b = s.X_mm[size_t(s.tri[t][1])], &c = s.X_mm[size_t(s.tri[t][2])];
    for (const Vec3* x : {&a, &b, &c}) out.lo_mm = out.lo_mm.cwiseMin(*x), out.hi_mm = out.hi_mm.cwiseMax(*x);
    if (m.kind(s.face[t]) != FaceKind::wall) continue;
    walls.push_back(int32_t(t));
    const Vec3 n = area_vector2(a, b, c);
    if (n.norm() > 0) out.wall.push_back({(a + b + c) / 3, n.normalized(), n.norm() / 2});
  }
  if (!walls.empty()) out.walls = Bvh(s.X_mm, s.tri, walls);
  return out;
}

std::vector<Prism> prisms_of(const Mesh& m, const FragmentShape& shape) {
  const BoneSurface& s = shape.surface;
  std::vector<int32_t> faces = s.face;
  faces.erase(std::unique(faces.begin(), faces.end()), faces.end());
  std::vector<Vec3> normal(m.face_edge.size(), Vec3::Zero());
  for (int32_t f : faces) {
    const Vec3 a = simplex::face_area(m, f).vector_mm2;
    if (a.norm() > 0) normal[size_t(f)] = a.normalized();
  }
  // Per vertex the offset that leads one mm inwards from each of its faces (least squares), and how far it may go.
  std::vector<Vec3> in(m.nbr.size(), Vec3::Zero());
  std::vector<double> deep(m.nbr.size(), 0);
  constexpr double kMargin_mm = RigidWorld::kMargin_mm, kLeast_mm = 0.1;
  const auto thick = [&](const Vec3& x, const Vec3& along) {
    double t = std::numeric_limits<double>::infinity();
    for (const Bvh::LineHit& h : s.bvh.line(x, along, 0.05, 2.5 * RigidWorld::kThick_mm))
      if (!h.from_outside) {
        t = h.t;
        break;
      }
    return std::max(std::min(RigidWorld::kThick_mm, 0.45 * t), RigidWorld::kInset_mm + kMargin_mm + kLeast_mm);
  };
  const auto offset = [&](int32_t v) {
    Mat3 M = 0.02 * Mat3::Identity();
    Vec3 b = Vec3::Zero();
    for (int32_t f : m.left[size_t(v)]) M += normal[size_t(f)] * normal[size_t(f)].transpose(), b += normal[size_t(f)];
    Vec3 d = M.ldlt().solve(b);
    if (d.norm() > 2) d *= 2 / d.norm();  // a sharp edge: no spike inwards
    return Vec3(-d);
  };
  std::vector<Prism> out;
  for (int32_t f : faces) {
    if (is_end(m.kind(f))) continue;
    Prism p;
    const auto add = [&](const Vec3& x, const Vec3& inwards, double depth) {
      p.push_back(x + (RigidWorld::kInset_mm + kMargin_mm) * inwards);
      p.push_back(x + depth * inwards);
    };
    m.around(f, [&](int32_t h) {
      const size_t v = size_t(h / 3);
      if (deep[v] == 0) in[v] = offset(h / 3), deep[v] = thick(m.x_mm[v], in[v].normalized());
      add(m.x_mm[v], in[v], deep[v]);
    });
    const Vec3 c = simplex::face_centre(m, f), n = -normal[size_t(f)];
    if (n != Vec3::Zero()) add(c, n, thick(c, n));
    out.push_back(std::move(p));
  }
  return out;
}

}  // namespace limberg::bone
