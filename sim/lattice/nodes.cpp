// Node copies: classes of cell corners under the links, their parents, and what hangs.
#include <algorithm>
#include <cmath>
#include <utility>

#include "sim/base/hash.h"
#include "sim/base/union_find.h"
#include "sim/lattice/contradiction.h"
#include "sim/lattice/topology_parts.h"

namespace limberg {
namespace {

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

void sort_and_merge(Ancestors& a) {
  std::sort(a.begin(), a.end(), [](const auto& p, const auto& q) { return p.first < q.first; });
  size_t n = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    if (n > 0 && a[n - 1].first == a[i].first)
      a[n - 1].second += a[i].second;
    else
      a[n++] = a[i];
  }
  a.resize(n);
}

/// In terms of previous nodes that do not hang, so that equal states are equal lists.
Ancestors resolve(const LatticeTopology& previous, const Ancestors& from) {
  Ancestors sum;
  for (auto [n, w] : from) {
    const LatticeTopology::Hanging* h = previous.hanging_at(n);
    if (!h) {
      sum.push_back({n, w});
      continue;
    }
    for (int k = 0; k < h->count; ++k) sum.push_back({h->master[size_t(k)], w / h->count});
  }
  sort_and_merge(sum);
  return sum;
}

/// A corner of a part in terms of the nodes of the copy that it was cut from, be it several divisions ago.
void within(const CellCopy& whole, const CellPlace& whole_at, const CellPlace& part, int corner, Ancestors& out) {
  out.clear();
  std::array<double, 3> s;  // exact: binary fractions
  for (int a = 0; a < 3; ++a)
    s[size_t(a)] = double(part.at[a] + (corner >> a & 1)) / double(1 << (part.level - whole_at.level)) - whole_at.at[a];
  for (int b = 0; b < 8; ++b) {
    double w = 1;
    for (int a = 0; a < 3; ++a) w *= b >> a & 1 ? s[size_t(a)] : 1 - s[size_t(a)];
    if (w > 0) out.push_back({whole.node[size_t(b)], w});
  }
  sort_and_merge(out);
}

/// Whether a place (eighths) lies in one of the undivided cells or on its border.
bool touches(const LatticeGrid& grid, const NumberSet& cells, Int3 at) {
  Int3 low, high;
  for (int a = 0; a < 3; ++a) {
    const int32_t l = std::max(0, at[a] % kEighths ? at[a] / kEighths : at[a] / kEighths - 1);
    const int32_t h = std::min(grid.count[a] - 1, at[a] / kEighths);
    (a == 0 ? low.x : a == 1 ? low.y : low.z) = l, (a == 0 ? high.x : a == 1 ? high.y : high.z) = h;
  }
  for (int32_t z = low.z; z <= high.z; ++z)
    for (int32_t y = low.y; y <= high.y; ++y)
      for (int32_t x = low.x; x <= high.x; ++x)
        if (cells.has(grid.cell_index({x, y, z}))) return true;
  return false;
}

/// The corners of the copies that have a say: of all, or of those of a region.
class Numbering {
 public:
  Numbering(LatticeTopology& t, const LatticeTopology* previous, const NewParts& parts, const NodeRegion* region)
      : t_(t),
        previous_(previous),
        parts_(parts),
        region_(region),
        n_(region ? region->copies.size() : t.cells.size()) {
    if (!region) return;
    slot_.assign(t.cells.size(), -1);
    for (size_t i = 0; i < n_; ++i) slot_[size_t(region->copies[i])] = int32_t(i);
  }
  bool run() {
    join();
    hang_together();
    find_groups();
    if (!find_numbers()) return false;
    write();
    return true;
  }

 private:
  struct Hang {
    int32_t root, corner, count;
    std::array<int32_t, 4> master;  // corners
  };
  /// Nodes in the order of their first corner, each with its parent: one previous node, or several for a node inside a
  /// cell that has been divided.
  struct Group {
    NodeCopy node;
    int32_t parent = -1;
    int32_t born = -1;  // index into ancestors_
  };
  void join();
  void join(const Link& l);
  void hang_together();
  void find_groups();
  bool find_numbers();
  void write();
  size_t copy_of(size_t i) const { return region_ ? size_t(region_->copies[i]) : i; }
  int32_t slot(int32_t copy) const { return region_ ? slot_[size_t(copy)] : copy; }
  bool again(Int3 at) const { return !region_ || touches(t_.grid, region_->changed, at); }
  int32_t node_of(int32_t corner) {
    const int32_t g = group_of_[size_t(corners_.find(corner))];
    return g >= 0 ? number_[size_t(g)] : std::as_const(t_.cells)[copy_of(size_t(corner) / 8)].node[size_t(corner % 8)];
  }

