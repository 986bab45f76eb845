// The mesh that is read off the gluing: a vertex is an orbit of corners.
#include "sim/cutting/store.h"

namespace limberg {

namespace {

// uv at point p of an original triangle with corner uv t, by barycentric coordinates in its own plane.
Eigen::Vector2f uv_at(const ArrangementStore& s, const OrigTri& o, const std::array<Eigen::Vector2f, 3>& t, int32_t p) {
  for (size_t k = 0; k < 3; ++k)
    if (o.v[k] == p) return t[k];
  const Vec3 &a = s.points.approx(o.v[0]), &b = s.points.approx(o.v[1]), &c = s.points.approx(o.v[2]);
  const Vec3 u = b - a, v = c - a, w = s.points.approx(p) - a, n = u.cross(v);
  const double nn = n.squaredNorm(), beta = w.cross(v).dot(n) / nn, gamma = u.cross(w).dot(n) / nn;
  return (t[0].cast<double>() * (1 - beta - gamma) + t[1].cast<double>() * beta + t[2].cast<double>() * gamma)
      .cast<float>();
}

}  // namespace

SurfaceView Arrangement::surface_view() const {
  const ArrangementStore& s = *store_;
  components();
  SurfaceView view;
  size_t triangles = 0;
  for (const Face& f : s.face)
    if (!f.retired) triangles += size_t(f.mat & 1) + size_t(f.mat >> 1);
  view.tri.reserve(triangles);
  view.uv.reserve(triangles);
  view.kind.reserve(triangles);
  view.sided_face.reserve(triangles);
  view.component.reserve(triangles);
  view.origin.reserve(triangles);
  view.X_mm.reserve(triangles / 2 + 16);
  view.point.reserve(triangles / 2 + 16);

  std::vector<int32_t> vertex_of(6 * s.face.size(), -1);  // per sided corner, numbered like sided half-edges
  const auto orbit = [&](int32_t corner, int32_t vertex, int32_t point) {
    // Turn around the point through mates until back at the start; the surface is closed, so it ends.
    int32_t at = corner;
    int out = corner % 3;  // the edge through which the current face is left
    do {
      vertex_of[at] = vertex;
      const int32_t m = s.mate[at / 6][size_t(at % 6 - at % 3 + out)];
      const Face& f = s.face[m / 6];
      const int k = m % 3;
      const int c = f.v[size_t(k)] == point ? k : (k + 1) % 3;
      out = c == k ? (k + 2) % 3 : c;
      at = m - k + c;
    } while (vertex_of[at] < 0);
  };

  for (int32_t f = 0; f < int32_t(s.face.size()); ++f) {
    const Face& face = s.face[f];
    if (!face.live()) continue;
    const OrigTri& o = s.orig[face.orig];
    const OpRecord& op = s.op[o.op];
    std::array<Eigen::Vector2f, 3> uv;
    uv.fill(Eigen::Vector2f::Zero());
    if (!op.uv.empty())
      for (size_t k = 0; k < 3; ++k) uv[k] = uv_at(s, o, op.uv[face.orig - op.first_orig], face.v[k]);
    for (int side = 0; side < 2; ++side) {
      if (!face.has_side(side)) continue;
      const int32_t sided = sided_face(f, side);
      Tri t{};
      for (int k = 0; k < 3; ++k) {
        const int32_t corner = 3 * sided + k;
        if (vertex_of[corner] < 0) {
          const int32_t point = face.v[size_t(k)];
          orbit(corner, int32_t(view.X_mm.size()), point);
          view.X_mm.push_back(point_mm(point));
          view.point.push_back(point);
        }
        t[size_t(k)] = vertex_of[corner];
      }
      // Material on the positive side: seen from outside, the stored order runs clockwise.
      std::array<Eigen::Vector2f, 3> w = uv;
      if (side == 0) std::swap(t[1], t[2]), std::swap(w[1], w[2]);
      view.tri.push_back(t);
      view.uv.push_back(w);
      view.kind.push_back(kind_of_orig(face.orig));
      view.sided_face.push_back(sided);
      view.component.push_back(s.component_of[sided]);
      view.origin.push_back(o.op == 0 ? face.orig : o.op);
    }
  }
  return view;
}

}  // namespace limberg
