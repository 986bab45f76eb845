#include "sim/geometry/validate.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <tuple>
#include <vector>

#include "sim/base/elementary.h"
#include "sim/base/error.h"
#include "sim/base/union_find.h"
#include "sim/geometry/bvh.h"
#include "sim/geometry/grid_predicates.h"
#include "sim/geometry/triangle.h"

namespace limberg {
namespace {

struct Edge {
  int32_t a, b, triangle;  // directed a -> b
};

class Validator {
 public:
  Validator(const TriMesh& m, const RestGrid& g, const std::string& file, std::span<const int32_t> lines)
      : m_(m), g_(g), file_(file), lines_(lines) {}

  SurfaceReport run() {
    points();
    triangles();
    edges();
    fans();
    parts();
    volume();
    crossings();
    report_.genus = int((2 - (report_.vertices - report_.edges + report_.triangles)) / 2);
    return report_;
  }

 private:
  [[noreturn]] void fail(int32_t t, const Vec3& where, const std::string& what) const {
    const std::string place =
        fmt::format(" (triangle {}, at {:.3f} {:.3f} {:.3f} mm)", t + 1, where.x(), where.y(), where.z());
    throw InputError(file_, t >= 0 && size_t(t) < lines_.size() ? lines_[size_t(t)] : 0, what + place);
  }
  Vec3 corner(int32_t t, size_t k) const { return m_.X_mm[size_t(m_.tri[size_t(t)][k])]; }
  Vec3 centre(int32_t t) const { return (corner(t, 0) + corner(t, 1) + corner(t, 2)) / 3; }
  GridTriangle grid_triangle(int32_t t) const {
    const Tri& c = m_.tri[size_t(t)];
    return {p_[size_t(c[0])], p_[size_t(c[1])], p_[size_t(c[2])]};
  }

  void points() {
    if (m_.tri.empty()) throw InputError(file_, 0, "the surface has no triangles; expected a closed surface");
    p_.reserve(m_.X_mm.size());
    for (size_t i = 0; i < m_.X_mm.size(); ++i) {
      const Vec3& X = m_.X_mm[i];
      if (!X.allFinite()) throw InputError(file_, 0, "vertex " + std::to_string(i + 1) + " is not finite");
      if (!g_.fits(X) || g_.to_mm(g_.to_grid(X)) != X)
        throw InputError(file_, 0, "vertex " + std::to_string(i + 1) + " does not lie on the rest grid");
      p_.push_back(g_.to_grid(X));
    }
  }

  void triangles() {
    for (size_t t = 0; t < m_.tri.size(); ++t) {
      for (int32_t v : m_.tri[t])
        if (v < 0 || size_t(v) >= p_.size())
          throw InputError(file_, t < lines_.size() ? lines_[t] : 0,
                           "triangle " + std::to_string(t + 1) + " names vertex " + std::to_string(v + 1) + " of " +
                               std::to_string(p_.size()));
      const GridTriangle g = grid_triangle(int32_t(t));
      const auto n = grid_normal(g[0], g[1], g[2]);
      if (n[0] == 0 && n[1] == 0 && n[2] == 0)
        fail(int32_t(t), centre(int32_t(t)), "a triangle has no area; expected none degenerate");
      report_.area_mm2 +=
          0.5 * area_vector2(corner(int32_t(t), 0), corner(int32_t(t), 1), corner(int32_t(t), 2)).norm();
    }
    report_.triangles = int64_t(m_.tri.size());
  }

  void edges() {
    edge_.reserve(3 * m_.tri.size());
    for (size_t t = 0; t < m_.tri.size(); ++t)
      for (size_t k = 0; k < 3; ++k) edge_.push_back({m_.tri[t][k], m_.tri[t][(k + 1) % 3], int32_t(t)});
    std::sort(edge_.begin(), edge_.end(), [](const Edge& p, const Edge& q) {
      return std::tie(p.a, p.b, p.triangle) < std::tie(q.a, q.b, q.triangle);
    });
    for (size_t i = 1; i < edge_.size(); ++i)
      if (edge_[i].a == edge_[i - 1].a && edge_[i].b == edge_[i - 1].b)
        fail(edge_[i].triangle, middle(edge_[i]),
             "two triangles run along an edge in the same direction; expected each edge between two triangles of one "
             "orientation");
    for (const Edge& e : edge_)
      if (find(e.b, e.a) < 0) fail(e.triangle, middle(e), "the surface is open at an edge; expected a closed surface");
    report_.edges = int64_t(edge_.size() / 2);
  }