  LatticeTopology& t_;
  const LatticeTopology* previous_;
  const NewParts& parts_;
  const NodeRegion* region_;
  size_t n_;
  std::vector<int32_t> slot_;  // per copy
  UnionFind corners_;          // 8 * slot + corner
  std::vector<Hang> hangs_;    // one per hanging node, by its root
  std::vector<int32_t> group_of_;
  std::vector<Group> group_;
  std::vector<Ancestors> ancestors_;
  std::vector<int32_t> number_, parents_;
  std::vector<int32_t> first_child_;  // per previous node that is looked at
  size_t nodes_ = 0;
};

void Numbering::join(const Link& l) {
  const int32_t cell = l.cell_axis / 3, axis = l.cell_axis % 3, bit = kLowToHigh[axis];
  const int32_t a = slot(t_.copy(cell, l.low)), b = slot(t_.copy(l.next, l.high));
  if (a < 0 || b < 0) return;
  const bool parts = t_.tree.is_part(cell) || t_.tree.is_part(l.next);
  const int low = parts ? t_.tree.level(cell) : 0, high = parts ? t_.tree.level(l.next) : 0;
  if (low == high) {
    for (int k = 0; k < 8; ++k)
      if (!(k & bit)) corners_.unite(8 * a + (k | bit), 8 * b + k);
    return;
  }
  const bool fine_is_low = low > high;
  const int32_t fine = fine_is_low ? a : b, coarse = fine_is_low ? b : a;
  for (const Rim& r : rim_of(t_.tree.place(t_.grid, fine_is_low ? cell : l.next).at, axis, fine_is_low)) {
    if (r.count == 1) {
      corners_.unite(8 * fine + r.fine, 8 * coarse + r.coarse[0]);
      continue;
    }
    Hang h{0, 8 * fine + r.fine, r.count, {}};
    for (int k = 0; k < r.count; ++k) h.master[size_t(k)] = 8 * coarse + r.coarse[size_t(k)];
    hangs_.push_back(h);
  }
}

void Numbering::join() {
  corners_.reset(8 * n_);
  if (!region_) {
    for (const Link& l : t_.links) join(l);
    return;
  }
  for (int32_t cell : region_->cells)
    for (int axis = 0; axis < 3; ++axis)
      for (const Link& l : t_.links.of(3 * cell + axis)) join(l);
}

// One set of masters per hanging node: those of all that it hangs on are joined, place by place. Masters never hang.
void Numbering::hang_together() {
  for (Hang& h : hangs_) h.root = corners_.find(h.corner);
  std::stable_sort(hangs_.begin(), hangs_.end(), [](const Hang& a, const Hang& b) { return a.root < b.root; });
  size_t n = 0;
  for (size_t i = 0; i < hangs_.size(); ++i) {
    if (n == 0 || hangs_[n - 1].root != hangs_[i].root) {
      hangs_[n++] = hangs_[i];
      continue;
    }
    if (hangs_[n - 1].count != hangs_[i].count) throw Contradiction("a node hangs on an edge and on a square");
    for (size_t k = 0; k < size_t(hangs_[i].count); ++k) corners_.unite(hangs_[i].master[k], hangs_[n - 1].master[k]);
  }
  hangs_.resize(n);
}

void Numbering::find_groups() {
  const Descent descent(t_, parts_);
  group_of_.assign(8 * n_, -1);
  const SharedArray<CellCopy>& cells = t_.cells;
  Ancestors from;
  for (size_t i = 0; i < n_; ++i) {
    const size_t c = copy_of(i);
    const CellCopy& copy = cells[c];
    const CellPlace place = t_.tree.place(t_.grid, copy.cell);
    const int size = kEighths >> place.level;
    const bool is_new_part = previous_ && descent.is_new(copy.cell);
    CellPlace whole_at;
    const CellCopy* whole = previous_ ? &previous_->cells[size_t(t_.cell_parent[c])] : nullptr;
    if (is_new_part) whole_at = previous_->tree.place(previous_->grid, whole->cell);
    bool all_again = !region_;
    if (region_) {
      const int32_t grid_cell =
          t_.grid.cell_index({place.at.x >> place.level, place.at.y >> place.level, place.at.z >> place.level});
      all_again = region_->changed.has(grid_cell);
    }
    for (int k = 0; k < 8; ++k) {
      const Int3 at{size * (place.at.x + (k & 1)), size * (place.at.y + (k >> 1 & 1)),
                    size * (place.at.z + (k >> 2 & 1))};
      if (!all_again && !again(at)) continue;
      int32_t& g = group_of_[size_t(corners_.find(int32_t(8 * i) + k))];
      int32_t parent = -1;
      from.clear();
      if (is_new_part) {
        within(*whole, whole_at, place, k, from);
        if (from.size() == 1) parent = from[0].first;
      } else if (whole) {
        parent = whole->node[size_t(k)];
      }
      if (g < 0) {
        g = int32_t(group_.size());
        Group made;
        const bool off = at.x % kEighths || at.y % kEighths || at.z % kEighths;
        made.node.at = at;
        made.node.lattice_node = off ? -1 : t_.grid.node_index({at.x / kEighths, at.y / kEighths, at.z / kEighths});
        made.parent = parent;
        if (from.size() > 1) made.born = int32_t(ancestors_.size()), ancestors_.push_back(from);
        group_.push_back(made);
        continue;
      }
      Group& seen = group_[size_t(g)];
      if (seen.born < 0 && parent == seen.parent && from.size() < 2) continue;
      if (seen.born >= 0 && from.size() > 1 && from == ancestors_[size_t(seen.born)]) continue;
      const Ancestors mine = resolve(*previous_, from.size() > 1 ? from : Ancestors{{parent, 1.0}});
      const Ancestors others =
          resolve(*previous_, seen.born >= 0 ? ancestors_[size_t(seen.born)] : Ancestors{{seen.parent, 1.0}});
      if (mine != others)
        throw Contradiction("a cut has joined two node copies: the lattice is not a refinement of the one before");
      if (from.size() < 2) seen.born = -1, seen.parent = parent;  // a node that was there before stays that node
    }
  }
}

// The first child of each parent comes first, in the parents' order; when cells have been divided it keeps the parent's
// number, and numbers that nobody keeps go to the first of the others.
bool Numbering::find_numbers() {
  number_.assign(group_.size(), -1);
  std::vector<int32_t> old;  // previous nodes that are looked at, ascending
  if (previous_) {
    first_child_.assign(previous_->nodes.size(), -1);
    for (size_t g = 0; g < group_.size(); ++g)
      if (group_[g].born < 0 && first_child_[size_t(group_[g].parent)] < 0)
        first_child_[size_t(group_[g].parent)] = int32_t(g);
    if (region_) {
      NumberSet seen(previous_->nodes.size());
      for (size_t i = 0; i < n_; ++i)
        for (int32_t n : previous_->cells[size_t(t_.cell_parent[copy_of(i)])].node)
          if (!seen.has(n) && again(previous_->nodes[size_t(n)].at)) seen.add(n);
      old = seen.ascending();
    } else {
      old.resize(previous_->nodes.size());
      for (size_t n = 0; n < old.size(); ++n) old[n] = int32_t(n);
    }
  }
  size_t kept = 0;
  for (int32_t n : old) kept += first_child_[size_t(n)] >= 0;
  const size_t gone = old.size() - kept, others = group_.size() - kept;
  const bool stays = !t_.tree.division.empty() && others >= gone;
  if (region_ && gone > 0 && !stays) return false;
  const bool keep = region_ || stays;
  std::vector<int32_t> empty;
  for (int32_t n : old) {
    const int32_t g = first_child_[size_t(n)];
    if (g >= 0)
      number_[size_t(g)] = keep ? n : int32_t(nodes_++);
    else if (keep)
      empty.push_back(n);
  }
  if (keep) nodes_ = previous_->nodes.size();
  size_t next_empty = 0;
  for (int32_t& n : number_)
    if (n < 0) n = next_empty < empty.size() ? empty[next_empty++] : int32_t(nodes_++);
  return true;
}

void Numbering::write() {
  if (region_)
    t_.node_parent = ParentList::identity(previous_->nodes.size());
  else
    parents_.assign(nodes_, -1);
  t_.nodes.resize(nodes_);
  std::vector<int32_t> fresh;  // region: parents of the nodes beyond those of before
  if (region_) fresh.assign(nodes_ - previous_->nodes.size(), -1);
  t_.born.clear();
  std::vector<std::pair<int32_t, int32_t>> moved;  // region: kept numbers with another parent
  for (size_t g = 0; g < group_.size(); ++g) {
    const size_t n = size_t(number_[g]);
    t_.nodes.set(n, group_[g].node);
    int32_t parent = group_[g].parent;
    if (group_[g].born >= 0) {
      const Ancestors& from = ancestors_[size_t(group_[g].born)];
      size_t most = 0;
      for (size_t i = 1; i < from.size(); ++i)
        if (from[i].second > from[most].second) most = i;
      parent = from[most].first;
      t_.born.push_back({int32_t(n), from});
    }
    if (!region_)
      parents_[n] = parent;
    else if (n >= previous_->nodes.size())
      fresh[n - previous_->nodes.size()] = parent;
    else if (parent != int32_t(n))
      moved.push_back({int32_t(n), parent});
  }
  if (region_) {
    for (int32_t p : fresh) t_.node_parent.push_back(p);
    std::sort(moved.begin(), moved.end());
    for (auto [n, p] : moved) t_.node_parent.set(size_t(n), p);
  } else {
    t_.node_parent = std::move(parents_);
  }
  std::sort(t_.born.begin(), t_.born.end(), [](const auto& a, const auto& b) { return a.node < b.node; });

  // What hangs, of the places that were looked at or on nodes of these.
  std::vector<LatticeTopology::Hanging> hanging;
  if (region_)
    for (const LatticeTopology::Hanging& h : previous_->hanging) {
      bool other = again(previous_->nodes[size_t(h.node)].at);
      for (size_t k = 0; k < size_t(h.count); ++k) other = other || again(previous_->nodes[size_t(h.master[k])].at);
      if (!other) hanging.push_back(h);
    }
  const auto at_of = [&](int32_t corner) {
    const CellPlace p = t_.tree.place(t_.grid, std::as_const(t_.cells)[copy_of(size_t(corner) / 8)].cell);
    const int size = kEighths >> p.level, k = corner % 8;
    return Int3{size * (p.at.x + (k & 1)), size * (p.at.y + (k >> 1 & 1)), size * (p.at.z + (k >> 2 & 1))};
  };
  for (const Hang& h : hangs_) {
    bool mine = !region_ || again(at_of(h.corner));
    for (size_t k = 0; k < size_t(h.count) && !mine; ++k) mine = again(at_of(h.master[k]));
    if (!mine) continue;
    LatticeTopology::Hanging out;
    out.node = node_of(h.corner);
    out.count = h.count;
    for (size_t k = 0; k < size_t(h.count); ++k) out.master[k] = node_of(h.master[k]);
    hanging.push_back(out);
  }
  std::sort(hanging.begin(), hanging.end(), [](const auto& a, const auto& b) { return a.node < b.node; });
  t_.hanging = std::move(hanging);

  const SharedArray<CellCopy>& cells = t_.cells;
  for (size_t i = 0; i < n_; ++i) {
    const size_t c = copy_of(i);
    for (size_t k = 0; k < 8; ++k) {
      const int32_t g = group_of_[size_t(corners_.find(int32_t(8 * i + k)))];
      if (g >= 0 && cells[c].node[k] != number_[size_t(g)]) t_.cells[c].node[k] = number_[size_t(g)];
    }
  }
}

}  // namespace

