#pragma once
// Triangles of a surface through tetrahedra, for the grids that share them (level_set.cpp, graded_grid.cpp).
#include <algorithm>
#include <array>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "sim/geometry/triangle.h"
#include "sim/geometry/vec.h"

namespace limberg {

struct Patch {                              // of one block
  std::vector<std::array<int64_t, 6>> tri;  // three edges, each by its two nodes, lower first
};

/// The triangles of a tetrahedron of positive volume; f below 0 is inside.
inline void march_tet(const std::array<int64_t, 4>& node, const std::array<double, 4>& f, Patch& out) {
  std::array<int, 4> in{}, ex{};
  int a = 0, b = 0;
  for (int c = 0; c < 4; ++c) (f[size_t(c)] < 0 ? in[size_t(a++)] : ex[size_t(b++)]) = c;
  if (a == 0 || b == 0) return;
  const auto edge = [&](int i, int o) {
    const int64_t u = node[size_t(i)], v = node[size_t(o)];
    return std::array<int64_t, 2>{std::min(u, v), std::max(u, v)};
  };
  const auto add = [&](const std::array<int64_t, 2>& p, const std::array<int64_t, 2>& q,
                       const std::array<int64_t, 2>& r, bool turn) {
    if (turn)
      out.tri.push_back({p[0], p[1], r[0], r[1], q[0], q[1]});
    else
      out.tri.push_back({p[0], p[1], q[0], q[1], r[0], r[1]});
  };
  // Parity of (in..., ex...) as an order of the corners says which way round the outside is.
  std::array<int, 4> order{};
  for (int i = 0; i < a; ++i) order[size_t(i)] = in[size_t(i)];
  for (int i = 0; i < b; ++i) order[size_t(a + i)] = ex[size_t(i)];
  bool odd = false;
  for (size_t i = 0; i < 4; ++i)
    for (size_t j = i + 1; j < 4; ++j) odd ^= order[i] > order[j];
  // In a tetrahedron of positive volume the corners 1, 2, 3 turn clockwise as seen from corner 0.
  if (a == 1)
    add(edge(in[0], ex[0]), edge(in[0], ex[1]), edge(in[0], ex[2]), odd);
  else if (b == 1)
    add(edge(in[0], ex[0]), edge(in[1], ex[0]), edge(in[2], ex[0]), odd);
  else {
    add(edge(in[0], ex[0]), edge(in[0], ex[1]), edge(in[1], ex[1]), odd);
    add(edge(in[0], ex[0]), edge(in[1], ex[1]), edge(in[1], ex[0]), odd);
  }
}

struct EdgeHash {
  size_t operator()(const std::array<int64_t, 2>& e) const {
    return size_t(e[0]) * 0x9e3779b97f4a7c15ull ^ (size_t(e[1]) * 0xc2b2ae3d27d4eb4full >> 7);
  }
};

/// Vertices on the edges, numbered by first use. `place` of a node; `value` of a node at its place.
template <class Place, class Value>
void number_vertices(const std::vector<Patch>& patch, Place&& place, Value&& value, std::vector<Vec3>& X,
                     std::vector<Tri>& tri) {
  X.clear(), tri.clear();
  std::unordered_map<std::array<int64_t, 2>, int32_t, EdgeHash> number;  // only looked up
  const auto vertex = [&](int64_t u, int64_t v) {
    const auto [it, fresh] = number.try_emplace({u, v}, int32_t(X.size()));
    if (fresh) {
      const Vec3 a = place(u), b = place(v);
      const double fa = value(u, a), fb = value(v, b);
      X.push_back(a + std::clamp(fa / (fa - fb), 0.02, 0.98) * (b - a));
    }
    return it->second;
  };
  for (const Patch& p : patch)
    for (const auto& t : p.tri) {
      const int32_t a = vertex(t[0], t[1]), b = vertex(t[2], t[3]), c = vertex(t[4], t[5]);
      tri.push_back({a, b, c});
    }
}

}  // namespace limberg
