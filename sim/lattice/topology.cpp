#include "sim/lattice/topology.h"

#include <algorithm>
#include <stdexcept>

#include "sim/error.h"
#include "sim/lattice/topology_parts.h"

namespace limberg {
namespace {

uint8_t bits_of(const Face& f) { return f.live() ? f.mat : uint8_t(0); }

void fill_face_bits(LatticeTopology& t, const MaterialSurface& surface) {
  t.face_bits.resize(surface.faces.size());
  for (size_t f = 0; f < surface.faces.size(); ++f) t.face_bits[f] = bits_of(surface.faces[f]);
  t.last_op = surface.orig.empty() ? 0 : surface.orig.back().op;
}

/// Calls visit(cell) for the cells of the box of a face's corners.
template <class Visit>
void cells_around(const LatticeGrid& grid, const CellBuilder& builder, int32_t face, Visit&& visit) {
  const auto q = builder.layers(face);
  int32_t lo[3], hi[3];
  for (size_t a = 0; a < 3; ++a) {
    lo[a] = std::max(0, std::min({q[0][a], q[1][a], q[2][a]}));
    hi[a] = std::min(grid.count[int(a)] - 1, std::max({q[0][a], q[1][a], q[2][a]}));
  }
  for (int32_t z = lo[2]; z <= hi[2]; ++z)
    for (int32_t y = lo[1]; y <= hi[1]; ++y)
      for (int32_t x = lo[0]; x <= hi[0]; ++x) visit(grid.cell_index({x, y, z}));
}

void relink(LatticeTopology& t, const LatticeTopology* previous, std::span<const uint8_t> touched) {
  const int32_t cells = int32_t(t.components.size());
  const int32_t stride[3] = {1, t.grid.count.x, t.grid.count.x * t.grid.count.y};
  auto neighbour = [&](int32_t cell, int axis) {
    return t.grid.cell_at(cell)[axis] + 1 < t.grid.count[axis] ? cell + stride[axis] : -1;
  };
  std::vector<LatticeTopology::Link> fresh;
  for (int32_t cell = 0; cell < cells; ++cell)
    for (int axis = 0; axis < 3; ++axis) {
      const int32_t next = neighbour(cell, axis);
      if (next < 0 || (previous && !touched[size_t(cell)] && !touched[size_t(next)])) continue;
      find_links(t, cell, axis, fresh);
    }
  t.links.clear();
  if (previous) {
    t.links.reserve(previous->links.size() + fresh.size());
    for (const auto& l : previous->links) {
      const int32_t cell = l.cell_axis / 3;
      if (!touched[size_t(cell)] && !touched[size_t(cell + stride[l.cell_axis % 3])]) t.links.push_back(l);
    }
  }
  const size_t kept = t.links.size();
  t.links.insert(t.links.end(), fresh.begin(), fresh.end());
  std::sort(t.links.begin() + ptrdiff_t(kept), t.links.end());
  std::inplace_merge(t.links.begin(), t.links.begin() + ptrdiff_t(kept), t.links.end());
}

void finish(LatticeTopology& t, const LatticeTopology* previous, std::span<const uint8_t> touched) {
  number_copies(t, previous, touched);
  relink(t, previous, touched);
  if (previous) name_parents_by_neighbours(t, *previous);
  number_nodes(t, previous);
  summarise(t);
}

}  // namespace

std::shared_ptr<const LatticeTopology> build_topology(const LatticeGrid& grid, const MaterialSurface& surface) {
  auto t = std::make_shared<LatticeTopology>();
  t->grid = grid;
  t->node_in_material = classify_nodes(grid, surface);
  fill_face_bits(*t, surface);
  CellBuilder builder(grid, surface);
  const size_t cells = size_t(grid.count.x) * size_t(grid.count.y) * size_t(grid.count.z);
  // Candidates of each cell, by counting sort: faces stay ascending.
  std::vector<int32_t> begin(cells + 1, 0), list;
  for (int pass = 0; pass < 2; ++pass) {
    for (size_t f = 0; f < surface.faces.size(); ++f)
      if (surface.faces[f].live())
        cells_around(grid, builder, int32_t(f), [&](int32_t c) {
          if (pass == 0)
            ++begin[size_t(c) + 1];
          else
            list[size_t(begin[size_t(c)]++)] = int32_t(f);
        });
    if (pass == 0) {
      for (size_t c = 0; c < cells; ++c) begin[c + 1] += begin[c];
      list.resize(size_t(begin[cells]));
    }
  }
  t->components.resize(cells);
  for (size_t c = 0; c < cells; ++c) {
    const int32_t from = c ? begin[c - 1] : 0, to = begin[c];  // the second pass has moved each begin to its end
    if (from == to) continue;
    t->components[c] = builder.build(int32_t(c), {list.data() + from, size_t(to - from)}, t->node_in_material, {});
    ++t->touched_cells;
  }
  finish(*t, nullptr, {});
  return t;
}

std::shared_ptr<const LatticeTopology> update_topology(const LatticeTopology& previous,
                                                       const MaterialSurface& surface) {
  auto t = std::make_shared<LatticeTopology>();
  const LatticeGrid& grid = t->grid = previous.grid;
  fill_face_bits(*t, surface);
  CellBuilder builder(grid, surface);

  // What has changed, where.
  const size_t before = previous.face_bits.size(), now = t->face_bits.size(), cells = previous.components.size();
  std::vector<uint8_t> touched(cells, 0);
  std::vector<std::pair<int32_t, int32_t>> added;  // cell, face
  bool taken_away = false;
  for (size_t f = 0; f < std::max(before, now); ++f) {
    const uint8_t was = f < before ? previous.face_bits[f] : uint8_t(0), is = f < now ? t->face_bits[f] : uint8_t(0);
    if (f >= now) throw std::logic_error("the surface has lost faces since the lattice's last version");
    if (was == is) continue;
    // Material is gone where a face has lost a side, or a new wall has only one.
    taken_away = taken_away || (!surface.faces[f].retired && (was & ~is));
    taken_away =
        taken_away || (f >= before && is != 3 && surface.orig[size_t(surface.faces[f].orig)].op > previous.last_op);
    cells_around(grid, builder, int32_t(f), [&](int32_t c) {
      touched[size_t(c)] = 1;
      if (is && !was) added.push_back({c, int32_t(f)});
    });
  }
  std::sort(added.begin(), added.end());
  if (taken_away)
    t->node_in_material = classify_nodes(grid, surface);
  else
    t->node_in_material = previous.node_in_material;

  t->components = previous.components;
  std::vector<int32_t> candidates;
  size_t next = 0;
  for (size_t c = 0; c < cells; ++c) {
    if (!touched[c]) continue;
    ++t->touched_cells;
    candidates.clear();
    const CellComponents* old = previous.components[c].get();
    if (old) candidates = old->face;
    while (next < added.size() && added[next].first < int32_t(c)) ++next;
    for (; next < added.size() && added[next].first == int32_t(c); ++next) candidates.push_back(added[next].second);
    std::sort(candidates.begin(), candidates.end());
    t->components[c] =
        builder.build(int32_t(c), candidates, t->node_in_material, {true, old, previous.last_op, !taken_away});
  }
  if (taken_away)  // full cells that are empty now
    for (size_t c = 0; c < cells; ++c) {
      if (previous.components[c] || touched[c]) continue;
      const size_t n = size_t(grid.node_index(grid.cell_at(int32_t(c))));
      if (previous.node_in_material[n] != t->node_in_material[n]) touched[c] = 1;
    }
  finish(*t, &previous, touched);
  return t;
}

}  // namespace limberg
