#include "sim/lattice/embedding.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "sim/cutting/arrangement/point_store.h"
#include "sim/lattice/contradiction.h"
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

/// The vertices of a triangle that have no copy yet.
class Embedder {
 public:
  Embedder(const LatticeTopology& t, const MaterialSurface& surface, SurfaceView& view, SharedArray<EmbeddedPoint>& out)
      : t_(t),
        surface_(surface),
        view_(view),
        now_(view),
        out_(out),
        finest_(t.tree.division.empty() ? t.grid : t.grid.at_level(kLevels)) {}
  void triangle(size_t f) {
    for (int32_t v : now_.tri[f])
      if (now_.cell_copy[size_t(v)] < 0) vertex(size_t(v), now_.sided_face[f]);
  }

 private:
  void vertex(size_t v, int32_t sided) {
    const PointRef p = surface_.points->ref(now_.point[v]);
    int32_t at[3];
    for (int a = 0; a < 3; ++a) at[a] = layer_of(p, a, t_.grid.origin[a], t_.grid.pitch[a]);
    int32_t cell = t_.grid.cell_index({at[0], at[1], at[2]});
    if (t_.tree.is_divided(cell)) {
      for (int a = 0; a < 3; ++a) at[a] = layer_of(p, a, finest_.origin[a], finest_.pitch[a]);
      cell = t_.tree.find(t_.grid, kLevels, {at[0], at[1], at[2]});
    }
    const int32_t copy = copy_in(t_, cell, sided);
    if (copy < 0) throw Contradiction("a surface vertex lies in a lattice cell that does not hold its face");
    view_.cell_copy[v] = copy;
    out_.set(v, embed(t_, copy, now_.X_mm[v]));
  }
  const LatticeTopology& t_;
  const MaterialSurface& surface_;
  SurfaceView& view_;
  const SurfaceView& now_;  // view_, for reading
  SharedArray<EmbeddedPoint>& out_;
  LatticeGrid finest_;
};

/// Vertices in cells of which a copy has come apart or has got other nodes: found through the faces of the cell. A part
/// that keeps number and nodes of its copy has the vertices that it had. Vertices in cells that have been divided lose
/// their copy; triangles at them are added to `again`.
void follow_copies(const LatticeTopology& t, const LatticeTopology& before, SurfaceView& view,
                   SharedArray<EmbeddedPoint>& out, std::vector<int32_t>& again) {
  std::vector<int32_t> cells;
  for_each_change(before.cells, t.cells, [&](size_t c) { cells.push_back(t.cells[c].cell); });
  std::sort(cells.begin(), cells.end());
  cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
  const SurfaceView& now = view;
  const SharedArray<EmbeddedPoint>& embedding = out;
  std::vector<int32_t> copies;
  std::vector<uint8_t> other;
  for (int32_t cell : cells) {
    const auto& comp = t.components[size_t(cell)];
    if (!comp) continue;
    if (size_t(cell) >= before.components.size()) {  // a part of a cell that was whole
      for (size_t i = 0; i < comp->face.size() && size_t(comp->face[i]) < before.face_bits.size(); ++i)
        for (int side = 0; side < 2; ++side) {
          if (comp->of_side[i][size_t(side)] < 0) continue;
          const int32_t f = now.triangle_of[size_t(2 * comp->face[i] + side)];
          if (f < 0) throw Contradiction("a face of a lattice cell is not on the surface");
          again.push_back(f);
          for (int32_t v : now.tri[size_t(f)])
            if (const int32_t was = now.cell_copy[size_t(v)];
                was >= 0 && size_t(was) < before.cells.size() && t.tree.is_divided(before.cells[size_t(was)].cell))
              view.cell_copy[size_t(v)] = -1;
        }
      continue;
    }
    copies.clear();
    other.clear();
    bool any = false;
    for (int k = 0; k < t.copies_of(cell); ++k) {
      const int32_t copy = t.copy(cell, k);
      copies.push_back(copy);
      other.push_back(size_t(copy) >= before.cells.size() ||
                      before.cells[size_t(copy)].node != t.cells[size_t(copy)].node);
      any = any || other.back();
    }
    if (!any) continue;
    // (The corners of a face that is new are found by Embedder.)
    for (size_t i = 0; i < comp->face.size() && size_t(comp->face[i]) < before.face_bits.size(); ++i)
      for (int side = 0; side < 2; ++side) {
        const int cls = comp->of_side[i][size_t(side)];
        if (cls < 0 || !other[size_t(cls)]) continue;
        const int32_t f = now.triangle_of[size_t(2 * comp->face[i] + side)];
        if (f < 0) throw Contradiction("a face of a lattice cell is not on the surface");
        const int32_t copy = copies[size_t(cls)];
        const auto& node = t.cells[size_t(copy)].node;
        for (int32_t v : now.tri[size_t(f)]) {
          const int32_t was = now.cell_copy[size_t(v)];
          if (was < 0 || (was != copy && std::find(copies.begin(), copies.end(), was) == copies.end()))
            continue;  // elsewhere
          if (was != copy) view.cell_copy[size_t(v)] = copy;
          if (embedding[size_t(v)].node != node) out[size_t(v)].node = node;
        }
      }
  }
}

}  // namespace

