// What follows from the components at the cost of what has changed: after a cut that takes nothing away, and after a
// division. The result is that of finish_topology to the last bit; only what cannot have changed is copied instead of
// found again.
//
//   copies  every old copy has a part, the first of which keeps its number; others come after
//   links   only through squares of cells that have changed, and not where both sides are whole still
//   nodes   where no cell is divided: only at corners of cells that have come apart and of squares with other links.
//           The cells around such a corner say which copies share it; of the parts of a node the one with the lowest
//           corner keeps its number.
//           Else number_nodes() for the corners of undivided cells in which a cell has come apart, has been divided or
//           has other links. A node that hangs lies on a square of an undivided cell together with what it hangs on, so
//           such cells close over what hangs; and all that can say who is one node with whom lies within two undivided
//           cells of them
//   pieces  none has come apart when the changed copies of each are still linked among themselves; else they are found
//           again
#include <algorithm>
#include <utility>

#include "sim/base/number_set.h"
#include "sim/base/union_find.h"
#include "sim/lattice/contradiction.h"
#include "sim/lattice/topology_parts.h"

namespace limberg {
namespace {

/// `t` comes as a copy of the version before with tree and components of now; only what differs is written.
class LocalUpdate {
 public:
  LocalUpdate(LatticeTopology& t, LevelBuilders& builders, const LatticeTopology& before,
              std::span<const int32_t> touched, const NewParts& parts)
      : t_(t),
        builders_(builders),
        before_(before),
        parts_(parts),
        descent_(t, parts),
        cells_(t.cells),
        components_(t.components),
        changed_set_(size_t(t.tree.ids())) {
    for (int32_t c : touched)
      if (!t.tree.is_divided(c)) changed_.push_back(c);
    for (int32_t c = parts.known; c < t.tree.ids(); ++c)
      if (!t.tree.is_divided(c)) changed_.push_back(c);
    changed_set_.add_all(changed_);
  }
  bool possible() const;
  bool run() {
    number_copies();
    relink();
    if (!t_.tree.division.empty()) {
      const NodeRegion near = region();
      if (!limberg::number_nodes(t_, &before_, parts_, &near)) return false;
    } else {
      number_nodes();
    }
    summarise();
    return true;
  }

 private:
  void number_copies();
  void relink();
  NodeRegion region() const;
  void number_nodes();
  void around(int32_t lattice_node);
  void set_node(int32_t copy, int8_t corner, int32_t node) {
    if (cells_[size_t(copy)].node[size_t(corner)] != node) t_.cells[size_t(copy)].node[size_t(corner)] = node;
  }
  void summarise();
  int class_before(int32_t cell, int cls) const {
    if (descent_.is_new(cell)) return descent_.class_before(cell, cls);
    const auto& comp = components_[size_t(cell)];
    return comp ? comp->classes[size_t(cls)].old_class : cls;
  }
  /// One copy as before. Between two such cells a link stays, or stays away: a cut takes no material from their square.
  bool whole_still(int32_t cell) const {
    return !descent_.is_new(cell) && t_.copies_of(cell) == 1 && before_.copies_of(cell) == 1;
  }
  int32_t grid_cell(int32_t cell) const {
    while (t_.tree.is_part(cell)) cell = t_.tree.owner(cell);
    return cell;
  }
  void add_leaves(int32_t cell, std::vector<int32_t>& out) const {
    if (!t_.tree.is_divided(cell)) {
      if (t_.copies_of(cell) > 0) out.push_back(cell);
      return;
    }
    for (int k = 0; k < 8; ++k) add_leaves(t_.tree.part(cell, k), out);
  }

  LatticeTopology& t_;
  LevelBuilders& builders_;
  const LatticeTopology& before_;
  const NewParts& parts_;
  const Descent descent_;
  const SharedArray<CellCopy>& cells_;  // t_'s, for reading
  const SharedArray<std::shared_ptr<const CellComponents>>& components_;
  std::vector<int32_t> changed_;  // cells that are not divided, ascending: touched ones and new parts
  NumberSet changed_set_;
  std::vector<int32_t> apart_;        // cells with another number of copies than before, and new parts
  std::vector<int32_t> other_links_;  // squares (cell and axis) whose links are not those of before