  Vec3 middle(const Edge& e) const { return 0.5 * (m_.X_mm[size_t(e.a)] + m_.X_mm[size_t(e.b)]); }

  // The triangle on the left of a -> b.
  int32_t find(int32_t a, int32_t b) const {
    const auto it =
        std::lower_bound(edge_.begin(), edge_.end(), std::pair(a, b),
                         [](const Edge& e, const std::pair<int32_t, int32_t>& k) { return std::pair(e.a, e.b) < k; });
    return it != edge_.end() && it->a == a && it->b == b ? it->triangle : -1;
  }

  // Turning around a vertex from triangle to triangle must meet all of its triangles.
  void fans() {
    std::vector<int32_t> degree(p_.size(), 0);
    for (const Tri& t : m_.tri)
      for (int32_t v : t) ++degree[size_t(v)];
    for (size_t i = 0; i < edge_.size(); ++i) {
      const int32_t v = edge_[i].a;
      if (i > 0 && edge_[i - 1].a == v) continue;
      ++report_.vertices;
      int32_t turned = 0, b = edge_[i].b;
      do {  // third corner of the triangle left of v -> b, then across
        const Tri& t = m_.tri[size_t(find(v, b))];
        size_t k = 0;
        while (t[k] != v) ++k;
        b = t[(k + 2) % 3];
        ++turned;
      } while (b != edge_[i].b && turned <= degree[size_t(v)]);
      if (turned != degree[size_t(v)])
        fail(edge_[i].triangle, m_.X_mm[size_t(v)],
             "the surface touches itself in a vertex; expected one fan of triangles around each");
    }
  }

  void parts() {
    UnionFind joined(p_.size());
    for (const Edge& e : edge_) joined.unite(e.a, e.b);
    for (size_t t = 0; t < m_.tri.size(); ++t)
      if (!joined.same(m_.tri[t][0], m_.tri[0][0]))
        fail(int32_t(t), centre(int32_t(t)), "the surface has separate parts; expected one connected surface");
  }

  void volume() {
    GridVolume six = 0;  // at most 2^22 triangles of 2^66 each
    for (const Tri& t : m_.tri) six += grid_orient3d(p_[size_t(t[0])], p_[size_t(t[1])], p_[size_t(t[2])], {0, 0, 0});
    report_.volume_mm3 = -double(six) / 6 * elementary::pow(g_.half_unit_mm(), 3);
    if (six >= 0)
      throw InputError(file_, 0,
                       "the surface is inside out (its volume is not positive); expected triangles counter-clockwise "
                       "seen from outside");
  }

  void crossings() {
    const Bvh bvh(m_.X_mm, m_.tri);
    for (int32_t t = 0; t < int32_t(m_.tri.size()); ++t) {
      const Vec3 a = corner(t, 0), b = corner(t, 1), c = corner(t, 2);
      const Vec3 lo = a.cwiseMin(b).cwiseMin(c), hi = a.cwiseMax(b).cwiseMax(c);
      int32_t worst = -1;
      bvh.box(lo, hi, [&](int32_t u) {
        if (u > t && (worst < 0 || u < worst) && grid_triangles_offend(grid_triangle(t), grid_triangle(u))) worst = u;
      });
      if (worst >= 0)
        fail(t, centre(t),
             "the surface crosses or touches itself: triangle " + std::to_string(t + 1) + " meets triangle " +
                 std::to_string(worst + 1) + "; expected a surface free of self-intersection");
    }
  }

  const TriMesh& m_;
  const RestGrid& g_;
  const std::string& file_;
  std::span<const int32_t> lines_;
  std::vector<Int3> p_;
  std::vector<Edge> edge_;
  SurfaceReport report_;
};

}  // namespace

SurfaceReport validate_surface(const TriMesh& mesh, const RestGrid& grid, const std::string& file,
                               std::span<const int32_t> line_of_triangle) {
  return Validator(mesh, grid, file, line_of_triangle).run();
}

}  // namespace limberg
