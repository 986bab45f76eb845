// Cell copies, links and node copies.
#include <algorithm>
#include <stdexcept>

#include "sim/hash.h"
#include "sim/lattice/topology_parts.h"

namespace limberg {
namespace {

int classes_in(const LatticeTopology& t, int32_t cell) {
  if (const auto& c = t.components[size_t(cell)]) return int(c->classes.size());
  return t.node_in_material[size_t(t.grid.node_index(t.grid.cell_at(cell)))] ? 1 : 0;
}

int class_of_corner(const LatticeTopology& t, int32_t cell, int corner) {
  if (const auto& c = t.components[size_t(cell)]) return c->of_corner[size_t(corner)];
  return classes_in(t, cell) - 1;
}

constexpr int kLowToHigh[3] = {1, 2, 4};

}  // namespace

void number_copies(LatticeTopology& t, const LatticeTopology* previous, std::span<const uint8_t> touched) {
  const int32_t cells = int32_t(t.components.size());
  t.copy_begin.assign(size_t(cells) + 1, 0);
  for (int32_t c = 0; c < cells; ++c) t.copy_begin[size_t(c) + 1] = t.copy_begin[size_t(c)] + classes_in(t, c);
  t.copy_id.assign(size_t(t.copy_begin.back()), -1);
  t.cells.clear();
  t.cells.reserve(t.copy_id.size());
  auto make = [&](int32_t cell, int cls, int32_t parent) {
    int32_t& id = t.copy_id[size_t(t.copy_begin[size_t(cell)] + cls)];
    if (id >= 0) return;
    id = int32_t(t.cells.size());
    CellCopy copy;
    copy.cell = cell;
    copy.parent = parent;
    const auto& comp = t.components[size_t(cell)];
    copy.fraction = comp ? comp->classes[size_t(cls)].fraction : 1;
    t.cells.push_back(copy);
  };
  auto old_class = [&](int32_t cell, int cls) -> int {
    const auto& comp = t.components[size_t(cell)];
    return touched[size_t(cell)] && comp ? comp->classes[size_t(cls)].old_class : cls;
  };
  if (previous) {
    // Class of a previous copy: its place among the copies of its cell.
    std::vector<int32_t> class_of_copy(previous->cells.size());
    for (size_t c = 0; c + 1 < previous->copy_begin.size(); ++c)
      for (int32_t k = previous->copy_begin[c]; k < previous->copy_begin[c + 1]; ++k)
        class_of_copy[size_t(previous->copy_id[size_t(k)])] = k - previous->copy_begin[c];
    for (size_t p = 0; p < previous->cells.size(); ++p) {
      const int32_t cell = previous->cells[p].cell;
      for (int k = 0; k < t.copies_of(cell); ++k)
        if (old_class(cell, k) == class_of_copy[p]) {
          make(cell, k, int32_t(p));
          break;
        }
    }
  }
  for (int32_t c = 0; c < cells; ++c)
    for (int k = 0; k < t.copies_of(c); ++k) {
      const int old = previous ? old_class(c, k) : -1;
      make(c, k, old >= 0 ? previous->copy(c, old) : -1);
    }
}

void find_links(const LatticeTopology& t, int32_t cell, int axis, std::vector<LatticeTopology::Link>& out) {
  const Int3 at = t.grid.cell_at(cell);
  const int32_t next = t.grid.cell_index({at.x + (axis == 0), at.y + (axis == 1), at.z + (axis == 2)});
  if (t.copies_of(cell) == 0 || t.copies_of(next) == 0) return;
  const size_t first = out.size();
  auto add = [&](int a, int b) {
    if (a < 0 || b < 0) return;
    const LatticeTopology::Link l{3 * cell + axis, int16_t(a), int16_t(b)};
    if (std::find(out.begin() + ptrdiff_t(first), out.end(), l) == out.end()) out.push_back(l);
  };
  for (int k = 0; k < 8; ++k)
    if (!(k & kLowToHigh[axis])) add(class_of_corner(t, cell, k | kLowToHigh[axis]), class_of_corner(t, next, k));
  const CellComponents *a = t.components[size_t(cell)].get(), *b = t.components[size_t(next)].get();
  if (!a || !b) return;
  // Every sided face in both: it crosses the common square, with its material on the same side of it in both cells.
  for (size_t i = 0, j = 0; i < a->face.size() && j < b->face.size();) {
    if (a->face[i] < b->face[j])
      ++i;
    else if (a->face[i] > b->face[j])
      ++j;
    else {
      for (size_t s = 0; s < 2; ++s) add(a->of_side[i][s], b->of_side[j][s]);
      ++i, ++j;
    }
  }
}

void name_parents_by_neighbours(LatticeTopology& t, const LatticeTopology& previous) {
  std::vector<int32_t> open;
  for (size_t c = 0; c < t.cells.size(); ++c)
    if (t.cells[c].parent < 0) open.push_back(int32_t(c));
  const int32_t stride[3] = {1, t.grid.count.x, t.grid.count.x * t.grid.count.y};
  for (bool progress = true; progress && !open.empty();) {
    progress = false;
    for (size_t k = 0; k < open.size(); ++k) {
      const int32_t me = open[k], cell = t.cells[size_t(me)].cell;
      int32_t found = -1;
      bool one = true;
      auto through = [&](int32_t cell_axis, bool low) {  // links in which my cell is the low or the high one
        const auto range = std::lower_bound(t.links.begin(), t.links.end(), LatticeTopology::Link{cell_axis, 0, 0});
        const int32_t low_cell = cell_axis / 3, high_cell = low_cell + stride[cell_axis % 3];
        for (auto l = range; l != t.links.end() && l->cell_axis == cell_axis; ++l) {
          const int32_t mine = t.copy(cell, low ? l->low : l->high);
          const int32_t other = t.copy(low ? high_cell : low_cell, low ? l->high : l->low);
          const int32_t other_parent = t.cells[size_t(other)].parent;
          if (mine != me || other_parent < 0) continue;
          for (auto p = std::lower_bound(previous.links.begin(), previous.links.end(),
                                         LatticeTopology::Link{cell_axis, 0, 0});
               p != previous.links.end() && p->cell_axis == cell_axis; ++p) {
            if (previous.copy(low ? high_cell : low_cell, low ? p->high : p->low) != other_parent) continue;
            const int32_t candidate = previous.copy(cell, low ? p->low : p->high);
            one = one && (found < 0 || found == candidate);
            found = candidate;
          }
        }
      };
      for (int axis = 0; axis < 3; ++axis) {
        through(3 * cell + axis, true);
        if (t.grid.cell_at(cell)[axis] > 0) through(3 * (cell - stride[axis]) + axis, false);
      }
      if (found >= 0 && one) {
        t.cells[size_t(me)].parent = found;
        open[k] = open.back();
        open.pop_back();
        --k;
        progress = true;
      }
    }
  }
  for (int32_t me : open) {  // an isolated crumb: the largest copy that its cell had
    const int32_t cell = t.cells[size_t(me)].cell;
    int32_t best = -1;
    for (int k = 0; k < previous.copies_of(cell); ++k) {
      const int32_t c = previous.copy(cell, k);
      if (best < 0 || previous.cells[size_t(c)].fraction > previous.cells[size_t(best)].fraction) best = c;
    }
    if (best < 0) throw std::logic_error("material has appeared in an empty lattice cell");
    t.cells[size_t(me)].parent = best;
  }
}

void number_nodes(LatticeTopology& t, const LatticeTopology* previous) {
  const int32_t stride[3] = {1, t.grid.count.x, t.grid.count.x * t.grid.count.y};
  Partition corners;
  corners.reset(8 * t.cells.size());
  for (const auto& l : t.links) {
    const int32_t cell = l.cell_axis / 3, axis = l.cell_axis % 3, bit = kLowToHigh[axis];
    const int32_t a = t.copy(cell, l.low), b = t.copy(cell + stride[axis], l.high);
    for (int k = 0; k < 8; ++k)
      if (!(k & bit)) corners.unite(8 * a + (k | bit), 8 * b + k);
  }
  // Groups in the order of their first corner, each with its parent.
  std::vector<int32_t> group_of(8 * t.cells.size(), -1);
  std::vector<NodeCopy> group;
  for (size_t c = 0; c < t.cells.size(); ++c) {
    const Int3 at = t.grid.cell_at(t.cells[c].cell);
    for (int k = 0; k < 8; ++k) {
      int32_t& g = group_of[size_t(corners.find(int32_t(8 * c) + k))];
      const int32_t parent = previous ? previous->cells[size_t(t.cells[c].parent)].node[size_t(k)] : -1;
      if (g < 0) {
        g = int32_t(group.size());
        group.push_back({t.grid.node_index({at.x + (k & 1), at.y + (k >> 1 & 1), at.z + (k >> 2 & 1)}), parent});
      } else if (group[size_t(g)].parent != parent) {
        throw std::logic_error("a cut has joined two node copies: the lattice is not a refinement of the one before");
      }
    }
  }
  std::vector<int32_t> number(group.size(), -1);
  t.nodes.clear();
  t.nodes.reserve(group.size());
  if (previous) {  // first child of each parent, in the parents' order
    std::vector<int32_t> first_child(previous->nodes.size(), -1);
    for (size_t g = 0; g < group.size(); ++g)
      if (first_child[size_t(group[g].parent)] < 0) first_child[size_t(group[g].parent)] = int32_t(g);
    for (int32_t g : first_child)
      if (g >= 0) number[size_t(g)] = int32_t(t.nodes.size()), t.nodes.push_back(group[size_t(g)]);
  }
  for (size_t g = 0; g < group.size(); ++g)
    if (number[g] < 0) number[g] = int32_t(t.nodes.size()), t.nodes.push_back(group[g]);
  for (size_t c = 0; c < t.cells.size(); ++c)
    for (int k = 0; k < 8; ++k)
      t.cells[c].node[size_t(k)] = number[size_t(group_of[size_t(corners.find(int32_t(8 * c) + k))])];
}

void summarise(LatticeTopology& t) {
  const int32_t stride[3] = {1, t.grid.count.x, t.grid.count.x * t.grid.count.y};
  Partition join;
  join.reset(t.cells.size());
  for (const auto& l : t.links)
    join.unite(t.copy(l.cell_axis / 3, l.low), t.copy(l.cell_axis / 3 + stride[l.cell_axis % 3], l.high));
  const Vec3 h = t.grid.cell_mm();
  const double cell_volume = h.x() * h.y() * h.z();
  std::vector<int32_t> piece_of(t.cells.size(), -1);
  t.piece_volume_mm3.clear();
  t.piece_fixed.clear();
  t.volume_mm3 = 0;
  for (size_t c = 0; c < t.cells.size(); ++c) {
    int32_t& p = piece_of[size_t(join.find(int32_t(c)))];
    if (p < 0) {
      p = int32_t(t.piece_volume_mm3.size());
      t.piece_volume_mm3.push_back(0);
      t.piece_fixed.push_back(0);
    }
    t.cells[c].piece = p;
    t.piece_volume_mm3[size_t(p)] += t.cells[c].fraction * cell_volume;
  }
  for (double v : t.piece_volume_mm3) t.volume_mm3 += v;
  t.pieces = int(t.piece_volume_mm3.size());
  t.walks = t.walks_unresolved = 0;
  Hash64 hash;
  for (size_t cell = 0; cell < t.components.size(); ++cell) {
    const auto& comp = t.components[cell];
    for (int k = 0; k < t.copies_of(int32_t(cell)); ++k) {
      const CellCopy& copy = t.cells[size_t(t.copy(int32_t(cell), k))];
      hash.add(int32_t(cell));
      hash.add(comp ? comp->classes[size_t(k)].corners : uint8_t(255));
      for (int32_t n : copy.node) hash.add(n);
      if (comp && comp->classes[size_t(k)].fixed_sides) t.piece_fixed[size_t(copy.piece)] = 1;
    }
    if (comp) t.walks += comp->walks, t.walks_unresolved += comp->walks_unresolved;
  }
  hash.add(t.pieces);
  t.hash = hash.value();
}

std::string check_topology(const LatticeTopology& t) {
  // Lattice edges: cells that share one agree on it and on the nodes at its ends.
  for (size_t cell = 0; cell < t.components.size(); ++cell) {
    const auto& comp = t.components[cell];
    const Int3 at = t.grid.cell_at(int32_t(cell));
    auto in = [&](int k) {
      return t.node_in_material[size_t(
                 t.grid.node_index({at.x + (k & 1), at.y + (k >> 1 & 1), at.z + (k >> 2 & 1)}))] != 0;
    };
    for (int k = 0; k < 8; ++k) {
      if (!comp && in(k) != in(0)) return "a cell without faces is neither full nor empty";
      if (comp && in(k) != (comp->of_corner[size_t(k)] >= 0)) return "a corner's class contradicts its node";
    }
    if (comp) {
      std::vector<uint8_t> used(comp->classes.size(), 0);
      for (int16_t c : comp->of_corner)
        if (c >= 0) used[size_t(c)] = 1;
      for (const auto& s : comp->of_side)
        for (int16_t c : s)
          if (c >= 0) used[size_t(c)] = 1;
      for (uint8_t u : used)
        if (!u) return "a class has neither a face nor a corner";
    }
  }
  const int32_t stride[3] = {1, t.grid.count.x, t.grid.count.x * t.grid.count.y};
  for (const auto& l : t.links) {
    const int32_t axis = l.cell_axis % 3;
    const CellCopy &a = t.cells[size_t(t.copy(l.cell_axis / 3, l.low))],
                   &b = t.cells[size_t(t.copy(l.cell_axis / 3 + stride[axis], l.high))];
    if (a.piece != b.piece) return "joined copies are in different pieces";
    for (size_t k = 0; k < 8; ++k)
      if (!(k & size_t(kLowToHigh[axis])) && a.node[k | size_t(kLowToHigh[axis])] != b.node[k])
        return "joined copies do not share the nodes of their square";
  }
  std::vector<uint8_t> used(t.nodes.size(), 0);
  for (const CellCopy& c : t.cells) {
    const Int3 at = t.grid.cell_at(c.cell);
    for (int k = 0; k < 8; ++k) {
      if (t.nodes[size_t(c.node[size_t(k)])].lattice_node !=
          t.grid.node_index({at.x + (k & 1), at.y + (k >> 1 & 1), at.z + (k >> 2 & 1)}))
        return "a node copy is not at its cell's corner";
      used[size_t(c.node[size_t(k)])] = 1;
    }
  }
  for (uint8_t u : used)
    if (!u) return "a node copy has no cell";
  return {};
}

}  // namespace limberg
