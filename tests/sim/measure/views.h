#pragma once
// Surfaces to measure: the uncut block as a view, and two banks of skin with a wound between them.
#include <functional>
#include <memory>

#include "sim/body/block.h"
#include "sim/cutting/arrangement/surface_view.h"

namespace limberg {

inline std::shared_ptr<Body> measured_block(const Vec3& size, double cell, const Material& skin_material = {}) {
  BlockSpec s;
  s.size_mm = size;
  s.skin_cell_mm = cell;
  s.layers = {{"skin", 1.5, skin_material}, {"fat", 8.5, {}}};
  return std::make_shared<Body>(make_block(s));
}

inline SurfaceView view_of(const Body& b) {
  SurfaceView v;
  v.X_mm = b.surface.X_mm;
  v.tri = b.surface.tri;
  v.uv = b.surface.uv;
  for (SurfaceTag t : b.surface.tag) v.kind.push_back(t == SurfaceTag::skin ? FaceKind::skin : FaceKind::fixed);
  for (size_t t = 0; t < v.tri.size(); ++t) v.origin.push_back(int32_t(t));
  return v;
}

inline std::vector<Vec3f> deformed(const SurfaceView& v, const std::function<Vec3(const Vec3&)>& map) {
  std::vector<Vec3f> x;
  for (const Vec3& X : v.X_mm) x.push_back(map(X).cast<float>());
  return x;
}

/// Two strips of skin along y, length n mm in steps of 1
/// mm, that meet at x = 0 in rest; walls 3 mm deep below
/// both rims. Vertices of the left bank come first.
inline SurfaceView two_banks(int n) {
  SurfaceView v;
  for (int side = 0; side < 2; ++side) {
    const double sign = side == 0 ? -1 : 1;
    const int32_t base = int32_t(v.X_mm.size());
    for (int j = 0; j <= n; ++j)
      for (const Vec3& p : {Vec3(sign * 5, j, 0), Vec3(0, j, 0), Vec3(0, j, -3)}) v.X_mm.push_back(p);
    const auto quad = [&](int32_t a, int32_t b, int32_t c, int32_t d, FaceKind kind) {
      for (Tri t : {Tri{a, b, c}, Tri{a, c, d}}) {
        if (side == 1) std::swap(t[1], t[2]);
        v.tri.push_back(t);
        v.kind.push_back(kind);
      }
    };
    for (int j = 0; j < n; ++j) {
      const int32_t a = base + 3 * j, b = a + 3;
      quad(a, a + 1, b + 1, b, FaceKind::skin);
      quad(a + 1, a + 2, b + 2, b + 1, FaceKind::wall);
    }
  }
  return v;
}

}  // namespace limberg
