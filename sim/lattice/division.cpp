// Divided cells: which, when, and what their parts hold.
#include <algorithm>
#include <utility>

#include "sim/base/number_set.h"
#include "sim/lattice/contradiction.h"
#include "sim/lattice/topology_parts.h"

namespace limberg {
namespace {

Int3 part_at(const CellPlace& whole, int k) {
  return {2 * whole.at.x + (k & 1), 2 * whole.at.y + (k >> 1 & 1), 2 * whole.at.z + (k >> 2 & 1)};
}

// State at the end of a step of length one along `axis` from `from` (grid indices), where the state is known.
bool walk(const LatticeGrid& grid, const MaterialSurface& surface, std::span<const int32_t> faces, Int3 from, int axis,
          bool state) {
  SubPoint a;
  for (int k = 0; k < 3; ++k)
    a[size_t(k)] = (int64_t(grid.origin[k]) + int64_t(from[k]) * grid.pitch[k]) << kSubUnitBits;
  SubPoint b = a;
  b[size_t(axis)] += int64_t(grid.pitch[axis]) << kSubUnitBits;
  std::vector<int32_t> hits;
  for (int32_t f : faces) {
    const Face& face = surface.faces[size_t(f)];
    const Plane& plane = surface.plane(f);
    const int64_t n = plane.n[size_t(axis)];
    if (!face.live() || n == 0) continue;
    const int up = n > 0 ? 1 : -1;
    if (plane_at_corner(plane, a) != -up || plane_at_corner(plane, b) != up) continue;
    const std::array<PointRef, 3> p{surface.points->ref(face.v[0]), surface.points->ref(face.v[1]),
                                    surface.points->ref(face.v[2])};
    if (CellBuilder::pierced(p, axis, a)) hits.push_back(f);
  }
  std::sort(hits.begin(), hits.end(), [&](int32_t f, int32_t g) {
    const int o = order_on_line(surface.plane(f), surface.plane(g), axis, a);
    return o ? o < 0 : f < g;
  });
  for (int32_t f : hits) {
    const int before = surface.plane(f).n[size_t(axis)] > 0 ? 1 : 0;
    const uint8_t mat = surface.faces[size_t(f)].mat;
    if (bool(mat >> before & 1) != state)
      throw Contradiction("material inside a divided cell contradicts a face's bits");
    state = mat >> (1 - before) & 1;
  }
  return state;
}

}  // namespace

const LatticeTopology::Hanging* LatticeTopology::hanging_at(int32_t node) const {
  const auto h =
      std::lower_bound(hanging.begin(), hanging.end(), node, [](const Hanging& a, int32_t n) { return a.node < n; });
  return h != hanging.end() && h->node == node ? &*h : nullptr;
}

uint8_t LatticeTopology::corners_in_material(int32_t cell) const {
  uint8_t in = 0;
  if (!tree.is_part(cell)) {
    const Int3 c = grid.cell_at(cell);
    for (int k = 0; k < 8; ++k)
      if (node_in_material[size_t(grid.node_index({c.x + (k & 1), c.y + (k >> 1 & 1), c.z + (k >> 2 & 1)}))])
        in |= uint8_t(1u << k);
    return in;
  }
  const auto& state = tree.division_with(cell).node_in_material;
  const int p = tree.which_part(cell);
  for (int k = 0; k < 8; ++k) {
    const int x = (p & 1) + (k & 1), y = (p >> 1 & 1) + (k >> 1 & 1), z = (p >> 2 & 1) + (k >> 2 & 1);
    if (state[size_t(x + 3 * y + 9 * z)]) in |= uint8_t(1u << k);
  }
  return in;
}

std::array<uint8_t, 27> classify_parts(LevelBuilders& builders, const CellPlace& place, uint8_t corners_in,
                                       std::span<const int32_t> faces) {
  const LatticeGrid grid = builders.grid().at_level(place.level + 1);
  std::array<uint8_t, 27> in{};
  for (int k = 0; k < 8; ++k) in[size_t((k & 1) * 2 + (k >> 1 & 1) * 6 + (k >> 2 & 1) * 18)] = corners_in >> k & 1;
  // Midpoints along x of known points, then along y of those, then along z.
  constexpr int stride[3] = {1, 3, 9};
  for (int axis = 0; axis < 3; ++axis)
    for (int z = 0; z < 3; ++z)
      for (int y = 0; y < 3; ++y)
        for (int x = 0; x < 3; ++x) {
          const int at[3] = {x, y, z};
          bool mine = at[axis] == 1;
          for (int later = axis + 1; later < 3; ++later) mine = mine && at[later] != 1;
          if (!mine) continue;
          const size_t i = size_t(x + 3 * y + 9 * z), from = i - size_t(stride[axis]);
          Int3 point{2 * place.at.x + x, 2 * place.at.y + y, 2 * place.at.z + z};
          (axis == 0 ? point.x : axis == 1 ? point.y : point.z) -= 1;
          in[i] = walk(grid, builders.surface(), faces, point, axis, in[from] != 0);
        }
  return in;
}

// A front keeps its cell closed. From level 2 on that is a quarter of the undivided cell, unless the crack runs askew.
static bool needs_division(CellBuilder& builder, const CellPlace& p, std::span<const int32_t> faces) {
  constexpr double kStraight = 1 + 1e-6;  // a crack along the lattice, but for rounding
  return p.level < 2 ? builder.holds_front(p.at, faces) : builder.front_reach(p.at, faces) > kStraight;
}

// Whether a blade has cut through the cell.
static bool is_wounded(const CellComponents& held, const MaterialSurface& surface) {
  return std::any_of(held.face.begin(), held.face.end(), [&](int32_t f) {
    const Face& face = surface.faces[size_t(f)];
    return face.live() && surface.orig[size_t(face.orig)].op > 0;
  });
}

/// f(cell of that level, or the undivided coarser one that holds it), for the 26 around a place.
template <class F>
static void cells_touching(const LatticeTopology& t, const CellPlace& p, const F& f) {
  const LatticeGrid g = t.grid.at_level(p.level);
  for (int k = 0; k < 27; ++k) {
    const Int3 n{p.at.x + k % 3 - 1, p.at.y + k / 3 % 3 - 1, p.at.z + k / 9 - 1};
    if (n.x < 0 || n.y < 0 || n.z < 0 || n.x >= g.count.x || n.y >= g.count.y || n.z >= g.count.z) continue;
    f(t.tree.find(t.grid, p.level, n));
  }
}

std::vector<int32_t> cells_to_divide(const LatticeTopology& t, LevelBuilders& builders,
                                     std::vector<int32_t>& candidates) {
  std::array<std::vector<int32_t>, kLevels> wanted;  // per level
  if (!t.divides()) return {};
  NumberSet known(size_t(t.tree.ids()));
  const auto want = [&](auto&& self, int32_t cell, const CellPlace& p) -> void {
    if (!known.add(cell)) return;
    wanted[size_t(p.level)].push_back(cell);
    if (p.level == 0) return;
    // All that the parts of this one will touch must be divided as often as this one is.
    cells_touching(t, p, [&](int32_t other) {
      if (classes_in(t, other) == 0) return;
      if (const CellPlace q = t.tree.place(t.grid, other); q.level < p.level) self(self, other, q);
    });
  };
  const bool zones = !t.grading.zones.empty();
  std::erase_if(candidates, [&](int32_t cell) {
    const auto& comp = t.components[size_t(cell)];
    if ((!comp && !zones) || t.tree.is_divided(cell) || classes_in(t, cell) == 0) return true;
    const CellPlace p = t.tree.place(t.grid, cell);
    const bool wounded = t.grading.wound_level > 0 && comp && is_wounded(*comp, builders.surface());
    int level = wounded ? t.grading.wound_level : 0;
    if (zones && p.level >= level) {
      const LatticeGrid g = t.grid.at_level(p.level);
      level = std::max(level, zone_level(t.grading, g.node_mm(p.at), g.node_mm({p.at.x + 1, p.at.y + 1, p.at.z + 1})));
    }
    bool wants = p.level < level;
    if (comp && !wants && p.level < t.front_levels) wants = needs_division(builders[p.level], p, comp->face);
    if (wants) return want(want, cell, p), false;
    if (wounded && p.level == t.grading.wound_level)  // what touches it is as fine
      cells_touching(t, p, [&](int32_t other) {
        if (classes_in(t, other) == 0) return;
        if (const CellPlace q = t.tree.place(t.grid, other); q.level < p.level) wants = true, want(want, other, q);
      });
    return !wants;
  });
  for (std::vector<int32_t>& list : wanted) {  // the coarsest first: what they need may not be there yet
    if (list.empty()) continue;
    std::sort(list.begin(), list.end());
    return list;
  }
  return {};
}

void divide_cells(LatticeTopology& t, LevelBuilders& builders, std::span<const int32_t> cells,
                  std::span<const uint8_t> named, NewParts& parts) {
  for (int32_t cell : cells) {
    const CellPlace place = t.tree.place(t.grid, cell);
    const uint8_t corners = t.corners_in_material(cell);
    const std::shared_ptr<const CellComponents> whole = std::as_const(t.components)[size_t(cell)];
    const bool is_named = cell >= parts.known || (size_t(cell) < named.size() && named[size_t(cell)]);
    std::span<const int32_t> faces;
    if (whole) faces = whole->face;
    const int32_t d = t.tree.divide(cell);
    parts.whole.push_back({whole, is_named});
    t.tree.division[size_t(d)].node_in_material = classify_parts(builders, place, corners, faces);
    t.components.resize(size_t(t.tree.ids()));
    t.components[size_t(cell)] = nullptr;
    CellHistory history;
    history.whole = whole.get();
    history.whole_is_named = is_named;
    for (int k = 0; k < 8 && whole; ++k) {
      const int32_t part = t.tree.part(cell, k);
      t.components[size_t(part)] =
          builders[place.level + 1].build(part_at(place, k), faces, t.corners_in_material(part), history);
      ++t.touched_cells;
    }
  }
}

// Parents of parents; a node whose ancestors are several is born.
void skip_parents(const LatticeTopology& middle, LatticeTopology& last) {
  LatticeTopology* t = &last;
  t->cell_parent = t->cell_parent.through(middle.cell_parent);
  t->touched_cells += middle.touched_cells;
  auto index = [](const LatticeTopology& v) {
    std::vector<int32_t> at(v.born.empty() ? 0 : v.nodes.size(), -1);
    for (size_t i = 0; i < v.born.size(); ++i) at[size_t(v.born[i].node)] = int32_t(i);
    return at;
  };
  if (middle.born.empty() && t->born.empty()) {
    t->node_parent = t->node_parent.through(middle.node_parent);
    return;
  }
  std::vector<int32_t> node_parent(t->nodes.size());
  const std::vector<int32_t> in_middle = index(middle), in_last = index(last);
  const std::vector<LatticeTopology::Born> born = std::move(t->born);
  t->born.clear();
  LatticeTopology::Born b;
  for (size_t n = 0; n < t->nodes.size(); ++n) {
    const int32_t of_last = t->node_parent[n];
    const int32_t own = in_last.empty() ? -1 : in_last[n];
    if (own < 0 && (in_middle.empty() || in_middle[size_t(of_last)] < 0)) {
      node_parent[n] = middle.node_parent[size_t(of_last)];
      continue;
    }
    b.node = int32_t(n);
    b.from.clear();
    auto add = [&](int32_t parent, double weight) {
      for (auto& [p, w] : b.from)
        if (p == parent) {
          w += weight;
          return;
        }
      b.from.push_back({parent, weight});
    };
    auto through = [&](int32_t mid, double weight) {
      const int32_t at = in_middle.empty() ? -1 : in_middle[size_t(mid)];
      if (at < 0)
        add(middle.node_parent[size_t(mid)], weight);
      else
        for (auto [p, w] : middle.born[size_t(at)].from) add(p, weight * w);
    };
    if (own < 0)
      through(of_last, 1);
    else
      for (auto [mid, w] : born[size_t(own)].from) through(mid, w);
    std::sort(b.from.begin(), b.from.end());
    size_t most = 0;
    for (size_t i = 1; i < b.from.size(); ++i)
      if (b.from[i].second > b.from[most].second) most = i;
    node_parent[n] = b.from[most].first;
    if (b.from.size() > 1) t->born.push_back(b);
  }
  t->node_parent = std::move(node_parent);
}

std::shared_ptr<const LatticeTopology> skip_version(const LatticeTopology& middle, const LatticeTopology& last) {
  auto t = std::make_shared<LatticeTopology>(last);
  skip_parents(middle, *t);
  return t;
}

}  // namespace limberg
