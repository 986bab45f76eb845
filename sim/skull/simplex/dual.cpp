#include "sim/skull/simplex/dual.h"

#include <Eigen/Cholesky>
#include <algorithm>

#include "sim/base/error.h"
#include "sim/geometry/triangle.h"

namespace limberg::simplex {
namespace {

constexpr double kToCentroid = 0.01;

/// Half way from the mean of the q_i to argmin sum_i ((p - q_i) . n_i)^2 + 0.01 |p - mean|^2 (positive definite).
/// The tangent planes of a sphere through points on it meet as far outside as the mean lies inside, to second order in
/// their distance, so half way is on the sphere to third order.
class Nearest {
 public:
  explicit Nearest(const Vec3& mean) : mean_(mean) {}
  void plane(const Vec3& q, const Vec3& n) { M_ += n * n.transpose(), b_ += n * n.dot(q - mean_); }
  Vec3 solve() const { return mean_ + 0.5 * M_.ldlt().solve(b_); }

 private:
  Vec3 mean_, b_ = Vec3::Zero();
  Mat3 M_ = kToCentroid * Mat3::Identity();
};

Vec3 unit(const Vec3& n) {
  const double l = n.norm();
  return l > 0 ? Vec3(n / l) : Vec3(Vec3::Zero());
}

struct Side {
  int32_t lo, hi, tri, k;  // edge k of tri runs lo -> hi or hi -> lo
  bool up;                 // lo -> hi
};

[[noreturn]] void refuse(const std::string& what) {
  throw InputError("", 0, what + "; an oriented manifold surface was expected");
}

}  // namespace

Mesh from_triangles(const std::vector<Vec3>& X, const std::vector<Tri>& tri, DualPlacement placement) {
  if (tri.empty()) refuse("there are no triangles");
  if (tri.size() > size_t(INT32_MAX / 12)) refuse("there are too many triangles");
  const auto text = [](auto i) { return std::to_string(i); };
  for (size_t i = 0; i < X.size(); ++i)
    if (!X[i].allFinite()) refuse("vertex " + text(i) + " is not at a finite place");
  std::vector<Side> side;
  side.reserve(3 * tri.size());
  std::vector<Vec3> normal(X.size(), Vec3::Zero());
  for (size_t t = 0; t < tri.size(); ++t) {
    for (int32_t v : tri[t])
      if (v < 0 || size_t(v) >= X.size())
        refuse("triangle " + text(t) + " names vertex " + text(v) + ", which does not exist");
    for (size_t k = 0; k < 3; ++k) {
      const int32_t a = tri[t][k], b = tri[t][(k + 1) % 3];
      if (a == b) refuse("triangle " + text(t) + " has the corner " + text(a) + " twice");
      side.push_back({std::min(a, b), std::max(a, b), int32_t(t), int32_t(k), a < b});
    }
    const Vec3 n = area_vector2(X[size_t(tri[t][0])], X[size_t(tri[t][1])], X[size_t(tri[t][2])]);
    for (int32_t v : tri[t]) normal[size_t(v)] += n;
  }
  for (Vec3& n : normal) n = unit(n);
  std::sort(side.begin(), side.end(), [](const Side& a, const Side& b) {
    return a.lo != b.lo ? a.lo < b.lo : a.hi != b.hi ? a.hi < b.hi : a.tri != b.tri ? a.tri < b.tri : a.k < b.k;
  });
  std::vector<Row> nbr(tri.size(), Row{-1, -1, -1});
  struct Border {
    int32_t from, to, tri, k;  // as the triangle sees it: from -> to
  };
  std::vector<Border> border;
  std::vector<int32_t> leaving(X.size(), -1);  // border edge that starts at the vertex
  for (size_t i = 0; i < side.size();) {
    size_t j = i + 1;
    while (j < side.size() && side[j].lo == side[i].lo && side[j].hi == side[i].hi) ++j;
    const std::string edge = "the edge " + text(side[i].lo) + " - " + text(side[i].hi);
    if (j - i > 2) refuse(edge + " belongs to " + text(j - i) + " triangles");
    if (j - i == 2) {
      if (side[i].up == side[i + 1].up) refuse("the triangles at " + edge + " disagree in orientation");
      nbr[size_t(side[i].tri)][size_t(side[i].k)] = side[i + 1].tri;
      nbr[size_t(side[i + 1].tri)][size_t(side[i + 1].k)] = side[i].tri;
    } else {
      const int32_t a = side[i].up ? side[i].lo : side[i].hi, b = side[i].up ? side[i].hi : side[i].lo;
      if (leaving[size_t(a)] >= 0) refuse("two borders touch at vertex " + text(a));
      leaving[size_t(a)] = int32_t(border.size());
      border.push_back({a, b, side[i].tri, side[i].k});
    }
    i = j;
  }
  // Border loops: one cone triangle (from, tip, to) per edge from -> to, joined along the edges to the tip.
  std::vector<int32_t> cone(border.size(), -1), hole_start;
  int32_t next = int32_t(tri.size());
  for (int32_t v = 0; size_t(v) < X.size(); ++v) {
    const int32_t first = leaving[size_t(v)];
    if (first < 0 || cone[size_t(first)] >= 0) continue;
    std::vector<int32_t> loop;
    for (int32_t e = first; cone[size_t(e)] < 0; e = leaving[size_t(border[size_t(e)].to)]) {
      cone[size_t(e)] = next++;
      loop.push_back(e);
      if (leaving[size_t(border[size_t(e)].to)] < 0)
        refuse("the border is not closed at vertex " + text(border[size_t(e)].to));
    }
    const size_t n = loop.size();
    if (n < 3) refuse("a border has only " + text(n) + " edges");
    hole_start.push_back(cone[size_t(first)]);
    for (size_t i = 0; i < n; ++i) {
      const Border& b = border[size_t(loop[i])];
      // Cone triangle (to, from, tip): across to->from is the triangle,
      // across from->tip the cone before, across tip->to the next.
      nbr.push_back({b.tri, cone[size_t(loop[(i + n - 1) % n])], cone[size_t(loop[(i + 1) % n])]});
      nbr[size_t(b.tri)][size_t(b.k)] = cone[size_t(loop[i])];
    }
  }
  std::vector<Vec3> x(nbr.size());
  for (size_t t = 0; t < tri.size(); ++t) {
    Vec3 mean = Vec3::Zero();
    for (int32_t v : tri[t]) mean += X[size_t(v)] / 3;
    Nearest near(mean);
    for (int32_t v : tri[t]) near.plane(X[size_t(v)], normal[size_t(v)]);
    x[t] = placement == DualPlacement::centroid ? mean : near.solve();
  }
  for (size_t e = 0; e < border.size(); ++e)
    x[size_t(cone[e])] = 0.5 * (X[size_t(border[e].from)] + X[size_t(border[e].to)]);
  Mesh m = make_mesh(std::move(nbr), std::move(x));
  // A face per fan: two fans at one vertex would be two faces. Count: used vertices + holes.
  std::vector<uint8_t> used(X.size(), 0);
  int64_t faces = int64_t(hole_start.size());
  for (const Tri& t : tri)
    for (int32_t v : t) faces += !used[size_t(v)], used[size_t(v)] = 1;
  if (faces != m.faces()) refuse("somewhere two fans of triangles touch in a single vertex");
  for (int32_t v : hole_start) m.face_kind[size_t(m.left[size_t(v)][1])] = FaceKind::hole;
  return m;
}

Vec3 face_centre(const Mesh& m, int32_t f) {
  Vec3 mean = Vec3::Zero();
  m.around(f, [&](int32_t h) { mean += m.x_mm[size_t(h / 3)]; });
  mean /= m.face_size[size_t(f)];
  Nearest near(mean);
  const auto is_wall = [&](int32_t g) { return m.kind(g) == FaceKind::wall; };
  m.around(f, [&](int32_t h) {
    const Row &r = m.nbr[size_t(h / 3)], &l = m.left[size_t(h / 3)];
    if (is_wall(l[0]) || is_wall(l[1]) || is_wall(l[2])) {  // at a crease: the corner of this face alone
      const Vec3& before = m.x_mm[size_t(r[size_t(h % 3 + 1) % 3])];
      near.plane(m.x_mm[size_t(h / 3)], unit(area_vector2(m.x_mm[size_t(h / 3)], m.x_mm[size_t(m.to(h))], before)));
      return;
    }
    near.plane(m.x_mm[size_t(h / 3)],
               unit(area_vector2(m.x_mm[size_t(r[0])], m.x_mm[size_t(r[1])], m.x_mm[size_t(r[2])])));
  });
  return near.solve();
}

FaceArea face_area(const Mesh& m, int32_t f) {
  const Vec3 c = face_centre(m, f);
  FaceArea a;
  m.around(f, [&](int32_t h) {
    const Vec3 v = 0.5 * area_vector2(c, m.x_mm[size_t(h / 3)], m.x_mm[size_t(m.to(h))]);
    a.area_mm2 += v.norm(), a.vector_mm2 += v;
  });
  return a;
}

FanTriangles fan_triangles(const Mesh& m) {
  FanTriangles out;
  out.X_mm = m.x_mm;
  for (int32_t f = 0; f < m.face_slots(); ++f) {
    if (!m.alive_face(f) || is_end(m.kind(f))) continue;
    const int32_t c = int32_t(out.X_mm.size());
    out.X_mm.push_back(face_centre(m, f));
    m.around(f, [&](int32_t h) { out.tri.push_back({c, m.from(h), m.to(h)}), out.face.push_back(f); });
  }
  return out;
}

DualTriangles dual_triangles(const Mesh& m) {
  DualTriangles out;
  std::vector<int32_t> number(m.face_edge.size(), -1);
  for (int32_t f = 0; f < m.face_slots(); ++f) {
    if (!m.alive_face(f) || is_end(m.kind(f))) continue;
    number[size_t(f)] = int32_t(out.X_mm.size());
    out.X_mm.push_back(face_centre(m, f)), out.face_of.push_back(f);
  }
  for (int32_t v = 0; v < m.slots(); ++v) {
    if (!m.alive(v)) continue;
    // Edge k of the triangle is the one that neighbour k lies behind: between the faces on its right and on its left.
    const Row& l = m.left[size_t(v)];
    const Tri t{number[size_t(l[2])], number[size_t(l[0])], number[size_t(l[1])]};
    if (std::min({t[0], t[1], t[2]}) >= 0) out.tri.push_back(t), out.vertex_of.push_back(v);
  }
  return out;
}

Extent extent(const Mesh& m) {
  Extent e;
  for (int32_t f = 0; f < m.face_slots(); ++f) {
    if (!m.alive_face(f)) continue;
    Vec3 c = Vec3::Zero();
    if (is_end(m.kind(f))) {
      m.around(f, [&](int32_t h) { c += m.x_mm[size_t(h / 3)] / m.face_size[size_t(f)]; });
    } else {
      c = face_centre(m, f);
    }
    m.around(f, [&](int32_t h) {
      const Vec3 &p = m.x_mm[size_t(h / 3)], &q = m.x_mm[size_t(m.to(h))];
      if (!is_end(m.kind(f))) e.area_mm2 += 0.5 * area_vector2(c, p, q).norm();
      e.volume_mm3 += c.dot(p.cross(q)) / 6;
    });
  }
  return e;
}

}  // namespace limberg::simplex
