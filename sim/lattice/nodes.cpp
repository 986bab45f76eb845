// Node copies: classes of cell corners under the links, their parents, and what hangs.
#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <utility>

#include "sim/hash.h"
#include "sim/lattice/topology_parts.h"

namespace limberg {
namespace {

constexpr int kLowToHigh[3] = {1, 2, 4};

/// The corners of the smaller square of a link between levels, seen from the coarser cell. Corner `fine` of the finer
/// copy hangs on `count` corners of the coarser one, or is it when count is 1.
struct Rim {
  int fine = 0, count = 0;
  std::array<int, 4> coarse{};
};

std::array<Rim, 4> rim_of(Int3 fine_at, int axis, bool fine_is_low) {
  std::array<Rim, 4> rim;
  size_t n = 0;
  for (int k = 0; k < 8; ++k) {
    if (bool(k & kLowToHigh[axis]) != fine_is_low) continue;
    Rim& r = rim[n++];
    r.fine = k;
    for (int c = 0; c < 8; ++c) {
      if (bool(c & kLowToHigh[axis]) == fine_is_low) continue;
      bool on = true;
      for (int a = 0; a < 3; ++a) {
        const int half = (fine_at[a] & 1) + (k >> a & 1);  // 0, 1, 2 along the coarser edge
        on = on && (a == axis || half == 1 || half == 2 * (c >> a & 1));
      }
      if (on) r.coarse[size_t(r.count++)] = c;
    }
  }
  return rim;
}

using Ancestors = std::vector<std::pair<int32_t, double>>;  // previous nodes and weights, sorted

/// In terms of previous nodes that do not hang, so that equal states are equal lists.
Ancestors resolve(const LatticeTopology& previous, const Ancestors& from) {
  std::map<int32_t, double> sum;
  for (auto [n, w] : from) {
    const auto h = std::lower_bound(previous.hanging.begin(), previous.hanging.end(), n,
                                    [](const LatticeTopology::Hanging& a, int32_t b) { return a.node < b; });
    if (h == previous.hanging.end() || h->node != n) {
      sum[n] += w;
      continue;
    }
    for (int k = 0; k < h->count; ++k) sum[h->master[size_t(k)]] += w / h->count;
  }
  return {sum.begin(), sum.end()};
}

/// A corner of a part in terms of the nodes of the copy that it was cut from.
Ancestors within(const CellCopy& whole, int part, int corner) {
  std::map<int32_t, double> sum;
  for (int b = 0; b < 8; ++b) {
    double w = 1;
    for (int a = 0; a < 3; ++a) {
      const int half = (part >> a & 1) + (corner >> a & 1);
      w *= (b >> a & 1 ? half : 2 - half) / 2.0;
    }
    if (w > 0) sum[whole.node[size_t(b)]] += w;
  }
  return {sum.begin(), sum.end()};
}

}  // namespace

void number_nodes(LatticeTopology& t, const LatticeTopology* previous) {
  Partition corners;
  corners.reset(8 * t.cells.size());
  struct Hang {
    int32_t corner, count;
    std::array<int32_t, 4> master;  // corners
  };
  std::vector<Hang> hangs;
  for (const auto& l : t.links) {
    const int32_t cell = l.cell_axis / 3, axis = l.cell_axis % 3, bit = kLowToHigh[axis];
    const int32_t a = t.copy(cell, l.low), b = t.copy(l.next, l.high);
    const int low = t.tree.level(cell), high = t.tree.level(l.next);
    if (low == high) {
      for (int k = 0; k < 8; ++k)
        if (!(k & bit)) corners.unite(8 * a + (k | bit), 8 * b + k);
      continue;
    }
    const bool fine_is_low = low > high;
    const int32_t fine = fine_is_low ? a : b, coarse = fine_is_low ? b : a;
    for (const Rim& r : rim_of(t.tree.place(t.grid, fine_is_low ? cell : l.next).at, axis, fine_is_low)) {
      if (r.count == 1) {
        corners.unite(8 * fine + r.fine, 8 * coarse + r.coarse[0]);
        continue;
      }
      Hang h{8 * fine + r.fine, r.count, {}};
      for (int k = 0; k < r.count; ++k) h.master[size_t(k)] = 8 * coarse + r.coarse[size_t(k)];
      hangs.push_back(h);
    }
  }
  // One set of masters per hanging node: those of all that it hangs on are joined, place by place. Masters never hang.
  std::map<int32_t, Hang> hang_of;
  for (const Hang& h : hangs) {
    const auto [it, is_new] = hang_of.try_emplace(corners.find(h.corner), h);
    if (is_new) continue;
    if (it->second.count != h.count) throw std::logic_error("a node hangs on an edge and on a square");
    for (size_t k = 0; k < size_t(h.count); ++k) corners.unite(h.master[k], it->second.master[k]);
  }

  // Groups in the order of their first corner, each with its parent: one previous node, or several for a node inside a
  // cell that has been divided.
  struct Group {
    NodeCopy node;
    int32_t parent = -1;
    int32_t born = -1;  // index into `ancestors`
  };
  const int32_t known = previous ? int32_t(previous->components.size()) : 0;  // ids from here on are new parts
  std::vector<int32_t> group_of(8 * t.cells.size(), -1);
  std::vector<Group> group;
  std::vector<Ancestors> ancestors;
  const SharedArray<CellCopy>& cells = t.cells;
  for (size_t c = 0; c < cells.size(); ++c) {
    const CellCopy& copy = cells[c];
    const CellPlace place = t.tree.place(t.grid, copy.cell);
    const int size = kQuarters >> place.level;
    const bool is_new_part = previous && copy.cell >= known;
    for (int k = 0; k < 8; ++k) {
      int32_t& g = group_of[size_t(corners.find(int32_t(8 * c) + k))];
      Ancestors from;
      int32_t parent = -1;
      if (is_new_part) {
        from = within(previous->cells[size_t(t.cell_parent[c])], t.tree.which_part(copy.cell), k);
        if (from.size() == 1) parent = from[0].first;
      } else if (previous) {
        parent = previous->cells[size_t(t.cell_parent[c])].node[size_t(k)];
      }
      if (g < 0) {
        g = int32_t(group.size());
        Group made;
        const Int3 at{size * (place.at.x + (k & 1)), size * (place.at.y + (k >> 1 & 1)),
                      size * (place.at.z + (k >> 2 & 1))};
        const bool off = at.x % kQuarters || at.y % kQuarters || at.z % kQuarters;
        made.node.at = at;
        made.node.lattice_node =
            off ? -1 : t.grid.node_index({at.x / kQuarters, at.y / kQuarters, at.z / kQuarters});
        made.parent = parent;
        if (from.size() > 1) made.born = int32_t(ancestors.size()), ancestors.push_back(from);
        group.push_back(made);
        continue;
      }
      Group& seen = group[size_t(g)];
      if (seen.born < 0 && parent == seen.parent && from.size() < 2) continue;
      const Ancestors mine = resolve(*previous, from.size() > 1 ? from : Ancestors{{parent, 1.0}});
      const Ancestors others =
          resolve(*previous, seen.born >= 0 ? ancestors[size_t(seen.born)] : Ancestors{{seen.parent, 1.0}});
      if (mine != others)
        throw std::logic_error("a cut has joined two node copies: the lattice is not a refinement of the one before");
      if (from.size() < 2) seen.born = -1, seen.parent = parent;  // a node that was there before stays that node
    }
  }
  std::vector<int32_t> number(group.size(), -1);
  t.nodes.clear();
  t.nodes.reserve(group.size());
  std::vector<int32_t> parents;
  parents.reserve(group.size());
  auto push = [&](size_t g) {
    number[g] = int32_t(t.nodes.size());
    t.nodes.push_back(group[g].node);
    parents.push_back(group[g].parent);
  };
  if (previous) {  // first child of each parent, in the parents' order
    std::vector<int32_t> first_child(previous->nodes.size(), -1);
    for (size_t g = 0; g < group.size(); ++g)
      if (group[g].born < 0 && first_child[size_t(group[g].parent)] < 0)
        first_child[size_t(group[g].parent)] = int32_t(g);
    for (int32_t g : first_child)
      if (g >= 0) push(size_t(g));
  }
  for (size_t g = 0; g < group.size(); ++g)
    if (number[g] < 0) push(g);
  t.born.clear();
  for (size_t g = 0; g < group.size(); ++g) {
    if (group[g].born < 0) continue;
    const Ancestors& from = ancestors[size_t(group[g].born)];
    size_t most = 0;
    for (size_t i = 1; i < from.size(); ++i)
      if (from[i].second > from[most].second) most = i;
    parents[size_t(number[g])] = from[most].first;
    t.born.push_back({number[g], from});
  }
  t.node_parent = std::move(parents);
  std::sort(t.born.begin(), t.born.end(), [](const auto& a, const auto& b) { return a.node < b.node; });
  auto node_of = [&](int32_t corner) { return number[size_t(group_of[size_t(corners.find(corner))])]; };
  for (size_t c = 0; c < t.cells.size(); ++c)
    for (int k = 0; k < 8; ++k) t.cells[c].node[size_t(k)] = node_of(int32_t(8 * c) + k);
  t.hanging.clear();
  for (const auto& [root, h] : hang_of) {
    LatticeTopology::Hanging out;
    out.node = node_of(root);
    out.count = h.count;
    for (size_t k = 0; k < size_t(h.count); ++k) out.master[k] = node_of(h.master[k]);
    t.hanging.push_back(out);
  }
  std::sort(t.hanging.begin(), t.hanging.end(), [](const auto& a, const auto& b) { return a.node < b.node; });
}

// In binary fractions of a cell, so that sums do not depend on their order and a cut changes them exactly.
int128 exact_share(double fraction, int level) { return int128(std::ldexp(fraction, 60 - 3 * level)); }

void volumes_from_sums(LatticeTopology& t) {
  const Vec3 h = t.grid.cell_mm();
  t.piece_volume_mm3.clear();
  t.volume_mm3 = 0;
  for (const int128& sum : t.piece_sum) {
    t.piece_volume_mm3.push_back(std::ldexp(double(sum), -60) * h.prod());
    t.volume_mm3 += t.piece_volume_mm3.back();
  }
}

uint64_t LatticeTopology::hash() const {
  Hash64 sum;
  for (size_t cell = 0; cell < components.size(); ++cell) {
    const auto& comp = components[cell];
    for (int k = 0; k < copies_of(int32_t(cell)); ++k) {
      sum.add(int32_t(cell));
      sum.add(comp ? comp->classes[size_t(k)].corners : uint8_t(255));
      for (int32_t n : cells[size_t(copy(int32_t(cell), k))].node) sum.add(n);
    }
  }
  sum.add(pieces);
  return sum.value();
}

void summarise(LatticeTopology& t) {
  Partition join;
  join.reset(t.cells.size());
  for (const auto& l : t.links)
    join.unite(t.copy(l.cell_axis / 3, l.low), t.copy(l.next, l.high));
  const SharedArray<CellCopy>& cells = t.cells;
  std::vector<int32_t> piece_of(cells.size(), -1);
  t.pieces = 0;
  t.piece_sum.clear();
  const bool divided = !t.tree.division.empty();
  for (size_t c = 0; c < cells.size(); ++c) {
    int32_t& p = piece_of[size_t(join.find(int32_t(c)))];
    if (p < 0) p = t.pieces++, t.piece_sum.push_back(0);
    if (cells[c].piece != p) t.cells[c].piece = p;
    t.piece_sum[size_t(p)] += exact_share(cells[c].fraction, divided ? t.tree.level(cells[c].cell) : 0);
  }
  volumes_from_sums(t);
  t.piece_fixed.assign(size_t(t.pieces), 0);
  t.walks = t.walks_unresolved = 0;
  for (size_t cell = 0; cell < t.components.size(); ++cell) {
    const auto& comp = std::as_const(t.components)[cell];
    if (!comp) continue;
    for (size_t k = 0; k < comp->classes.size(); ++k)
      if (comp->classes[k].fixed_sides) t.piece_fixed[size_t(cells[size_t(t.copy(int32_t(cell), int(k)))].piece)] = 1;
    t.walks += comp->walks, t.walks_unresolved += comp->walks_unresolved;
  }
}

}  // namespace limberg
