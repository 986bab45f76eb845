// The mesh that is read off the gluing: a vertex is an orbit of corners.
//
// Triangles stand in the order of their sided faces, vertices in the order in which the triangles first name them. So the
// mesh is a function of the surface alone, and one that follows an earlier one can be put together from it: triangles that
// are still there keep what they had, and only vertices at points of faces that have come or gone are found again.
#include <algorithm>

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

/// Gives all corners of an orbit their vertex: turns around the point through mates until back at the start; the surface is
/// closed, so it ends.
void name_orbit(const ArrangementStore& s, int32_t corner, int32_t point, int32_t vertex, CornerTable& table) {
  int32_t at = corner;
  int out = corner % 3;  // the edge through which the current face is left
  do {
    table.at(at) = vertex;
    const int32_t m = s.mate[at / 6][size_t(at % 6 - at % 3 + out)];
    const Face& f = s.face[m / 6];
    const int k = m % 3;
    const int c = f.v[size_t(k)] == point ? k : (k + 1) % 3;
    out = c == k ? (k + 2) % 3 : c;
    at = m - k + c;
  } while (table.at(at) < 0);
}

}  // namespace

SurfaceView Arrangement::surface_view(const SurfaceView& before, int32_t faces_then,
                                      std::vector<int32_t>* earlier) const {
  const ArrangementStore& s = *store_;
  components();
  const int32_t n = int32_t(before.tri.size()), faces = int32_t(s.face.size());

  // What has gone, what has come, and at which points.
  std::vector<uint8_t> changed(size_t(s.points.size()), 0);
  std::vector<int32_t> gone;  // triangles of `before`
  for (int32_t t = 0; t < n; ++t) {
    const int32_t sided = before.sided_face[size_t(t)];
    const Face& f = s.face[sided / 2];
    if (f.has_side(sided % 2)) continue;
    gone.push_back(t);
    for (int32_t p : f.v) changed[size_t(p)] = 1;
  }
  size_t come = 0;
  for (int32_t f = faces_then; f < faces; ++f) {
    const Face& face = s.face[f];
    if (!face.live()) continue;
    come += size_t(face.mat & 1) + size_t(face.mat >> 1);
    for (int32_t p : face.v) changed[size_t(p)] = 1;
  }

  SurfaceView view;
  const size_t triangles = size_t(n) - gone.size() + come;
  view.X_mm.reserve(before.X_mm.size() + come);
  view.point.reserve(before.X_mm.size() + come);
  view.uv.reserve(triangles);
  view.kind.reserve(triangles);
  view.sided_face.reserve(triangles);
  view.component.reserve(triangles);
  view.origin.reserve(triangles);
  view.tri.resize(triangles);
  if (earlier) {
    earlier->clear();
    earlier->reserve(before.X_mm.size() + come);
  }

  // Number of each vertex of `before`: kUnseen until a triangle names it; kChanged: goes by its corner instead.
  constexpr int32_t kUnseen = -1, kChanged = -2;
  std::vector<int32_t> number(before.X_mm.size());
  for (size_t v = 0; v < number.size(); ++v) number[v] = changed[size_t(before.point[v])] ? kChanged : kUnseen;
  CornerTable table(6 * faces_then, size_t(6 * (faces - faces_then)));
  const auto by_corner = [&](int32_t corner, int32_t point) {
    if (const int32_t known = table.at(corner); known >= 0) return known;
    const int32_t made = int32_t(view.X_mm.size());
    name_orbit(s, corner, point, made, table);
    view.X_mm.push_back(point_mm(point));
    view.point.push_back(point);
    if (earlier) earlier->push_back(-1);
    return made;
  };

  size_t out = 0;
  const auto keep = [&](int32_t from, int32_t to) {  // triangles of `before`
    for (int32_t t = from; t < to; ++t) {
      const Tri& old = before.tri[size_t(t)];
      Tri& tri = view.tri[out++];
      const int32_t sided = before.sided_face[size_t(t)];
      // Corners of a triangle on the positive side stand in the order 0, 2, 1 of its face; the first mention counts in
      // the order of the face.
      const bool turned = sided % 2 == 0;
      for (size_t i = 0; i < 3; ++i) {
        const size_t k = turned && i > 0 ? 3 - i : i;
        int32_t& v = number[size_t(old[k])];
        if (v >= 0) {
          tri[k] = v;
        } else if (v == kUnseen) {
          tri[k] = v = int32_t(view.X_mm.size());
          view.X_mm.push_back(before.X_mm[size_t(old[k])]);
          view.point.push_back(before.point[size_t(old[k])]);
          if (earlier) earlier->push_back(old[k]);
        } else {
          tri[k] = by_corner(3 * sided + int32_t(i), before.point[size_t(old[k])]);
        }
      }
    }
    const auto copy = [&](auto& to_list, const auto& from_list) {
      to_list.insert(to_list.end(), from_list.begin() + from, from_list.begin() + to);
    };
    copy(view.uv, before.uv);
    copy(view.kind, before.kind);
    copy(view.sided_face, before.sided_face);
    copy(view.origin, before.origin);
  };
  int32_t from = 0;
  for (int32_t t : gone) {
    keep(from, t);
    from = t + 1;
  }
  keep(from, n);
  for (int32_t f = faces_then; f < faces; ++f) {
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
      for (size_t k = 0; k < 3; ++k) t[k] = by_corner(3 * sided + int32_t(k), face.v[k]);
      // Material on the positive side: seen from outside, the stored order runs clockwise.
      std::array<Eigen::Vector2f, 3> w = uv;
      if (side == 0) std::swap(t[1], t[2]), std::swap(w[1], w[2]);
      view.tri[out++] = t;
      view.uv.push_back(w);
      view.kind.push_back(kind_of_orig(face.orig));
      view.sided_face.push_back(sided);
      view.origin.push_back(o.op == 0 ? face.orig : o.op);
    }
  }
  for (int32_t sided : view.sided_face) view.component.push_back(s.component_of[sided]);
  return view;
}

SurfaceView Arrangement::surface_view() const { return surface_view({}, 0); }

}  // namespace limberg
