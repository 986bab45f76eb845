// What follows from the components after a cut that takes nothing away, in a lattice whose cells are not divided:
// copies, links, nodes and sums of the version before with the changes around the touched cells put in. The result
// is that of finish_topology to the last bit; only what cannot have changed is copied instead of found again.
//
//   copies  every old copy has a part, the first of which keeps its number; others come after
//   links   only through squares of touched cells, and not where both are whole still
//   nodes   only at corners of cells that have come apart and of squares with
//           other links: the cells around such a corner say which copies share it.
//           Of the parts of a node the one with the lowest corner keeps its number
//   pieces  none has come apart when the touched copies of each are still linked among themselves; else they are
//           found again
#include <algorithm>
#include <utility>

#include "sim/base/number_set.h"
#include "sim/base/union_find.h"
#include "sim/lattice/contradiction.h"
#include "sim/lattice/topology_parts.h"

namespace limberg {
namespace {

/// `t` comes as a copy of the version before with the components
/// of the touched cells found; only what differs is written.
class LocalUpdate {
 public:
  LocalUpdate(LatticeTopology& t, LevelBuilders& builders, const LatticeTopology& previous,
              std::span<const int32_t> touched, std::span<const int32_t> place)
      : t_(t),
        builders_(builders),
        before_(previous),
        touched_(touched),
        place_(place),
        cells_(t.cells),
        components_(t.components) {
    const Int3 n = t.grid.count;
    stride_ = {1, n.x, n.x * n.y};
  }
  bool possible() const;
  void run() {
    number_copies();
    relink();
    number_nodes();
    summarise();
  }

 private:
  void number_copies();
  void relink();
  void number_nodes();
  void around(int32_t lattice_node);
  void set_node(int32_t copy, int8_t corner, int32_t node) {
    if (cells_[size_t(copy)].node[size_t(corner)] != node) t_.cells[size_t(copy)].node[size_t(corner)] = node;
  }
  void summarise();

  LatticeTopology& t_;
  LevelBuilders& builders_;
  const LatticeTopology& before_;
  std::span<const int32_t> touched_;    // cells, ascending
  std::span<const int32_t> place_;      // per cell: where in touched_, -1
  const SharedArray<CellCopy>& cells_;  // t_'s, for reading
  const SharedArray<std::shared_ptr<const CellComponents>>& components_;
  std::array<int32_t, 3> stride_{};
  bool one_class(int32_t cell) const { return t_.copies_of(cell) == 1 && before_.copies_of(cell) == 1; }
  std::vector<int32_t> other_links_;  // squares (cell and axis) whose links are not those of before
  std::vector<int32_t> apart_;        // cells with another number of copies than before

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
  if (!t_.tree.division.empty() || t_.front_levels != 0) return false;
  std::vector<uint8_t> has_part;
  for (int32_t c : touched_) {
    const auto& now = components_[size_t(c)];
    const auto& was = before_.components[size_t(c)];
    if (!now && was) return false;
    if (!now) continue;
    has_part.assign(size_t(before_.copies_of(c)), 0);
    for (const CellClass& k : now->classes) {
      if (k.old_class < 0 || size_t(k.old_class) >= has_part.size()) return false;
      has_part[size_t(k.old_class)] = 1;
    }
    for (uint8_t p : has_part)
      if (!p) return false;
  }
  return true;
}

void LocalUpdate::number_copies() {
  t_.cell_parent = ParentList::identity(before_.cells.size());
  std::vector<uint8_t> taken;
  std::vector<int32_t> list;
  for (int32_t c : touched_) {
    const auto& comp = components_[size_t(c)];
    if (!comp) continue;
    taken.assign(size_t(before_.copies_of(c)), 0);
    list.clear();
    for (const CellClass& cls : comp->classes) {
      const int32_t old = before_.copy(c, cls.old_class);
      int32_t id = old;
      if (taken[size_t(cls.old_class)]) {
        id = int32_t(cells_.size());
        t_.cells.push_back(before_.cells[size_t(old)]);
        t_.cell_parent.push_back(old);
      }
      taken[size_t(cls.old_class)] = 1;
      if (cells_[size_t(id)].fraction != cls.fraction) t_.cells[size_t(id)].fraction = cls.fraction;
      list.push_back(id);
    }
    if (list.size() != taken.size()) apart_.push_back(c);
    t_.copies.set(size_t(c), list);
  }
}

void LocalUpdate::relink() {
  std::vector<int32_t> squares;  // cell and axis, of which one side has come apart or came in parts before
  const auto look_at = [&](int32_t cell, int axis) {
    // Two whole cells that are joined stay so: a cut takes no material from their square.
    if (!(one_class(cell) && one_class(cell + stride_[size_t(axis)]))) squares.push_back(3 * cell + axis);
  };
  for (int32_t c : touched_) {
    const Int3 at = t_.grid.cell_at(c);
    for (int axis = 0; axis < 3; ++axis) {
      if (at[axis] + 1 < t_.grid.count[axis]) look_at(c, axis);
      const int32_t below = c - stride_[size_t(axis)];
      if (at[axis] > 0 && place_[size_t(below)] < 0) look_at(below, axis);
    }
  }
  std::sort(squares.begin(), squares.end());
  std::vector<Link> fresh, changed;
  for (int32_t s : squares) {
    fresh.clear();
    find_links(t_, builders_, s / 3, s % 3, s / 3 + stride_[size_t(s % 3)], fresh);
    std::sort(fresh.begin(), fresh.end());
    const std::span<const Link> was = before_.links.of(s);
    if (std::equal(was.begin(), was.end(), fresh.begin(), fresh.end())) continue;
    other_links_.push_back(s);
    changed.insert(changed.end(), fresh.begin(), fresh.end());
  }
  t_.links.replace(other_links_, changed);
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
  if (!pieces_stay(t_, before_.pieces, touched_, place_)) return limberg::summarise(t_);
  for (int32_t c : touched_) {
    for (int k = 0; k < before_.copies_of(c); ++k) {
      const CellCopy& was = before_.cells[size_t(before_.copy(c, k))];
      t_.piece_sum[size_t(was.piece)] -= exact_share(was.fraction, 0);
    }
    for (int k = 0; k < t_.copies_of(c); ++k) {
      const CellCopy& now = cells_[size_t(t_.copy(c, k))];
      t_.piece_sum[size_t(now.piece)] += exact_share(now.fraction, 0);
    }
    if (const auto& was = before_.components[size_t(c)])
      t_.walks -= was->walks, t_.walks_unresolved -= was->walks_unresolved;
    if (const auto& now = components_[size_t(c)]) t_.walks += now->walks, t_.walks_unresolved += now->walks_unresolved;
  }
  volumes_from_sums(t_);
}

}  // namespace

bool finish_locally(LatticeTopology& topology, LevelBuilders& builders, const LatticeTopology& previous,
                    std::span<const int32_t> touched, std::span<const int32_t> place) {
  LocalUpdate update(topology, builders, previous, touched, place);
  if (!update.possible()) return false;
  update.run();
  return true;
}

}  // namespace limberg