  // Around one lattice node: corners of copies, which of them are one, and the parts beyond the first of each old node.
  struct Corner {
    int32_t copy = 0, node = 0;  // node: of the version before
    int8_t k = 0;
  };
  struct Extra {
    int32_t first = 0;  // lowest 8 * copy + k
    int32_t parent = 0;
    uint32_t begin = 0, end = 0;  // into extra_corner_
  };
  std::vector<Corner> corner_;
  std::vector<int32_t> node_;  // those of before among them
  UnionFind join_;
  std::vector<std::pair<int32_t, int8_t>> extra_corner_;
  std::vector<Extra> extra_;
};

bool LocalUpdate::possible() const {
  NumberSet has_part(before_.cells.size()), asked(before_.components.size());
  for (int32_t c : changed_) {
    const int32_t was = descent_.cell_before(c);
    asked.add(was);
    if (!descent_.is_new(c) && !components_[size_t(c)] && before_.components[size_t(c)]) return false;
    for (int k = 0; k < classes_in(t_, c); ++k) {
      const int old = class_before(c, k);
      if (old < 0 || old >= before_.copies_of(was)) return false;
      has_part.add(before_.copy(was, old));
    }
  }
  for (int32_t c : asked.ascending())
    for (int k = 0; k < before_.copies_of(c); ++k)
      if (!has_part.has(before_.copy(c, k))) return false;
  return true;
}

void LocalUpdate::number_copies() {
  t_.cell_parent = ParentList::identity(before_.cells.size());
  t_.copies.resize(size_t(t_.tree.ids()));
  NumberSet taken(before_.cells.size());
  std::vector<int32_t> list;
  for (int32_t c : changed_) {
    const auto& comp = components_[size_t(c)];
    const int32_t was = descent_.cell_before(c);
    list.clear();
    for (int k = 0; k < classes_in(t_, c); ++k) {
      const int32_t old = before_.copy(was, class_before(c, k));
      int32_t id = old;
      if (!taken.add(old)) {
        id = int32_t(cells_.size());
        t_.cells.push_back(before_.cells[size_t(old)]);
        t_.cell_parent.push_back(old);
      }
      CellCopy copy = cells_[size_t(id)];
      const double fraction = comp ? comp->classes[size_t(k)].fraction : 1;
      if (copy.cell != c || copy.fraction != fraction)
        copy.cell = c, copy.fraction = fraction, t_.cells.set(size_t(id), copy);
      list.push_back(id);
    }
    if (int32_t(list.size()) != before_.copies_of(was) || was != c) apart_.push_back(c);
    t_.copies.set(size_t(c), list);
  }
  const SharedArray<CellTree::Division>& division = std::as_const(t_.tree.division);
  for (size_t d = division.size() - parts_.whole.size(); d < division.size(); ++d)
    t_.copies.set(size_t(division[d].cell), {});
}

void LocalUpdate::relink() {
  // Squares between a changed cell and another, by the cell on
  // their low side; and all those of cells that are divided now.
  const bool undivided = t_.tree.division.empty();  // then what lies beyond a square is found by its number
  const std::array<int32_t, 3> stride{1, t_.grid.count.x, t_.grid.count.x * t_.grid.count.y};
  std::vector<int32_t> squares, beyond;
  for (int32_t c : changed_) {
    if (t_.copies_of(c) == 0) continue;
    const Int3 at = undivided ? t_.grid.cell_at(c) : Int3{};
    for (int axis = 0; axis < 3; ++axis) {
      const int32_t step = stride[size_t(axis)];
      if (undivided) {
        const bool whole = whole_still(c);
        if (at[axis] + 1 < t_.grid.count[axis] && !(whole && whole_still(c + step))) squares.push_back(3 * c + axis);
        if (at[axis] > 0 && !(whole && whole_still(c - step))) squares.push_back(3 * (c - step) + axis);
        continue;
      }
      squares.push_back(3 * c + axis);
      cells_beyond(t_, c, axis, beyond, false);
      for (int32_t below : beyond) squares.push_back(3 * below + axis);
    }
  }
  const SharedArray<CellTree::Division>& division = std::as_const(t_.tree.division);
  for (size_t d = division.size() - parts_.whole.size(); d < division.size(); ++d)
    for (int axis = 0; axis < 3; ++axis) squares.push_back(3 * division[d].cell + axis);
  std::sort(squares.begin(), squares.end());
  squares.erase(std::unique(squares.begin(), squares.end()), squares.end());
  std::vector<Link> fresh, links;
  for (int32_t s : squares) {
    fresh.clear();
    const int32_t cell = s / 3;
    const std::span<const Link> was = before_.links.of(s);
    if (!t_.tree.is_divided(cell) && t_.copies_of(cell) > 0) {
      if (undivided)
        beyond.assign(1, cell + stride[size_t(s % 3)]);
      else
        cells_beyond(t_, cell, s % 3, beyond);
      if (whole_still(cell) && std::all_of(beyond.begin(), beyond.end(), [&](int32_t c) { return whole_still(c); }))
        continue;
      for (int32_t next : beyond)
        if (changed_set_.has(cell) || changed_set_.has(next)) find_links(t_, builders_, cell, s % 3, next, fresh);
      // What has not changed on either side stays.
      if (!changed_set_.has(cell))
        for (const Link& l : was)
          if (!changed_set_.has(l.next) && !t_.tree.is_divided(l.next)) fresh.push_back(l);
      std::sort(fresh.begin(), fresh.end());
    }
    if (std::equal(was.begin(), was.end(), fresh.begin(), fresh.end())) continue;
    other_links_.push_back(s);
    links.insert(links.end(), fresh.begin(), fresh.end());
  }
  t_.links.replace(other_links_, links);
}

NodeRegion LocalUpdate::region() const {
  NodeRegion r{{}, {}, NumberSet(size_t(t_.tree.grid_cells))};
  for (int32_t c : apart_) r.changed.add(grid_cell(c));
  for (int32_t s : other_links_) {
    r.changed.add(grid_cell(s / 3));
    for (const Link& l : before_.links.of(s)) r.changed.add(grid_cell(l.next));
    for (const Link& l : t_.links.of(s)) r.changed.add(grid_cell(l.next));
  }
  NumberSet near(size_t(t_.tree.grid_cells));
  for (int32_t c : r.changed.ascending()) {
    const Int3 at = t_.grid.cell_at(c);
    for (int dz = -2; dz <= 2; ++dz)
      for (int dy = -2; dy <= 2; ++dy)
        for (int dx = -2; dx <= 2; ++dx) {
          const Int3 n{at.x + dx, at.y + dy, at.z + dz};
          if (n.x < 0 || n.y < 0 || n.z < 0 || n.x >= t_.grid.count.x || n.y >= t_.grid.count.y ||
              n.z >= t_.grid.count.z)
            continue;
          near.add(t_.grid.cell_index(n));
        }
  }
  for (int32_t c : near.ascending()) add_leaves(c, r.cells);
  std::sort(r.cells.begin(), r.cells.end());
  for (int32_t c : r.cells)
    for (int k = 0; k < t_.copies_of(c); ++k) r.copies.push_back(t_.copy(c, k));
  std::sort(r.copies.begin(), r.copies.end());
  return r;
}

void LocalUpdate::around(int32_t lattice_node) {
  const Int3 at = t_.grid.node_at(lattice_node);
  corner_.clear();
  std::array<int32_t, 9> first{};
  std::array<int32_t, 8> cell{};
  for (int b = 0; b < 8; ++b) {
    first[size_t(b)] = int32_t(corner_.size());
    const Int3 c{at.x - 1 + (b & 1), at.y - 1 + (b >> 1 & 1), at.z - 1 + (b >> 2 & 1)};
    const bool inside =
        c.x >= 0 && c.y >= 0 && c.z >= 0 && c.x < t_.grid.count.x && c.y < t_.grid.count.y && c.z < t_.grid.count.z;
    cell[size_t(b)] = inside ? t_.grid.cell_index(c) : -1;
    if (!inside) continue;
    const int8_t k = int8_t(7 ^ b);
    for (int cls = 0; cls < t_.copies_of(cell[size_t(b)]); ++cls) {
      const int32_t copy = t_.copy(cell[size_t(b)], cls);
      corner_.push_back({copy, before_.cells[size_t(t_.cell_parent[size_t(copy)])].node[size_t(k)], k});
    }
  }
  first[8] = int32_t(corner_.size());
  join_.reset(corner_.size());
  size_t groups = corner_.size();
  for (int b = 0; b < 8; ++b) {
    if (first[size_t(b)] == first[size_t(b) + 1]) continue;
    for (int axis = 0; axis < 3; ++axis) {
      const int other = b | 1 << axis;
      if (other == b || first[size_t(other)] == first[size_t(other) + 1]) continue;
      for (const Link& l : t_.links.of(3 * cell[size_t(b)] + axis)) {
        const int32_t low = first[size_t(b)] + l.low, high = first[size_t(other)] + l.high;
        if (corner_[size_t(low)].node != corner_[size_t(high)].node)
          throw Contradiction("a cut has joined two node copies: the lattice is not a refinement of the one before");
        groups -= join_.unite(low, high);
      }
    }
  }
  // As many groups as there were nodes: each is one of them, and copies come with the nodes of their parents.
  node_.clear();
  for (const Corner& c : corner_)
    if (std::find(node_.begin(), node_.end(), c.node) == node_.end()) node_.push_back(c.node);
  if (groups == node_.size()) return;
  // Groups: their lowest corner, and the old node that all their corners must have had.
  struct Group {
    int32_t root, first, parent;
  };
  std::array<Group, 64> small;
  std::vector<Group> many;
  size_t n = 0;
  const auto group = [&](size_t i) -> Group& { return many.empty() ? small[i] : many[i]; };
  for (size_t i = 0; i < corner_.size(); ++i) {
    const int32_t root = join_.find(int32_t(i)), name = 8 * corner_[i].copy + corner_[i].k;
    size_t g = 0;
    while (g < n && group(g).root != root) ++g;
    if (g == n) {
      if (n == small.size() && many.empty()) many.assign(small.begin(), small.end());
      if (many.empty())
        small[n] = {root, name, corner_[i].node};
      else
        many.push_back({root, name, corner_[i].node});
      ++n;
      continue;
    }
    group(g).first = std::min(group(g).first, name);
  }
  for (size_t g = 0; g < n; ++g) {
    bool lowest = true;
    for (size_t h = 0; h < n; ++h)
      lowest = lowest && (group(h).parent != group(g).parent || group(h).first >= group(g).first);
    Extra extra{group(g).first, group(g).parent, uint32_t(extra_corner_.size()), 0};
    for (size_t i = 0; i < corner_.size(); ++i) {
      if (join_.find(int32_t(i)) != group(g).root) continue;
      if (lowest)
        set_node(corner_[i].copy, corner_[i].k, group(g).parent);
      else
        extra_corner_.push_back({corner_[i].copy, corner_[i].k});
    }
    extra.end = uint32_t(extra_corner_.size());
    if (!lowest) extra_.push_back(extra);
  }
}

void LocalUpdate::number_nodes() {
  t_.node_parent = ParentList::identity(before_.nodes.size());
  NumberSet corners(t_.node_in_material.size());
  const auto add = [&](int32_t cell, int of, int high) {  // corners k of a cell with (k & of) == high
    const Int3 at = t_.grid.cell_at(cell);
    for (int k = 0; k < 8; ++k)
      if ((k & of) == high) corners.add(t_.grid.node_index({at.x + (k & 1), at.y + (k >> 1 & 1), at.z + (k >> 2 & 1)}));
  };
  for (int32_t c : apart_) add(c, 0, 0);
  for (int32_t s : other_links_) add(s / 3, 1 << s % 3, 1 << s % 3);
  for (int32_t n : corners.ascending()) around(n);
  std::sort(extra_.begin(), extra_.end(), [](const Extra& a, const Extra& b) { return a.first < b.first; });
  for (const Extra& e : extra_) {
    const int32_t id = int32_t(t_.nodes.size());
    t_.nodes.push_back(before_.nodes[size_t(e.parent)]);
    t_.node_parent.push_back(e.parent);
    for (uint32_t i = e.begin; i < e.end; ++i) set_node(extra_corner_[i].first, extra_corner_[i].second, id);
  }
}

void LocalUpdate::summarise() {
  std::vector<int32_t> place(size_t(t_.tree.ids()), -1);
  for (size_t i = 0; i < changed_.size(); ++i) place[size_t(changed_[i])] = int32_t(i);
  if (!pieces_stay(t_, before_.pieces, changed_, place)) return limberg::summarise(t_);
  NumberSet before(before_.components.size());
  for (int32_t c : changed_) {
    before.add(descent_.cell_before(c));
    const int level = t_.tree.level(c);
    for (int k = 0; k < t_.copies_of(c); ++k) {
      const CellCopy& now = cells_[size_t(t_.copy(c, k))];
      t_.piece_sum[size_t(now.piece)] += exact_share(now.fraction, level);
    }
    if (const auto& now = components_[size_t(c)]) t_.walks += now->walks, t_.walks_unresolved += now->walks_unresolved;
  }
  for (int32_t c : before.ascending()) {
    for (int k = 0; k < before_.copies_of(c); ++k) {
      const CellCopy& was = before_.cells[size_t(before_.copy(c, k))];
      t_.piece_sum[size_t(was.piece)] -= exact_share(was.fraction, before_.tree.level(c));
    }
    if (const auto& was = before_.components[size_t(c)])
      t_.walks -= was->walks, t_.walks_unresolved -= was->walks_unresolved;
  }
  volumes_from_sums(t_);
}

}  // namespace

bool finish_locally(LatticeTopology& topology, LevelBuilders& builders, const LatticeTopology& previous,
                    std::span<const int32_t> touched, const NewParts& parts) {
  LocalUpdate update(topology, builders, previous, touched, parts);
  return update.possible() && update.run();
}

}  // namespace limberg
