#include "sim/lattice/embedding.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "sim/cutting/point_store.h"
#include "sim/lattice/lattice_signs.h"

namespace limberg {
namespace {

EmbeddedPoint embed(const LatticeTopology& t, int32_t copy, const Vec3& X_mm) {
  const CellCopy& c = t.cells[size_t(copy)];
  const CellPlace place = t.tree.place(t.grid, c.cell);
  const LatticeGrid grid = t.grid.at_level(place.level);
  const Vec3 x = (X_mm - grid.node_mm(place.at)).cwiseQuotient(grid.cell_mm());
  EmbeddedPoint e;
  e.node = c.node;
  for (int k = 0; k < 8; ++k)
    e.w[size_t(k)] = float((k & 1 ? x[0] : 1 - x[0]) * (k & 2 ? x[1] : 1 - x[1]) * (k & 4 ? x[2] : 1 - x[2]));
  return e;
}

int32_t copy_in(const LatticeTopology& t, int32_t cell, int32_t sided_face) {
  const auto& comp = t.components[size_t(cell)];
  const int cls = comp ? comp->class_of(sided_face) : -1;
  return cls < 0 ? -1 : t.copy(cell, cls);
}

}  // namespace

int32_t cell_of(const LatticeTopology& t, const Vec3& X_mm) {
  const int level = t.tree.division.empty() ? 0 : kLevels;
  const LatticeGrid grid = t.grid.at_level(level);
  const Vec3 x = (X_mm - grid.node_mm({0, 0, 0})).cwiseQuotient(grid.cell_mm());
  int32_t c[3];
  for (int a = 0; a < 3; ++a) c[a] = int32_t(std::clamp(std::floor(x[a]), 0.0, double(grid.count[a] - 1)));
  return t.tree.find(t.grid, level, {c[0], c[1], c[2]});
}

namespace {

/// Every vertex of the view that has no copy yet.
void embed_rest(const LatticeTopology& t, const MaterialSurface& surface, SurfaceView& view,
                std::vector<EmbeddedPoint>& out) {
  const LatticeGrid finest = t.tree.division.empty() ? t.grid : t.grid.at_level(kLevels);
  for (size_t f = 0; f < view.tri.size(); ++f)
    for (int32_t v : view.tri[f]) {
      int32_t& copy = view.cell_copy[size_t(v)];
      if (copy >= 0) continue;
      const PointRef p = surface.points->ref(view.point[size_t(v)]);
      int32_t at[3];
      for (int a = 0; a < 3; ++a) at[a] = layer_of(p, a, t.grid.origin[a], t.grid.pitch[a]);
      int32_t cell = t.grid.cell_index({at[0], at[1], at[2]});
      if (t.tree.is_divided(cell)) {
        for (int a = 0; a < 3; ++a) at[a] = layer_of(p, a, finest.origin[a], finest.pitch[a]);
        cell = t.tree.find(t.grid, kLevels, {at[0], at[1], at[2]});
      }
      copy = copy_in(t, cell, view.sided_face[f]);
      if (copy < 0) throw std::logic_error("a surface vertex lies in a lattice cell that does not hold its face");
      out[size_t(v)] = embed(t, copy, view.X_mm[size_t(v)]);
    }
}

}  // namespace

std::vector<EmbeddedPoint> embed_surface(const LatticeTopology& t, const MaterialSurface& surface, SurfaceView& view) {
  std::vector<EmbeddedPoint> out(view.X_mm.size());
  view.cell_copy.assign(view.X_mm.size(), -1);
  embed_rest(t, surface, view, out);
  return out;
}

std::vector<EmbeddedPoint> embed_surface(const LatticeTopology& t, const MaterialSurface& surface, SurfaceView& view,
                                         const EarlierEmbedding& before) {
  // The one part of each earlier copy; none when it has come apart, or lies in the parts of a divided cell.
  constexpr int32_t kNone = -1, kSeveral = -2;
  std::vector<int32_t> part(before.topology.cells.size(), kNone);
  for (size_t c = 0; c < t.cells.size(); ++c) {
    const int32_t parent = t.cell_parent[c];
    if (parent < 0) continue;
    int32_t& p = part[size_t(parent)];
    p = p == kNone && t.cells[c].cell == before.topology.cells[size_t(parent)].cell ? int32_t(c) : kSeveral;
  }
  std::vector<EmbeddedPoint> out;
  out.reserve(view.X_mm.size());
  view.cell_copy.assign(view.X_mm.size(), -1);
  for (size_t v = 0; v < view.X_mm.size(); ++v) {
    const int32_t u = before.earlier[v];
    const int32_t copy = u < 0 ? -1 : part[size_t(before.view.cell_copy[size_t(u)])];
    if (copy < 0) {
      out.emplace_back();
      continue;
    }
    view.cell_copy[v] = copy;
    out.push_back({t.cells[size_t(copy)].node, before.embedding[size_t(u)].w});
  }
  embed_rest(t, surface, view, out);
  return out;
}

int32_t copy_of_point(const LatticeTopology& t, const SurfaceView& view, int32_t tri, const std::array<double, 3>& bary, Vec3* X_mm) {
  const Tri& corner = view.tri[size_t(tri)];
  Vec3 X = Vec3::Zero();
  size_t nearest = 0;
  for (size_t k = 0; k < 3; ++k) {
    X += bary[k] * view.X_mm[size_t(corner[k])];
    if (bary[k] > bary[nearest]) nearest = k;
  }
  if (X_mm) *X_mm = X;
  int32_t copy = copy_in(t, cell_of(t, X), view.sided_face[size_t(tri)]);
  // Rounding may put X just across a lattice plane, where the face is not: then a corner's cell carries it.
  if (copy < 0) copy = view.cell_copy[size_t(corner[nearest])];
  return copy;
}

EmbeddedPoint embed_point(const LatticeTopology& t, const SurfaceView& view, int32_t tri, const std::array<double, 3>& bary, Vec3* X_mm) {
  Vec3 X;
  const int32_t copy = copy_of_point(t, view, tri, bary, &X);
  if (X_mm) *X_mm = X;
  return embed(t, copy, X);
}

EmbeddedPoint embed_in_copy(const LatticeTopology& t, int32_t copy, const Vec3& X_mm) { return embed(t, copy, X_mm); }

}  // namespace limberg
