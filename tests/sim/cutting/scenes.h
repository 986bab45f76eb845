#pragma once
// Bodies and blades for the cutting tests, made without any of the code under test.
#include <cmath>
#include <string>
#include <vector>

#include "sim/cutting/arrangement/arrangement.h"

namespace limberg::test {

inline RestGrid grid() { return {}; }

/// A closed slab [-size/2, size/2]^2 x [-thickness, wave], `cells` per side; the skin waves by `wave_mm`.
/// Everything but the skin is tagged fixed.
inline TriMesh wavy_slab(double size, double thickness, int cells, double wave_mm) {
  TriMesh m;
  const RestGrid g = grid();
  const auto snap = [&](const Vec3& p) { return g.to_mm(g.to_grid(p)); };
  const int n = cells + 1;
  const auto height = [&](double x, double y) { return wave_mm * std::sin(0.21 * x + 0.3) * std::cos(0.17 * y - 0.2); };
  for (int layer = 0; layer < 2; ++layer)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        const double x = size * i / cells - size / 2, y = size * j / cells - size / 2;
        m.X_mm.push_back(snap({x, y, layer == 0 ? height(x, y) : -thickness}));
      }
  const auto id = [&](int layer, int i, int j) { return int32_t(layer * n * n + j * n + i); };
  const auto add = [&](int32_t a, int32_t b, int32_t c, SurfaceTag tag) {
    m.tri.push_back({a, b, c});
    m.tag.push_back(tag);
    m.uv.push_back({Eigen::Vector2f(float(m.X_mm[a].x()), float(m.X_mm[a].y())),
                    Eigen::Vector2f(float(m.X_mm[b].x()), float(m.X_mm[b].y())),
                    Eigen::Vector2f(float(m.X_mm[c].x()), float(m.X_mm[c].y()))});
  };
  for (int j = 0; j < cells; ++j)
    for (int i = 0; i < cells; ++i) {
      const int32_t a = id(0, i, j), b = id(0, i + 1, j), c = id(0, i + 1, j + 1), d = id(0, i, j + 1);
      if ((i + j) % 2 == 0)
        add(a, b, c, SurfaceTag::skin), add(a, c, d, SurfaceTag::skin);
      else
        add(a, b, d, SurfaceTag::skin), add(b, c, d, SurfaceTag::skin);
      const int32_t e = id(1, i, j), f = id(1, i + 1, j), h = id(1, i + 1, j + 1), k = id(1, i, j + 1);
      add(e, h, f, SurfaceTag::fixed), add(e, k, h, SurfaceTag::fixed);
    }
  const auto side = [&](int32_t a, int32_t b, int32_t c,
                        int32_t d) {  // a, b on top from left to right seen from outside; below d, c
    add(a, d, c, SurfaceTag::fixed), add(a, c, b, SurfaceTag::fixed);
  };
  for (int i = 0; i < cells; ++i) {
    side(id(0, i, 0), id(0, i + 1, 0), id(1, i + 1, 0), id(1, i, 0));
    side(id(0, i + 1, cells), id(0, i, cells), id(1, i, cells), id(1, i + 1, cells));
    side(id(0, 0, i + 1), id(0, 0, i), id(1, 0, i), id(1, 0, i + 1));
    side(id(0, cells, i), id(0, cells, i + 1), id(1, cells, i + 1), id(1, cells, i));
  }
  return m;
}

inline Int3 at(double x, double y, double z) { return grid().to_grid({x, y, z}); }

/// An upright strip under a polyline from z_top to z_bottom, in columns at most `step` mm apart.
inline Blade strip(const std::vector<Vec2>& path, double z_top, double z_bottom, bool closed = false,
                   double step = 1.5) {
  std::vector<Vec2> p;
  const size_t segments = closed ? path.size() : path.size() - 1;
  for (size_t i = 0; i < segments; ++i) {
    const Vec2 a = path[i], b = path[(i + 1) % path.size()];
    const int n = std::max(1, int(std::ceil((b - a).norm() / step)));
    for (int k = 0; k < n; ++k) p.push_back(a + (b - a) * (double(k) / n));
  }
  if (!closed) p.push_back(path.back());
  Blade b;
  for (const Vec2& q : p) b.vertex.push_back(at(q.x(), q.y(), z_top)), b.vertex.push_back(at(q.x(), q.y(), z_bottom));
  const size_t columns = p.size(), quads = closed ? columns : columns - 1;
  for (size_t i = 0; i < quads; ++i) {
    const int32_t tl = int32_t(2 * i), bl = tl + 1, tr = int32_t(2 * ((i + 1) % columns)), br = tr + 1;
    b.tri.push_back({tl, bl, br});
    b.tri.push_back({tl, br, tr});
  }
  b.seed.assign(b.tri.size(), 1);
  return b;
}

/// A horizontal rectangle, or any parallelogram a + s u + t v, n by m quads, all of it a seed of kind 2.
inline Blade sheet(const Vec3& a, const Vec3& u, const Vec3& v, int n, int m) {
  Blade b;
  for (int j = 0; j <= m; ++j)
    for (int i = 0; i <= n; ++i) {
      const Vec3 p = a + u * (double(i) / n) + v * (double(j) / m);
      b.vertex.push_back(at(p.x(), p.y(), p.z()));
    }
  const auto id = [&](int i, int j) { return int32_t(j * (n + 1) + i); };
  for (int j = 0; j < m; ++j)
    for (int i = 0; i < n; ++i) {
      b.tri.push_back({id(i, j), id(i + 1, j), id(i + 1, j + 1)});
      b.tri.push_back({id(i, j), id(i + 1, j + 1), id(i, j + 1)});
    }
  b.seed.assign(b.tri.size(), 2);
  return b;
}

/// Walls and floor of a convex outline as one open box; the floor is a fan about its centre.
inline Blade open_box(const std::vector<Vec2>& outline, double z_top, double z_bottom) {
  Blade b = strip(outline, z_top, z_bottom, true);
  const int32_t columns = int32_t(b.vertex.size() / 2), centre = int32_t(b.vertex.size());
  Vec2 c = Vec2::Zero();
  for (const Vec2& p : outline) c += p / double(outline.size());
  b.vertex.push_back(at(c.x(), c.y(), z_bottom));
  for (int32_t i = 0; i < columns; ++i) b.tri.push_back({2 * i + 1, 2 * ((i + 1) % columns) + 1, centre});
  b.seed.assign(b.tri.size(), 2);
  return b;
}

/// V - E + F of every component, in their order.
inline std::vector<int> euler(const Arrangement& a) {
  const SurfaceView view = a.surface_view();
  std::vector<int> chi(a.components().size(), 0), faces(a.components().size(), 0);
  std::vector<int32_t> of(view.X_mm.size(), -1);
  for (size_t i = 0; i < view.tri.size(); ++i) {
    const int32_t component = a.component_of(view.sided_face[i]);
    ++faces[size_t(component)];
    for (int32_t v : view.tri[i]) of[size_t(v)] = component;
  }
  for (int32_t c : of) ++chi[size_t(c)];
  for (size_t c = 0; c < chi.size(); ++c) chi[c] -= faces[c] / 2;
  return chi;
}

}  // namespace limberg::test
