// Cell copies and the links between them.
#include <algorithm>
#include <stdexcept>
#include <utility>

#include "sim/base/hash.h"
#include "sim/lattice/contradiction.h"
#include "sim/lattice/topology_parts.h"

namespace limberg {
namespace {

int class_of_corner(const LatticeTopology& t, int32_t cell, int corner) {
  if (const auto& c = t.components[size_t(cell)]) return c->of_corner[size_t(corner)];
  return classes_in(t, cell) - 1;
}

}  // namespace

int classes_in(const LatticeTopology& t, int32_t cell) {
  if (const auto& c = t.components[size_t(cell)]) return int(c->classes.size());
  if (t.tree.is_divided(cell)) return 0;
  if (t.tree.is_part(cell)) return t.corners_in_material(cell) & 1;
  return t.node_in_material[size_t(t.grid.node_index(t.grid.cell_at(cell)))] ? 1 : 0;
}

int Descent::class_before(int32_t part, int cls) const {
  if (const auto& c = t_.components[size_t(part)]) return c->classes[size_t(cls)].old_class;
  // A full part: it has a corner of what it is a part of.
  for (;;) {
    const int32_t division = (part - t_.tree.grid_cells) / 8;
    const int32_t owner = t_.tree.owner(part);
    const NewParts::Whole& whole = parts_.whole[size_t(division - (parts_.known - t_.tree.grid_cells) / 8)];
    if (whole.held) {
      const int16_t mine = whole.held->of_corner[size_t(t_.tree.which_part(part))];
      return whole.named ? whole.held->classes[size_t(mine)].old_class : mine;
    }
    if (!is_new(owner)) return 0;
    part = owner;
  }
}

void number_copies(LatticeTopology& t, const LatticeTopology* previous, std::span<const uint8_t> touched,
                   const NewParts& parts) {
  const int32_t cells = int32_t(t.components.size());
  const auto& components = std::as_const(t.components);
  const Descent descent(t, parts);
  std::vector<int32_t> begin(size_t(cells) + 1, 0);
  for (int32_t c = 0; c < cells; ++c) begin[size_t(c) + 1] = begin[size_t(c)] + classes_in(t, c);
  const auto classes = [&](int32_t c) { return begin[size_t(c) + 1] - begin[size_t(c)]; };
  std::vector<int32_t> id_of(size_t(begin.back()), -1);
  t.cells.clear();
  t.cells.reserve(id_of.size());
  std::vector<int32_t> parents;
  parents.reserve(id_of.size());
  auto make = [&](int32_t cell, int cls, int32_t parent) {
    int32_t& id = id_of[size_t(begin[size_t(cell)] + cls)];
    if (id >= 0) return;
    id = int32_t(t.cells.size());
    CellCopy copy;
    copy.cell = cell;
    const auto& comp = components[size_t(cell)];
    copy.fraction = comp ? comp->classes[size_t(cls)].fraction : 1;
    t.cells.push_back(copy);
    parents.push_back(parent);
  };
  const int32_t known = previous ? int32_t(previous->components.size()) : cells;
  auto old_class = [&](int32_t cell, int cls) -> int {
    const auto& comp = components[size_t(cell)];
    return touched[size_t(cell)] && comp ? comp->classes[size_t(cls)].old_class : cls;
  };
  const auto parent_of_part = [&](int32_t cell, int cls) {
    const int old = descent.class_before(cell, cls);
    return old < 0 ? -1 : previous->copy(descent.cell_before(cell), old);
  };
  if (previous) {
    // The first part of every copy that has been divided.
    std::vector<std::pair<int32_t, int32_t>> first_part;  // cell and class, per copy of before
    if (!parts.empty()) first_part.assign(previous->cells.size(), {-1, 0});
    for (int32_t c = known; c < cells; ++c)
      for (int k = 0; k < classes(c); ++k)
        if (const int32_t p = parent_of_part(c, k); p >= 0 && first_part[size_t(p)].first < 0)
          first_part[size_t(p)] = {c, k};
    // Class of a previous copy: its place among the copies of its cell.
    std::vector<int32_t> class_of_copy(previous->cells.size());
    for (int32_t c = 0; c < known; ++c)
      for (int k = 0; k < previous->copies_of(c); ++k) class_of_copy[size_t(previous->copy(c, k))] = k;
    for (size_t p = 0; p < previous->cells.size(); ++p) {
      const int32_t cell = previous->cells[p].cell;
      if (!parts.empty() && first_part[p].first >= 0) make(first_part[p].first, first_part[p].second, int32_t(p));
      for (int k = 0; k < classes(cell); ++k)
        if (old_class(cell, k) == class_of_copy[p]) {
          make(cell, k, int32_t(p));
          break;
        }
    }
  }
  for (int32_t c = 0; c < cells; ++c)
    for (int k = 0; k < classes(c); ++k) {
      if (id_of[size_t(begin[size_t(c)] + k)] >= 0) continue;
      int32_t parent = -1;
      if (c >= known)
        parent = parent_of_part(c, k);
      else if (const int old = previous ? old_class(c, k) : -1; old >= 0)
        parent = previous->copy(c, old);
      make(c, k, parent);
    }
  t.cell_parent = std::move(parents);
  t.copies = ShortLists(size_t(cells));
  for (int32_t c = 0; c < cells; ++c)
    t.copies.set(size_t(c), std::span(id_of).subspan(size_t(begin[size_t(c)]), size_t(classes(c))));
}

void cells_beyond(const LatticeTopology& t, int32_t cell, int axis, std::vector<int32_t>& out, bool high) {
  out.clear();
  const CellPlace p = t.tree.place(t.grid, cell);
  Int3 at = p.at;
  int32_t& along = axis == 0 ? at.x : axis == 1 ? at.y : at.z;
  along += high ? 1 : -1;
  if (along < 0 || along >= t.grid.count[axis] << p.level) return;
  const int32_t next = t.tree.find(t.grid, p.level, at);
  if (!t.tree.is_divided(next)) {
    out.push_back(next);
    return;
  }
  for (int k = 0; k < 8; ++k) {
    if (bool(k & kLowToHigh[axis]) == high) continue;
    out.push_back(t.tree.part(next, k));
    if (t.tree.is_divided(out.back())) throw std::logic_error("neighbouring cells differ by more than one level");
  }
}

void find_links(const LatticeTopology& t, LevelBuilders& builders, int32_t cell, int axis, int32_t next,
                std::vector<Link>& out) {
  if (t.copies_of(cell) == 0 || t.copies_of(next) == 0) return;
  const size_t first = out.size();
  uint64_t seen = 0;  // of the first eight classes of both
  auto add = [&](int a, int b) {
    if (a < 0 || b < 0) return;
    const bool few = a < 8 && b < 8;
    const uint64_t bit = uint64_t(1) << (few ? 8 * a + b : 0);
    const Link l{3 * cell + axis, next, int16_t(a), int16_t(b)};
    if (few ? (seen & bit) != 0 : std::find(out.begin() + ptrdiff_t(first), out.end(), l) != out.end()) return;
    if (few) seen |= bit;
    out.push_back(l);
  };
  const bool parts = t.tree.is_part(cell) || t.tree.is_part(next);
  const CellPlace low = parts ? t.tree.place(t.grid, cell) : CellPlace{},
                  high = parts ? t.tree.place(t.grid, next) : low;
  for (int k = 0; k < 8; ++k) {
    if (k & kLowToHigh[axis]) continue;
    if (low.level != high.level) {  // of the smaller square's corners one is a corner of the coarser cell
      const Int3 fine = low.level > high.level ? low.at : high.at;
      bool common = true;
      for (int a = 0; a < 3; ++a) common = common && (a == axis || (fine[a] & 1) == (k >> a & 1));
      if (!common) continue;
    }
    add(class_of_corner(t, cell, k | kLowToHigh[axis]), class_of_corner(t, next, k));
  }
  const CellComponents *a = t.components[size_t(cell)].get(), *b = t.components[size_t(next)].get();
  if (!a || !b) return;
  if (seen && a->classes.size() == 1 && b->classes.size() == 1) return;  // there is no other pair
  // Every sided face in both: it crosses the common square, with its material on the same side of it in both cells.
  // That needs two boxes whose union is a box: of a coarser cell only the part next to the finer one counts.
  CellPlace beside{};
  if (low.level != high.level) {
    beside = low.level > high.level ? low : high;
    (axis == 0 ? beside.at.x : axis == 1 ? beside.at.y : beside.at.z) += low.level > high.level ? 1 : -1;
  }
  const size_t end_a = a->face.size(), end_b = b->face.size();
  for (size_t i = 0, j = 0; i < end_a; ++i) {
    if (!(FaceInCell{a->relation[i]}.squares() >> (2 * axis + 1) & 1)) continue;  // it does not reach beyond
    const int32_t face = a->face[i];
    while (j < end_b && b->face[j] < face) ++j;
    if (j == end_b) break;
    if (b->face[j] != face) continue;
    if (low.level == high.level || builders[beside.level].meets(beside.at, face))
      for (size_t s = 0; s < 2; ++s) add(a->of_side[i][s], b->of_side[j][s]);
  }
}

void name_parents_by_neighbours(LatticeTopology& t, const LatticeTopology& previous) {
  std::vector<int32_t> open;
  for (size_t c = 0; c < t.cell_parent.size(); ++c)
    if (t.cell_parent[c] < 0) open.push_back(int32_t(c));
  const SharedArray<CellCopy>& cells = t.cells;
  for (bool progress = true; progress && !open.empty();) {
    progress = false;
    for (size_t k = 0; k < open.size(); ++k) {
      const int32_t me = open[k], cell = cells[size_t(me)].cell;
      int32_t found = -1;
      bool one = true;
      for (const auto& l : t.links) {
        const int32_t low_cell = l.cell_axis / 3;
        const bool low = low_cell == cell;  // my cell is the low one
        if (!low && l.next != cell) continue;
        const int32_t low_copy = t.copy(low_cell, l.low), high_copy = t.copy(l.next, l.high);
        const int32_t other_parent = t.cell_parent[size_t(low ? high_copy : low_copy)];
        if ((low ? low_copy : high_copy) != me || other_parent < 0) continue;
        for (const Link& p : previous.links.of(l.cell_axis)) {
          if (p.next != l.next || previous.copy(low ? l.next : low_cell, low ? p.high : p.low) != other_parent)
            continue;
          const int32_t candidate = previous.copy(cell, low ? p.low : p.high);
          one = one && (found < 0 || found == candidate);
          found = candidate;
        }
      }
      if (found >= 0 && one) {
        t.cell_parent.set(size_t(me), found);
        open[k] = open.back();
        open.pop_back();
        --k;
        progress = true;
      }
    }
  }
  for (int32_t me : open) {  // an isolated crumb: the largest copy that its cell had
    const int32_t cell = cells[size_t(me)].cell;
    int32_t best = -1;
    for (int k = 0; k < previous.copies_of(cell); ++k) {
      const int32_t c = previous.copy(cell, k);
      if (best < 0 || previous.cells[size_t(c)].fraction > previous.cells[size_t(best)].fraction) best = c;
    }
    if (best < 0) throw Contradiction("material has appeared in an empty lattice cell");
    t.cell_parent.set(size_t(me), best);
  }
}

}  // namespace limberg
