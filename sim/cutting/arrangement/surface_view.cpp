// The mesh that is read off the gluing: a vertex is an orbit of corners.
//
// From nothing, or when something was taken away: triangles stand in the order of their sided faces, vertices in the
// order in which the triangles first name them; those of the view before come first, in its order.
#include "sim/cutting/arrangement/surface_view.h"

#include <algorithm>

#include "sim/base/union_find.h"
#include "sim/cutting/arrangement/store.h"
#include "sim/cutting/arrangement/surface_view_update.h"

namespace limberg {

std::array<Eigen::Vector2f, 3> ViewReader::uv(const Face& face) const {
  const OrigTri& o = s_.orig[face.orig];
  const OpRecord& op = s_.op[o.op];
  std::array<Eigen::Vector2f, 3> out;
  out.fill(Eigen::Vector2f::Zero());
  if (op.uv.empty()) return out;
  // At point p of an original triangle with corner uv t, by barycentric coordinates in its own plane.
  const std::array<Eigen::Vector2f, 3>& t = op.uv[face.orig - op.first_orig];
  const Vec3 &a = s_.points.approx(o.v[0]), &b = s_.points.approx(o.v[1]), &c = s_.points.approx(o.v[2]);
  const Vec3 u = b - a, v = c - a, n = u.cross(v);
  const double nn = n.squaredNorm();
  for (size_t i = 0; i < 3; ++i) {
    const int32_t p = face.v[i];
    const auto corner = std::find(o.v.begin(), o.v.end(), p);
    if (corner != o.v.end()) {
      out[i] = t[size_t(corner - o.v.begin())];
      continue;
    }
    const Vec3 w = s_.points.approx(p) - a;
    const double beta = w.cross(v).dot(n) / nn, gamma = u.cross(w).dot(n) / nn;
    out[i] = (t[0].cast<double>() * (1 - beta - gamma) + t[1].cast<double>() * beta + t[2].cast<double>() * gamma)
                 .cast<float>();
  }
  return out;
}

uint8_t ViewReader::rim(int32_t sided) const {
  uint8_t bits = 0;
  if (kind(s_.face[sided / 2].orig) != FaceKind::skin) return bits;
  for (int k = 0; k < 3; ++k) {
    const int32_t m = s_.mate[sided / 2][size_t(3 * (sided % 2) + k)];
    if (m >= 0 && kind(s_.face[m / 6].orig) == FaceKind::wall) bits |= uint8_t(1u << edge_in_view(sided, k));
  }
  return bits;
}

namespace {

/// Numbers of vertices by sided corner, for corners of new faces and for some of old ones.
class CornerTable {
 public:
  CornerTable(int32_t first_new, size_t corners) : first_new_(first_new), fresh_(corners, -1), slot_(1024) {}
  int32_t& at(int32_t corner) {
    if (corner >= first_new_) return fresh_[size_t(corner - first_new_)];
    if (used_ * 2 > slot_.size()) {
      std::vector<Slot> old(slot_.size() * 4);
      old.swap(slot_);
      for (const Slot& s : old)
        if (s.corner >= 0) slot_[find(s.corner)] = s;
    }
    Slot& s = slot_[find(corner)];
    if (s.corner < 0) s.corner = corner, ++used_;
    return s.vertex;
  }

