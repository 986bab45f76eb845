#pragma once
// Bodies whose layers are known without a lattice: sheets between two height fields, and a ball.
#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <vector>

#include "sim/body/block.h"
#include "sim/body/body.h"

namespace limberg::test {

using Height = std::function<double(double, double)>;

struct Sheet {
  double size_mm = 60;
  int cells = 24;
  Height top, bottom;
  SurfaceTag below = SurfaceTag::fixed, sides = SurfaceTag::free;
};

/// [-size/2, size/2]^2 between the heights; the top is skin.
inline TriMesh sheet_mesh(const Sheet& s) {
  TriMesh m;
  const RestGrid g;
  const int n = s.cells + 1;
  for (int layer = 0; layer < 2; ++layer)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        const double x = s.size_mm * i / s.cells - s.size_mm / 2, y = s.size_mm * j / s.cells - s.size_mm / 2;
        m.X_mm.push_back(g.to_mm(g.to_grid({x, y, layer == 0 ? s.top(x, y) : s.bottom(x, y)})));
      }
  const auto id = [&](int layer, int i, int j) { return int32_t(layer * n * n + j * n + i); };
  const auto quad = [&](int32_t a, int32_t b, int32_t c, int32_t d, SurfaceTag tag, bool other) {
    if (other)
      m.tri.push_back({a, b, d}), m.tri.push_back({b, c, d});
    else
      m.tri.push_back({a, b, c}), m.tri.push_back({a, c, d});
    m.tag.push_back(tag), m.tag.push_back(tag);
  };
  for (int j = 0; j < s.cells; ++j)
    for (int i = 0; i < s.cells; ++i) {
      const bool other = (i + j) % 2 != 0;
      quad(id(0, i, j), id(0, i + 1, j), id(0, i + 1, j + 1), id(0, i, j + 1), SurfaceTag::skin, other);
      quad(id(1, i, j), id(1, i, j + 1), id(1, i + 1, j + 1), id(1, i + 1, j), s.below, other);
    }
  const int e = s.cells;
  for (int i = 0; i < e; ++i) {
    quad(id(0, i, 0), id(1, i, 0), id(1, i + 1, 0), id(0, i + 1, 0), s.sides, false);
    quad(id(0, i + 1, e), id(1, i + 1, e), id(1, i, e), id(0, i, e), s.sides, false);
    quad(id(0, 0, i + 1), id(1, 0, i + 1), id(1, 0, i), id(0, 0, i), s.sides, false);
    quad(id(0, e, i), id(1, e, i), id(1, e, i + 1), id(0, e, i + 1), s.sides, false);
  }
  return m;
}

/// An octahedron's triangles divided `times` times, all corners at the radius, all of it skin.
inline TriMesh ball_mesh(double radius_mm, int times, const Vec3& centre_mm) {
  std::vector<Vec3> X{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  std::vector<Tri> tri{{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  for (int t = 0; t < times; ++t) {
    std::map<std::pair<int32_t, int32_t>, int32_t> middle;
    std::vector<Tri> next;
    const auto mid = [&](int32_t a, int32_t b) {
      const auto [it, is_new] = middle.try_emplace(std::minmax(a, b), int32_t(X.size()));
      if (is_new) X.push_back((X[size_t(a)] + X[size_t(b)]).normalized());
      return it->second;
    };
    for (const Tri& c : tri) {
      const int32_t a = mid(c[0], c[1]), b = mid(c[1], c[2]), d = mid(c[2], c[0]);
      next.push_back({c[0], a, d}), next.push_back({a, c[1], b}), next.push_back({d, b, c[2]}),
          next.push_back({a, b, d});
    }
    tri = std::move(next);
  }
  TriMesh m;
  const RestGrid g;
  for (const Vec3& x : X) m.X_mm.push_back(g.to_mm(g.to_grid(radius_mm * x + centre_mm)));
  m.tri = tri;
  m.tag.assign(tri.size(), SurfaceTag::skin);
  return m;
}

/// Volume of the skin of a ball that has the polyhedron's volume.
inline double skin_of_ball_mm3(const TriMesh& m, double skin_mm) {
  double volume = 0;
  const Vec3 o = m.X_mm[0];
  for (const Tri& t : m.tri) {
    const Vec3 p = m.X_mm[size_t(t[0])] - o, q = m.X_mm[size_t(t[1])] - o, r = m.X_mm[size_t(t[2])] - o;
    volume += p.dot(q.cross(r)) / 6;
  }
  const double R = std::cbrt(volume / (4 * M_PI / 3)), in = R - skin_mm;
  return 4 * M_PI / 3 * (R * R * R - in * in * in);
}

/// Skin of 300 kPa on fat of 15 kPa. `far_lighter`: fat weighs next to nothing, so that a mass is the skin's volume.
inline Body layered(TriMesh surface, double skin_mm, bool far_lighter = false) {
  Body b;
  b.name = "layered";
  b.surface = std::move(surface);
  b.layers = {{"skin", skin_mm, {300, 0.45, 1e-6, 1, 1}}, {"fat", 10, {15, 0.45, far_lighter ? 1e-16 : 1e-6, 1, 1}}};
  b.box_min_mm = b.box_max_mm = b.surface.X_mm[0];
  for (const Vec3& X : b.surface.X_mm) b.box_min_mm = b.box_min_mm.cwiseMin(X), b.box_max_mm = b.box_max_mm.cwiseMax(X);
  return b;
}

}  // namespace limberg::test
