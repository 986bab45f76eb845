#include "sim/skull/bone/wall.h"

#include <algorithm>
#include <limits>

namespace limberg::bone {
namespace {

using simplex::Edit;
using simplex::FaceKind;
using simplex::Mesh;
using simplex::Row;
using VertexRing = std::vector<int32_t>;

constexpr double kFromEnds = 0.2;  // a rung stays this share of the edge away from its ends: no sliver of a face

struct OnEdge {
  double squared;
  Vec3 place;
};

OnEdge nearest_on(const Vec3& a, const Vec3& b, const Vec3& p) {
  const Vec3 d = b - a;
  const double l = d.squaredNorm(), s = l > 0 ? std::clamp(d.dot(p - a) / l, kFromEnds, 1 - kFromEnds) : 0.5;
  const Vec3 at = a + s * d;
  return {(at - p).squaredNorm(), at};
}

/// For every place p of `from` an edge of `ring`, all different and in order, with the least sum of squares. The first
/// goes to its nearest edge. from.size() <= ring.size().
std::vector<int32_t> assign(const std::vector<Vec3>& from, const std::vector<Vec3>& ring) {
  const size_t n = from.size(), m = ring.size();
  const auto cost = [&](size_t k, size_t e) { return nearest_on(ring[e % m], ring[(e + 1) % m], from[k]).squared; };
  size_t first = 0;
  for (size_t e = 1; e < m; ++e)
    if (cost(0, e) < cost(0, first)) first = e;
  // best[k][e]: places 0..k on edges up to first + e, place k on edge first + e.
  constexpr double inf = std::numeric_limits<double>::infinity();
  std::vector<double> best(n * m, inf);
  std::vector<int32_t> from_edge(n * m, -1);
  best[0] = cost(0, first);
  for (size_t k = 1; k < n; ++k) {
    double low = inf;
    int32_t at = -1;
    for (size_t e = k; e < m; ++e) {
      if (best[(k - 1) * m + e - 1] < low) low = best[(k - 1) * m + e - 1], at = int32_t(e - 1);
      if (low < inf) best[k * m + e] = low + cost(k, first + e), from_edge[k * m + e] = at;
    }
  }
  size_t end = n - 1;
  for (size_t e = n - 1; e < m; ++e)
    if (best[(n - 1) * m + e] < best[(n - 1) * m + end]) end = e;
  std::vector<int32_t> edge(n);
  for (size_t k = n, e = end; k-- > 0;) {
    edge[k] = int32_t((first + e) % m);
    if (k > 0) e = size_t(from_edge[k * m + e]);
  }
  return edge;
}

/// One side: rings in face order, rungs in the order of x's ring.
struct Side {
  int32_t x, y;
  VertexRing ring_x, ring_y;
  std::vector<Rung> rungs;
};

std::string join(Mesh& m, const Side& s, simplex::Delta& delta, std::vector<int32_t>& walls) {
  const size_t k = s.rungs.size(), nx = s.ring_x.size(), ny = s.ring_y.size();
  // Everything that lies behind the rings: each face once, else a wall would share two edges with it.
  VertexRing behind;
  for (const VertexRing* ring : {&s.ring_x, &s.ring_y})
    for (size_t i = 0; i < ring->size(); ++i)
      behind.push_back(m.face(m.edge((*ring)[(i + 1) % ring->size()], (*ring)[i])));
  {
    // Of one wall only: the same face may lie behind two walls.
    for (size_t r = 0; r < k; ++r) {
      const Rung &a = s.rungs[r], &b = s.rungs[(r + 1) % k];
      VertexRing beside;
      for (size_t i = size_t(a.a);; i = (i + 1) % nx) {
        beside.push_back(behind[i]);
        if (i == size_t(b.a)) break;
      }
      for (size_t j = size_t(b.b);; j = (j + 1) % ny) {
        beside.push_back(behind[nx + j]);
        if (j == size_t(a.b)) break;
      }
      std::sort(beside.begin(), beside.end());
      if (std::adjacent_find(beside.begin(), beside.end()) != beside.end())
        return "the bone is too thin for its mesh there: one face reaches both tables";
    }
  }
  Edit e(m, delta);
  VertexRing p(k), q(k);
  for (size_t r = 0; r < k; ++r) {
    p[r] = e.add_vertex(s.ring_x[size_t(s.rungs[r].a)]), q[r] = e.add_vertex(s.ring_y[size_t(s.rungs[r].b)]);
    m.x_mm[size_t(p[r])] = m.before_mm[size_t(p[r])] = s.rungs[r].a_mm;
    m.x_mm[size_t(q[r])] = m.before_mm[size_t(q[r])] = s.rungs[r].b_mm;
  }
  for (size_t r = 0; r < k; ++r) {
    const size_t i = size_t(s.rungs[r].a), j = size_t(s.rungs[r].b);
    const int32_t x0 = s.ring_x[i], x1 = s.ring_x[(i + 1) % nx], y0 = s.ring_y[j], y1 = s.ring_y[(j + 1) % ny];
    e.replace_neighbour(x0, x1, p[r]), e.replace_neighbour(x1, x0, p[r]);
    e.replace_neighbour(y0, y1, q[r]), e.replace_neighbour(y1, y0, q[r]);
    m.nbr[size_t(p[r])] = {q[r], x0, x1}, m.nbr[size_t(q[r])] = {p[r], y0, y1};
  }
  e.free_face(s.y), e.free_face(s.x);
  std::vector<uint8_t> on_x(nx, 0), on_y(ny, 0);
  for (size_t r = 0; r < k; ++r) {
    on_x[size_t(s.rungs[r].a)] = on_y[size_t(s.rungs[r].b)] = 1;
    e.mark_face(behind[size_t(s.rungs[r].a)], m.edge(p[r], s.ring_x[size_t(s.rungs[r].a)]));
    e.mark_face(behind[nx + size_t(s.rungs[r].b)], m.edge(q[r], s.ring_y[size_t(s.rungs[r].b)]));
  }
  walls.clear();
  for (size_t r = 0; r < k; ++r) {
    walls.push_back(e.add_face(FaceKind::wall));
    e.mark_face(walls.back(), m.edge(p[r], s.ring_x[size_t(s.rungs[r].a + 1) % nx]));
  }
  for (const VertexRing* ring :
       {&s.ring_x, &s.ring_y, static_cast<const VertexRing*>(&p), static_cast<const VertexRing*>(&q)})
    for (int32_t v : *ring) e.reshape(v);
  ++m.version;
  return "";
}

VertexRing reversed(VertexRing r) {
  std::reverse(r.begin(), r.end());
  return r;
}

}  // namespace

std::vector<Rung> plan_rungs(const std::vector<Vec3>& x, const std::vector<Vec3>& y) {
  const size_t nx = x.size(), ny = y.size();
  // y against its order: edge b' of the turned ring is edge ny - 2 - b' of y.
  std::vector<Vec3> turned(y.rbegin(), y.rend());
  const bool x_short = nx <= ny;
  const std::vector<Vec3>&few = x_short ? x : turned, &many = x_short ? turned : x;
  std::vector<Vec3> middle(few.size());
  for (size_t k = 0; k < few.size(); ++k) middle[k] = 0.5 * (few[k] + few[(k + 1) % few.size()]);
  const std::vector<int32_t> edge = assign(middle, many);
  std::vector<Rung> rungs(few.size());
  for (size_t k = 0; k < few.size(); ++k) {
    const size_t e = size_t(edge[k]);
    const Vec3 there = nearest_on(many[e], many[(e + 1) % many.size()], middle[k]).place;
    const int32_t a = x_short ? int32_t(k) : edge[k], b = x_short ? edge[k] : int32_t(k);
    rungs[k] = {a, int32_t((2 * ny - 2 - size_t(b)) % ny), x_short ? middle[k] : there, x_short ? there : middle[k]};
  }
  std::sort(rungs.begin(), rungs.end(), [](const Rung& r, const Rung& s) { return r.a < s.a; });
  return rungs;
}

std::string join_by_walls(Mesh& m, const Facing& x, const Facing& y, const std::vector<Rung>& rungs,
                          simplex::Delta& delta, std::vector<Facing>& walls) {
  walls.clear();
  if (rungs.size() < 3)
    return "the tables of the bone cannot be joined there: fewer than three lines between them are free";
  const int32_t nx = int32_t(x.right.size()), ny = int32_t(y.right.size());
  std::vector<int32_t> right, left;
  if (std::string bad = join(m, {x.face_right, y.face_right, x.right, y.right, rungs}, delta, right); !bad.empty())
    return bad;
  // The other side runs backwards: edge a of `right` is edge n - 2 - a there.
  std::vector<Rung> back(rungs.rbegin(), rungs.rend());
  for (Rung& r : back) r.a = (2 * nx - 2 - r.a) % nx, r.b = (2 * ny - 2 - r.b) % ny;
  std::rotate(back.begin(),
              std::min_element(back.begin(), back.end(), [](const Rung& r, const Rung& s) { return r.a < s.a; }),
              back.end());
  if (std::string bad = join(m, {x.face_left, y.face_left, reversed(x.left), reversed(y.left), back}, delta, left);
      !bad.empty())
    return bad;
  for (int32_t f : right) {
    Facing w;
    w.face_right = f, w.right = m.ring(f);
    const Vec3 start = m.x_mm[size_t(w.right[0])], second = m.x_mm[size_t(w.right[1])];
    for (int32_t g : left) {
      VertexRing ring = reversed(m.ring(g));
      const auto at = std::find_if(ring.begin(), ring.end(), [&](int32_t v) { return m.x_mm[size_t(v)] == start; });
      if (at == ring.end()) continue;
      std::rotate(ring.begin(), at, ring.end());
      if (m.x_mm[size_t(ring[1])] != second || ring.size() != w.right.size()) continue;
      w.face_left = g, w.left = std::move(ring);
      break;
    }
    walls.push_back(std::move(w));
  }
  return "";
}

void close_by_walls(Mesh& m, const Facing& mouth, simplex::Delta& delta) {
  Edit e(m, delta);
  for (int32_t f : {mouth.face_left, mouth.face_right}) {
    e.save_face(f);
    m.face_kind[size_t(f)] = FaceKind::wall;
  }
  ++m.version;
}

std::array<Facing, 2> divide_wall(Mesh& m, const Facing& wall, const Rung& at, simplex::Delta& delta) {
  const size_t n = wall.right.size(), a = size_t(at.a), b = size_t(at.b);
  Edit e(m, delta);
  std::array<Facing, 2> out;
  // Each side: new vertices p on edge a, q on edge b, and the edge between them. `ring` runs as the face on the right.
  const auto side = [&](const VertexRing& ring, int32_t face, bool right) {
    const int32_t a0 = ring[a], a1 = ring[(a + 1) % n], b0 = ring[b], b1 = ring[(b + 1) % n];
    const int32_t behind_a = m.face(right ? m.edge(a1, a0) : m.edge(a0, a1)),
                  behind_b = m.face(right ? m.edge(b1, b0) : m.edge(b0, b1));
    const int32_t p = e.add_vertex(a0), q = e.add_vertex(b0);
    m.x_mm[size_t(p)] = m.before_mm[size_t(p)] = at.a_mm, m.x_mm[size_t(q)] = m.before_mm[size_t(q)] = at.b_mm;
    for (const auto& [x, y, v] : {std::array{a0, a1, p}, std::array{b0, b1, q}})
      e.replace_neighbour(x, y, v), e.replace_neighbour(y, x, v);
    // Counter-clockwise from outside: a ring that runs as its face has it on its left.
    m.nbr[size_t(p)] = right ? Row{q, a0, a1} : Row{q, a1, a0};
    m.nbr[size_t(q)] = right ? Row{p, b0, b1} : Row{p, b1, b0};
    const int32_t after = e.add_face(FaceKind::wall);
    e.mark_face(behind_a, right ? m.edge(p, a0) : m.edge(a0, p));
    e.mark_face(behind_b, right ? m.edge(q, b0) : m.edge(b0, q));
    // What lies after a: p, a1, ..., b0, q.
    e.mark_face(after, right ? m.edge(p, a1) : m.edge(a1, p));
    e.mark_face(face, right ? m.edge(q, b1) : m.edge(b1, q));
    VertexRing first{p}, rest{q};
    for (size_t i = a + 1; i <= b; ++i) first.push_back(ring[i]);
    first.push_back(q);
    for (size_t i = b + 1; i <= a + n; ++i) rest.push_back(ring[i % n]);
    rest.push_back(p);
    for (const VertexRing* r : {&first, &rest})
      for (const int32_t v : *r) e.reshape(v);
    (right ? out[0].face_right : out[0].face_left) = after, (right ? out[1].face_right : out[1].face_left) = face;
    (right ? out[0].right : out[0].left) = std::move(first), (right ? out[1].right : out[1].left) = std::move(rest);
  };
  side(wall.right, wall.face_right, true);
  side(wall.left, wall.face_left, false);
  ++m.version;
  return out;
}

}  // namespace limberg::bone