 private:
  struct Slot {
    int32_t corner = -1, vertex = -1;
  };
  size_t find(int32_t corner) const {
    size_t i = size_t(uint32_t(corner) * 0x9e3779b9u >> 7) & (slot_.size() - 1);
    while (slot_[i].corner >= 0 && slot_[i].corner != corner) i = (i + 1) & (slot_.size() - 1);
    return i;
  }
  int32_t first_new_;
  std::vector<int32_t> fresh_;
  std::vector<Slot> slot_;
  size_t used_ = 0;
};

/// The whole mesh, those that stay in the order of `before`.
SurfaceView view_of_all(const ArrangementStore& s, const Arrangement& a, const SurfaceView& before, int32_t faces_then,
                        std::vector<int32_t>& earlier) {
  const ViewReader read(s, a);
  const int32_t n = int32_t(before.tri.size()), faces = int32_t(s.face.size());
  // What has gone, what has come, and at which points.
  std::vector<uint8_t> changed(size_t(s.points.size()), 0);
  std::vector<uint8_t> gone(size_t(n), 0);
  for (int32_t t = 0; t < n; ++t) {
    const int32_t sided = before.sided_face[size_t(t)];
    const Face& f = s.face[sided / 2];
    if (f.has_side(sided % 2)) continue;
    gone[size_t(t)] = 1;
    for (int32_t p : f.v) changed[size_t(p)] = 1;
  }
  for (int32_t f = faces_then; f < faces; ++f)
    if (s.face[f].live())
      for (int32_t p : s.face[f].v) changed[size_t(p)] = 1;

  SurfaceView view;
  earlier.clear();
  view.triangle_of.resize(size_t(2 * faces), -1);
  const auto vertex = [&](const Vec3& X, int32_t point, int32_t was) {
    view.X_mm.push_back(X);
    view.point.push_back(point);
    view.corners.push_back(0);
    earlier.push_back(was);
    return int32_t(view.X_mm.size()) - 1;
  };
  const auto triangle = [&](const Tri& t, int32_t sided) {
    view.triangle_of[size_t(sided)] = int32_t(view.tri.size());
    view.tri.push_back(t);
    view.sided_face.push_back(sided);
    view.rim.push_back(read.rim(sided));
    for (int32_t v : t) ++view.corners[size_t(v)];
  };
  // Number of each vertex of `before`: kUnseen until a triangle names it; kChanged: goes by its corner instead.
  constexpr int32_t kUnseen = -1, kChanged = -2;
  std::vector<int32_t> number(before.X_mm.size());
  for (size_t v = 0; v < number.size(); ++v) number[v] = changed[size_t(before.point[v])] ? kChanged : kUnseen;
  CornerTable table(6 * faces_then, size_t(6 * (faces - faces_then)));
  const auto by_corner = [&](int32_t corner, int32_t point) {
    if (const int32_t known = table.at(corner); known >= 0) return known;
    const int32_t made = vertex(a.point_mm(point), point, -1);
    read.orbit(corner, [&](int32_t at) { table.at(at) = made; });
    return made;
  };
  for (int32_t t = 0; t < n; ++t) {
    if (gone[size_t(t)]) continue;
    const Tri& old = before.tri[size_t(t)];
    const int32_t sided = before.sided_face[size_t(t)];
    Tri tri{};
    for (int i = 0; i < 3; ++i) {  // the first mention counts in the order of the face
      const size_t k = size_t(ViewReader::corner_in_view(sided, i));
      int32_t& v = number[size_t(old[k])];
      if (v >= 0)
        tri[k] = v;
      else if (v == kUnseen)
        tri[k] = v = vertex(before.X_mm[size_t(old[k])], before.point[size_t(old[k])], old[k]);
      else
        tri[k] = by_corner(3 * sided + i, before.point[size_t(old[k])]);
    }
    triangle(tri, sided);
    view.uv.push_back(before.uv[size_t(t)]);
    view.kind.push_back(before.kind[size_t(t)]);
    view.origin.push_back(before.origin[size_t(t)]);
  }
  for (int32_t f = faces_then; f < faces; ++f) {
    const Face& face = s.face[f];
    if (!face.live()) continue;
    const auto uv = read.uv(face);
    for (int side = 0; side < 2; ++side) {
      if (!face.has_side(side)) continue;
      const int32_t sided = sided_face(f, side);
      Tri t{};
      for (int i = 0; i < 3; ++i)
        t[size_t(ViewReader::corner_in_view(sided, i))] = by_corner(3 * sided + i, face.v[size_t(i)]);
      triangle(t, sided);
      view.uv.push_back(ViewReader::in_view(sided, uv));
      view.kind.push_back(read.kind(face.orig));
      view.origin.push_back(read.origin(face.orig));
    }
  }
  return view;
}

}  // namespace

SurfaceView Arrangement::surface_view(const SurfaceView& before, int32_t operations_then, ViewChange& change) const {
  change = {};
  SurfaceView view;
  if (!before.tri.empty() && follow_view(*store_, *this, before, operations_then, view, change)) return view;
  change = {};
  change.whole = true;
  return view_of_all(*store_, *this, before, int32_t(before.triangle_of.size() / 2), change.earlier);
}

SurfaceView Arrangement::surface_view() const {
  std::vector<int32_t> earlier;
  return view_of_all(*store_, *this, {}, 0, earlier);
}

std::vector<int32_t> surface_components(const SurfaceView& view) {
  UnionFind joined(view.X_mm.size());
  for (const Tri& t : view.tri)
    for (size_t k = 1; k < 3; ++k) joined.unite(t[0], t[k]);
  std::vector<int32_t> number(view.X_mm.size(), -1), out;
  int32_t count = 0;
  for (const Tri& t : view.tri) {
    int32_t& c = number[size_t(joined.find(t[0]))];
    if (c < 0) c = count++;
    out.push_back(c);
  }
  return out;
}

}  // namespace limberg
