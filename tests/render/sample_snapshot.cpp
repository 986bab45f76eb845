#include "tests/render/sample_snapshot.h"

#include <cmath>
#include <map>

namespace limberg::testing {

// The slab is a voxel-like solid: columns of a square grid, some of them removed. Skin on top, walls where a column
// ends at the wound, sides at the outer border. The wound is a lens of 24 x 12 mm.
Snapshot sample_snapshot(const SampleOptions& o) {
  auto body = std::make_shared<Body>();
  body->name = "sample";
  const double half = 30, depth = 8, h = 2 * half / o.cells;
  Material m;
  body->layers = {{"skin", 1.5, m}, {"fat", 8.5, m}};
  body->chart_origin_mm = Vec3(0, 0, 0);
  body->is_box = true;
  const auto cut_out = [&](int i, int j) {
    if (!o.wound) return false;
    const double x = -half + (i + 0.5) * h, y = -half + (j + 0.5) * h;
    return std::abs(y) < 6 * (1 - x * x / 144) && std::abs(x) < 12;
  };
  const auto inside = [&](int i, int j) { return i >= 0 && j >= 0 && i < o.cells && j < o.cells && !cut_out(i, j); };

  auto topology = std::make_shared<SurfaceTopology>();
  SurfaceView& view = topology->view;
  const int levels = 8;
  SharedArray<float> depths;
  std::map<std::array<int, 3>, int32_t> index;  // grid corner and level; both banks share nothing: the wound is open
  const auto vertex = [&](int i, int j, int k) {
    const auto [it, fresh] = index.try_emplace({i, j, k}, int32_t(view.X_mm.size()));
    if (fresh) {
      view.X_mm.push_back(Vec3(-half + i * h, -half + j * h, -depth * k / levels));
      depths.push_back(float(depth * k / levels));
    }
    return it->second;
  };
  const auto quad = [&](int32_t a, int32_t b, int32_t c, int32_t d, FaceKind kind) {
    for (const Tri& t : {Tri{a, b, c}, Tri{a, c, d}}) {
      view.tri.push_back(t);
      view.uv.push_back({Eigen::Vector2f::Zero(), Eigen::Vector2f::Zero(), Eigen::Vector2f::Zero()});
      view.kind.push_back(kind);
      view.sided_face.push_back(int32_t(view.tri.size()));
      view.origin.push_back(0);
    }
  };
  for (int j = 0; j < o.cells; ++j)
    for (int i = 0; i < o.cells; ++i) {
      if (!inside(i, j)) continue;
      quad(vertex(i, j, 0), vertex(i + 1, j, 0), vertex(i + 1, j + 1, 0), vertex(i, j + 1, 0), FaceKind::skin);
      quad(vertex(i, j, levels), vertex(i, j + 1, levels), vertex(i + 1, j + 1, levels), vertex(i + 1, j, levels),
           FaceKind::fixed);
      const int di[4]{0, 1, 0, -1}, dj[4]{-1, 0, 1, 0};
      const int ends[4][4]{{0, 0, 1, 0}, {1, 0, 1, 1}, {1, 1, 0, 1}, {0, 1, 0, 0}};  // the edge, counter-clockwise
      for (int s = 0; s < 4; ++s) {
        if (inside(i + di[s], j + dj[s])) continue;
        const bool border = i + di[s] < 0 || j + dj[s] < 0 || i + di[s] >= o.cells || j + dj[s] >= o.cells;
        const int* e = ends[s];
        for (int k = 0; k < levels; ++k)
          quad(vertex(i + e[0], j + e[1], k + 1), vertex(i + e[2], j + e[3], k + 1), vertex(i + e[2], j + e[3], k),
               vertex(i + e[0], j + e[1], k), border ? FaceKind::fixed : FaceKind::wall);
      }
    }
  body->surface.X_mm = {{-half, -half, 0}, {half, -half, 0}, {half, half, 0}, {-half, half, 0}};
  body->surface.tri = {{0, 1, 2}, {0, 2, 3}};
  body->surface.tag = {SurfaceTag::skin, SurfaceTag::skin};
  topology->depth_mm = topology->layers_mm = depths;
  topology->body = body;
  topology->version = 1;
  topology->hash = 0x5a5a + uint64_t(o.wound);

  Snapshot s;
  s.topology = topology;
  s.topology_version = 1;
  for (const Vec3& X : view.X_mm) {
    const double w = o.wave_mm * std::sin(0.16 * X.x()) * std::cos(0.13 * X.y()) * (1 + X.z() / depth);
    s.x_mm.push_back(Vec3f(float(X.x()), float(X.y()), float(X.z() + w)));
    s.field.push_back(float(0.18 * std::exp(-(X.x() * X.x() + 3 * X.y() * X.y()) / 300)));
  }
  const auto height = [&](double x, double y) { return float(o.wave_mm * std::sin(0.16 * x) * std::cos(0.13 * y)); };
  for (int k = 0; k < o.sutures; ++k) {
    const double x = o.sutures > 1 ? -9 + 18.0 * k / (o.sutures - 1) : 0, y = 6 * (1 - x * x / 144);
    SutureState t;
    t.id = k + 1;
    t.a_mm = Vec3f(float(x), float(-y), height(x, -y));
    t.b_mm = Vec3f(float(x), float(y), height(x, y));
    t.force_N = 1, t.gap_mm = float(2 * y);
    s.sutures.push_back(t);
  }
  for (int k = 0; k < o.hooks; ++k) {
    HookState hook;
    hook.id = k + 1;
    hook.at_mm = Vec3f(14, 3, height(14, 3));
    hook.handle_mm = Vec3f(24, 8, 12);
    hook.force_N = Vec3f(0.3f, 0.1f, 0.4f);
    s.hooks.push_back(hook);
  }
  return s;
}

}  // namespace limberg::testing