bool number_nodes(LatticeTopology& t, const LatticeTopology* previous, const NewParts& parts,
                  const NodeRegion* region) {
  return Numbering(t, previous, parts, region).run();
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

// Whoever left a changed copy for an unchanged one before comes back to a part of it, so it is enough that the changed
// ones of a piece are linked among themselves.
bool pieces_stay(const LatticeTopology& t, int32_t pieces_before, std::span<const int32_t> changed,
                 std::span<const int32_t> place) {
  std::vector<int32_t> first(changed.size() + 1, 0);  // of the copies of each changed cell
  for (size_t i = 0; i < changed.size(); ++i) first[i + 1] = first[i] + t.copies_of(changed[i]);
  UnionFind join;
  join.reset(size_t(first.back()));
  for (size_t i = 0; i < changed.size(); ++i)
    for (int axis = 0; axis < 3; ++axis)
      for (const Link& l : t.links.of(3 * changed[i] + axis))
        if (const int32_t next = place[size_t(l.next)]; next >= 0)
          join.unite(first[i] + l.low, first[size_t(next)] + l.high);
  std::vector<int32_t> root_of_piece(size_t(pieces_before), -1);
  for (size_t i = 0; i < changed.size(); ++i)
    for (int32_t k = first[i]; k < first[i + 1]; ++k) {
      int32_t& r = root_of_piece[size_t(t.cells[size_t(t.copy(changed[i], k - first[i]))].piece)];
      if (r < 0) r = join.find(k);
      if (r != join.find(k)) return false;
    }
  return true;
}

void summarise(LatticeTopology& t) {
  UnionFind join;
  join.reset(t.cells.size());
  for (const auto& l : t.links) join.unite(t.copy(l.cell_axis / 3, l.low), t.copy(l.next, l.high));
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
