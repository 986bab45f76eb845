// Every invariant of a topology, for tests.
#include <algorithm>

#include "sim/lattice/topology_parts.h"

namespace limberg {
namespace {

std::string check_components(const LatticeTopology& t) {
  for (int32_t cell = 0; cell < t.tree.ids(); ++cell) {
    const auto& comp = t.components[size_t(cell)];
    if (t.tree.is_divided(cell)) {
      if (comp || t.copies_of(cell)) return "a divided cell holds something itself";
      const auto& state = t.tree.division[size_t(t.tree.division_of[size_t(cell)])].node_in_material;
      for (int k = 0; k < 8; ++k)
        if (bool(state[size_t((k & 1) * 2 + (k >> 1 & 1) * 6 + (k >> 2 & 1) * 18)]) !=
            bool(t.corners_in_material(cell) >> k & 1))
          return "the corners of a divided cell contradict its parts";
      continue;
    }
    const uint8_t in = t.corners_in_material(cell);
    if (!comp && in != 0 && in != 255) return "a cell without faces is neither full nor empty";
    if (!comp) continue;
    for (int k = 0; k < 8; ++k)
      if (bool(in >> k & 1) != (comp->of_corner[size_t(k)] >= 0)) return "a corner's class contradicts its node";
    std::vector<uint8_t> used(comp->classes.size(), 0);
    for (int16_t c : comp->of_corner)
      if (c >= 0) used[size_t(c)] = 1;
    for (const auto& s : comp->of_side)
      for (int16_t c : s)
        if (c >= 0) used[size_t(c)] = 1;
    for (uint8_t u : used)
      if (!u) return "a class has neither a face nor a corner";
  }
  return {};
}

// Cells that touch, be it in a corner, differ by one level at most (empty ones do not count); corners that several
// divisions have in common have one state.
std::string check_grading(const LatticeTopology& t) {
  std::vector<std::pair<std::array<int32_t, 3>, uint8_t>> state;
  for (const CellTree::Division& d : t.tree.division) {
    const CellPlace p = t.tree.place(t.grid, d.cell);
    const int step = kEighths >> (p.level + 1);
    for (int i = 0; i < 27; ++i)
      state.push_back({{step * (2 * p.at.x + i % 3), step * (2 * p.at.y + i / 3 % 3), step * (2 * p.at.z + i / 9)},
                       d.node_in_material[size_t(i)]});
  }
  std::sort(state.begin(), state.end());
  for (size_t i = 1; i < state.size(); ++i)
    if (state[i].first == state[i - 1].first && state[i].second != state[i - 1].second)
      return "two divided cells disagree about a common corner";
  for (int32_t cell = t.tree.grid_cells; cell < t.tree.ids(); ++cell) {
    if (t.copies_of(cell) == 0) continue;
    const CellPlace p = t.tree.place(t.grid, cell);
    for (int k = 0; k < 27; ++k) {
      const Int3 n{p.at.x + k % 3 - 1, p.at.y + k / 3 % 3 - 1, p.at.z + k / 9 - 1};
      bool inside = true;
      for (int a = 0; a < 3; ++a) inside = inside && n[a] >= 0 && n[a] < t.grid.count[a] << p.level;
      if (!inside) continue;
      const int32_t other = t.tree.find(t.grid, p.level, n);
      if (t.copies_of(other) > 0 && t.tree.level(other) + 1 < p.level) return "touching cells differ by two levels";
    }
  }
  return {};
}

std::string check_links(const LatticeTopology& t) {
  for (const auto& l : t.links) {
    const int32_t axis = l.cell_axis % 3, cell = l.cell_axis / 3;
    const CellCopy &a = t.cells[size_t(t.copy(cell, l.low))], &b = t.cells[size_t(t.copy(l.next, l.high))];
    if (a.piece != b.piece) return "joined copies are in different pieces";
    const bool same = t.tree.level(cell) == t.tree.level(l.next);
    const CellCopy& fine = t.tree.level(cell) > t.tree.level(l.next) ? a : b;
    const CellCopy& coarse = &fine == &a ? b : a;
    for (size_t k = 0; k < 8; ++k) {
      if (k & size_t(kLowToHigh[axis])) continue;
      const size_t up = k | size_t(kLowToHigh[axis]);
      if (same && a.node[up] != b.node[k]) return "joined copies do not share the nodes of their square";
      if (same) continue;
      // A corner of the smaller square is a corner of the coarser copy, or hangs on corners of it.
      const int32_t n = fine.node[&fine == &a ? up : k];
      const auto begin = coarse.node.begin(), end = coarse.node.end();
      if (std::find(begin, end, n) != end) continue;
      const LatticeTopology::Hanging* h = t.hanging_at(n);
      if (!h) return "a node between levels does not hang";
      for (size_t m = 0; m < size_t(h->count); ++m)
        if (std::find(begin, end, h->master[m]) == end) return "a node hangs on what is not beside it";
    }
  }
  return {};
}

std::string check_nodes(const LatticeTopology& t) {
  std::vector<uint8_t> used(t.nodes.size(), 0);
  for (const CellCopy& c : t.cells) {
    const CellPlace p = t.tree.place(t.grid, c.cell);
    const int size = kEighths >> p.level;
    for (int k = 0; k < 8; ++k) {
      const NodeCopy& n = t.nodes[size_t(c.node[size_t(k)])];
      for (int a = 0; a < 3; ++a)
        if (n.at[a] != size * (p.at[a] + (k >> a & 1))) return "a node copy is not at its cell's corner";
      const bool off = n.at.x % kEighths || n.at.y % kEighths || n.at.z % kEighths;
      if (n.lattice_node != (off ? -1 : t.grid.node_index({n.at.x / kEighths, n.at.y / kEighths, n.at.z / kEighths})))
        return "a node copy has a wrong place";
      used[size_t(c.node[size_t(k)])] = 1;
    }
  }
  for (uint8_t u : used)
    if (!u) return "a node copy has no cell";
  int32_t last = -1;
  for (const auto& h : t.hanging) {
    if (h.node <= last) return "hanging nodes are out of order";
    last = h.node;
    if (h.count != 2 && h.count != 4) return "a node hangs on neither an edge nor a square";
    for (int a = 0; a < 3; ++a) {
      int sum = 0;
      for (size_t k = 0; k < size_t(h.count); ++k) sum += t.nodes[size_t(h.master[k])].at[a];
      if (sum != h.count * t.nodes[size_t(h.node)].at[a]) return "a hanging node is not in the middle of its masters";
    }
    for (size_t k = 0; k < size_t(h.count); ++k)
      if (t.hanging_at(h.master[k])) return "a master hangs itself";
  }
  return {};
}

}  // namespace

std::string check_topology(const LatticeTopology& t) {
  for (const std::string& s : {check_components(t), check_grading(t), check_links(t), check_nodes(t)})
    if (!s.empty()) return s;
  return {};
}

}  // namespace limberg
