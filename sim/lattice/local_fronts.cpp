// finish_topology at the cost of what has changed, where cells can be divided: after a cut that takes nothing away, and
// after a division. The result is that of finish_topology to the last bit.
//
//   copies  every old copy has a part, the first of which keeps its number; others come after
//   links   only through squares of cells that have changed
//   nodes   number_nodes() for the corners of undivided cells in which
//           a cell has come apart, has been divided or has other
//           links. A node that hangs lies on a square of an undivided
//           cell together with what it hangs on, so such cells close
//           over what hangs; and all that can say who is one node with
//           whom lies within two undivided cells of them
//   pieces  none has come apart when the changed copies of each are
//           still linked among themselves; else they are found again
#include <algorithm>
#include <utility>

#include "sim/lattice/topology_parts.h"

namespace limberg {
namespace {

class LocalFronts {
 public:
  LocalFronts(LatticeTopology& t, LevelBuilders& builders, const LatticeTopology& before,
              std::span<const int32_t> touched, const NewParts& parts)
      : t_(t),
        builders_(builders),
        before_(before),
        parts_(parts),
        descent_(t, parts),
        cells_(t.cells),
        changed_set_(size_t(t.tree.ids())),
        region_{{}, {}, NumberSet(size_t(t.tree.grid_cells))} {
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
    find_region();
    if (!number_nodes(t_, &before_, parts_, &region_)) return false;
    summarise();
    return true;
  }

 private:
  void number_copies();
  void relink();
  void find_region();
  void summarise();
  int class_before(int32_t cell, int cls) const {
    if (descent_.is_new(cell)) return descent_.class_before(cell, cls);
    const auto& comp = std::as_const(t_.components)[size_t(cell)];
    return comp ? comp->classes[size_t(cls)].old_class : cls;
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
  std::vector<int32_t> changed_;        // cells that are not divided, ascending: touched ones and new parts
  NumberSet changed_set_;
  NodeRegion region_;
};

bool LocalFronts::possible() const {
  NumberSet has_part(before_.cells.size());
  NumberSet asked(before_.components.size());
  for (int32_t c : changed_) {
    const int32_t was = descent_.cell_before(c);
    asked.add(was);
    if (!descent_.is_new(c) && !std::as_const(t_.components)[size_t(c)] && before_.components[size_t(c)]) return false;
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

void LocalFronts::number_copies() {
  t_.cell_parent = ParentList::identity(before_.cells.size());
  t_.copies.resize(size_t(t_.tree.ids()));
  NumberSet taken(before_.cells.size());
  std::vector<int32_t> list;
  for (int32_t c : changed_) {
    const auto& comp = std::as_const(t_.components)[size_t(c)];
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
      copy.cell = c;
      copy.fraction = comp ? comp->classes[size_t(k)].fraction : 1;
      t_.cells.set(size_t(id), copy);
      list.push_back(id);
    }
    if (int32_t(list.size()) != before_.copies_of(was) || was != c) region_.changed.add(grid_cell(c));
    t_.copies.set(size_t(c), list);
  }
  for (int32_t c = 0; c < int32_t(parts_.whole.size()); ++c)
    t_.copies.set(size_t(std::as_const(t_.tree.division)[size_t((parts_.known - t_.tree.grid_cells) / 8 + c)].cell),
                  {});
}

void LocalFronts::relink() {
  // Squares between a changed cell and another, by the cell on
  // their low side; and all those of cells that are divided now.
  std::vector<int32_t> squares, beyond;
  for (int32_t c : changed_)
    for (int axis = 0; axis < 3 && t_.copies_of(c) > 0; ++axis) {
      squares.push_back(3 * c + axis);
      cells_beyond(t_, c, axis, beyond, false);
      for (int32_t below : beyond) squares.push_back(3 * below + axis);
    }
  for (size_t d = size_t(parts_.known - t_.tree.grid_cells) / 8; d < std::as_const(t_.tree.division).size(); ++d)
    for (int axis = 0; axis < 3; ++axis) squares.push_back(3 * std::as_const(t_.tree.division)[d].cell + axis);
  std::sort(squares.begin(), squares.end());
  squares.erase(std::unique(squares.begin(), squares.end()), squares.end());
  std::vector<Link> fresh, links;
  std::vector<int32_t> other;
  for (int32_t s : squares) {
    fresh.clear();
    const int32_t cell = s / 3;
    const std::span<const Link> was = before_.links.of(s);
    if (!t_.tree.is_divided(cell) && t_.copies_of(cell) > 0) {
      cells_beyond(t_, cell, s % 3, beyond);
      for (int32_t next : beyond)
        if (changed_set_.has(cell) || changed_set_.has(next)) find_links(t_, builders_, cell, s % 3, next, fresh);
      // What has not changed on either side stays.
      if (!changed_set_.has(cell))
        for (const Link& l : was)
          if (!changed_set_.has(l.next) && !t_.tree.is_divided(l.next)) fresh.push_back(l);
      std::sort(fresh.begin(), fresh.end());
    }
    if (std::equal(was.begin(), was.end(), fresh.begin(), fresh.end())) continue;
    other.push_back(s);
    links.insert(links.end(), fresh.begin(), fresh.end());
    region_.changed.add(grid_cell(cell));
    for (const Link& l : was) region_.changed.add(grid_cell(l.next));
    for (const Link& l : fresh) region_.changed.add(grid_cell(l.next));
  }
  t_.links.replace(other, links);
}

void LocalFronts::find_region() {
  NumberSet near(size_t(t_.tree.grid_cells));
  for (int32_t c : region_.changed.ascending()) {
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
  for (int32_t c : near.ascending()) add_leaves(c, region_.cells);
  std::sort(region_.cells.begin(), region_.cells.end());
  for (int32_t c : region_.cells)
    for (int k = 0; k < t_.copies_of(c); ++k) region_.copies.push_back(t_.copy(c, k));
  std::sort(region_.copies.begin(), region_.copies.end());
}

void LocalFronts::summarise() {
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
    if (const auto& now = std::as_const(t_.components)[size_t(c)])
      t_.walks += now->walks, t_.walks_unresolved += now->walks_unresolved;
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

bool finish_fronts_locally(LatticeTopology& topology, LevelBuilders& builders, const LatticeTopology& previous,
                           std::span<const int32_t> touched, const NewParts& parts) {
  LocalFronts update(topology, builders, previous, touched, parts);
  return update.possible() && update.run();
}

}  // namespace limberg
