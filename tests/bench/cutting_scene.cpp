#include "tests/bench/cutting_scene.h"

#include <cmath>

namespace limberg::bench {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kSide = 200, kThickness = 20;  // mm

double skin_height(double x, double y) { return 1.5 * std::sin(0.11 * x + 0.3) * std::cos(0.09 * y - 0.2); }

}  // namespace

Body wavy_slab(int cells) {
  Body b;
  b.name = "slab";
  const int n = cells + 1;
  const auto at = [&](double x, double y, double z) { return b.grid.to_mm(b.grid.to_grid({x, y, z})); };
  TriMesh& m = b.surface;
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const double x = kSide * i / cells - kSide / 2, y = kSide * j / cells - kSide / 2;
      m.X_mm.push_back(at(x, y, skin_height(x, y)));
    }
  std::vector<int32_t> rim;  // of the skin, counter-clockwise seen from above
  const auto id = [n](int i, int j) { return int32_t(j * n + i); };
  for (int i = 0; i < cells; ++i) rim.push_back(id(i, 0));
  for (int j = 0; j < cells; ++j) rim.push_back(id(cells, j));
  for (int i = cells; i > 0; --i) rim.push_back(id(i, cells));
  for (int j = cells; j > 0; --j) rim.push_back(id(0, j));
  const int32_t below = int32_t(m.X_mm.size());
  for (int32_t r : rim) m.X_mm.push_back(at(m.X_mm[size_t(r)].x(), m.X_mm[size_t(r)].y(), -kThickness));
  m.X_mm.push_back(at(0, 0, -kThickness));
  const auto add = [&](int32_t u, int32_t v, int32_t w, SurfaceTag tag) {
    m.tri.push_back({u, v, w});
    m.tag.push_back(tag);
    std::array<Eigen::Vector2f, 3> uv;
    const std::array<int32_t, 3> corner{u, v, w};
    for (size_t k = 0; k < 3; ++k) uv[k] = (m.X_mm[size_t(corner[k])].head<2>() / kSide).cast<float>();
    m.uv.push_back(uv);
  };
  for (int j = 0; j < cells; ++j)
    for (int i = 0; i < cells; ++i) {
      const int32_t p = id(i, j), q = id(i + 1, j), r = id(i + 1, j + 1), s = id(i, j + 1);
      if ((i + j) % 2 == 0)
        add(p, q, r, SurfaceTag::skin), add(p, r, s, SurfaceTag::skin);
      else
        add(p, q, s, SurfaceTag::skin), add(q, r, s, SurfaceTag::skin);
    }
  const int32_t around = int32_t(rim.size()), centre = below + around;
  for (int32_t i = 0; i < around; ++i) {
    const int32_t next = (i + 1) % around, p = rim[size_t(i)], q = rim[size_t(next)];
    add(p, below + i, below + next, SurfaceTag::fixed);
    add(p, below + next, q, SurfaceTag::fixed);
    add(below + next, below + i, centre, SurfaceTag::fixed);
  }
  Layer skin, fat;
  skin.name = "skin", skin.thickness_mm = 2.5;
  skin.material.prestretch_along = 1.1, skin.material.prestretch_across = 1.05;
  fat.name = "fat", fat.thickness_mm = 20;
  fat.material.young_kPa = 18;
  b.layers = {skin, fat};
  b.box_min_mm = b.box_max_mm = m.X_mm[0];
  for (const Vec3& x : m.X_mm) b.box_min_mm = b.box_min_mm.cwiseMin(x), b.box_max_mm = b.box_max_mm.cwiseMax(x);
  return b;
}

Blade curved_blade(const Body& body, const BladePlace& place) {
  Blade blade;
  const double angle = place.angle_deg * kPi / 180;
  const Vec2 along(std::cos(angle), std::sin(angle)), across(-along.y(), along.x());
  for (int i = 0; i <= place.columns; ++i) {
    const double t = double(i) / place.columns - 0.5;
    const Vec2 p =
        place.middle + along * (t * place.length_mm) + across * (place.bend_mm * std::sin(2 * kPi * t + 0.4));
    const double skin = skin_height(p.x(), p.y());
    blade.vertex.push_back(body.grid.to_grid({p.x(), p.y(), skin + 1}));
    blade.vertex.push_back(body.grid.to_grid({p.x(), p.y(), skin - place.depth_mm}));
  }
  for (int32_t i = 0; i < place.columns; ++i) {
    const int32_t p = 2 * i;
    blade.tri.push_back({p, p + 1, p + 3});
    blade.tri.push_back({p, p + 3, p + 2});
  }
  blade.seed.assign(blade.tri.size(), 1);
  return blade;
}

}  // namespace limberg::bench