SharedArray<EmbeddedPoint> embed_surface(const LatticeTopology& t, const MaterialSurface& surface, SurfaceView& view) {
  SharedArray<EmbeddedPoint> out(view.X_mm.size());
  view.cell_copy.assign(view.X_mm.size(), -1);
  Embedder rest(t, surface, view, out);
  for (size_t f = 0; f < view.tri.size(); ++f) rest.triangle(f);
  return out;
}

SharedArray<EmbeddedPoint> embed_surface(const LatticeTopology& t, const MaterialSurface& surface, SurfaceView& view,
                                         const EarlierEmbedding& before) {
  const ViewChange& change = before.change;
  if (!change.whole && t.cell_parent.same() >= before.topology.cells.size()) {
    SharedArray<EmbeddedPoint> out = before.embedding;
    view.cell_copy = before.view.cell_copy;
    out.resize(view.X_mm.size());
    view.cell_copy.resize(view.X_mm.size(), -1);
    for (int32_t v : change.vertices) view.cell_copy.set(size_t(v), -1);
    std::vector<int32_t> again;
    follow_copies(t, before.topology, view, out, again);
    Embedder rest(t, surface, view, out);
    for (int32_t f : again) rest.triangle(size_t(f));
    for (int32_t f : change.triangles) rest.triangle(size_t(f));
    return out;
  }
  // The one part of each earlier copy; none when it has come apart, or lies in the parts of a divided cell.
  constexpr int32_t kNone = -1, kSeveral = -2;
  std::vector<int32_t> part(before.topology.cells.size(), kNone);
  for (size_t c = 0; c < t.cells.size(); ++c) {
    const int32_t parent = t.cell_parent[c];
    if (parent < 0) continue;
    int32_t& p = part[size_t(parent)];
    p = p == kNone && t.cells[c].cell == before.topology.cells[size_t(parent)].cell ? int32_t(c) : kSeveral;
  }
  std::vector<int32_t> earlier = change.earlier;
  if (!change.whole) {
    earlier.assign(view.X_mm.size(), -1);
    std::iota(earlier.begin(), earlier.begin() + ptrdiff_t(std::min(earlier.size(), before.view.X_mm.size())), 0);
    for (int32_t v : change.vertices) earlier[size_t(v)] = -1;
  }
  SharedArray<EmbeddedPoint> out;
  view.cell_copy.clear();
  for (size_t v = 0; v < view.X_mm.size(); ++v) {
    const int32_t u = earlier[v];
    const int32_t copy = u < 0 ? -1 : std::max(-1, part[size_t(before.view.cell_copy[size_t(u)])]);
    view.cell_copy.push_back(copy);
    out.push_back(copy < 0 ? EmbeddedPoint{}
                           : EmbeddedPoint{t.cells[size_t(copy)].node, before.embedding[size_t(u)].w});
  }
  Embedder rest(t, surface, view, out);
  for (size_t f = 0; f < view.tri.size(); ++f) rest.triangle(f);
  return out;
}

int32_t copy_of_point(const LatticeTopology& t, const SurfaceView& view, int32_t tri, const std::array<double, 3>& bary,
                      Vec3* X_mm) {
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

EmbeddedPoint embed_point(const LatticeTopology& t, const SurfaceView& view, int32_t tri,
                          const std::array<double, 3>& bary, Vec3* X_mm) {
  Vec3 X;
  const int32_t copy = copy_of_point(t, view, tri, bary, &X);
  if (X_mm) *X_mm = X;
  return embed(t, copy, X);
}

EmbeddedPoint embed_in_copy(const LatticeTopology& t, int32_t copy, const Vec3& X_mm) { return embed(t, copy, X_mm); }

}  // namespace limberg
