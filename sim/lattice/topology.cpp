#include "sim/lattice/topology.h"

#include <algorithm>
#include <exception>
#include <numeric>
#include <stdexcept>
#include <string>

#include "sim/base/error.h"
#include "sim/base/number_set.h"
#include "sim/cutting/arrangement/point_store.h"
#include "sim/lattice/topology_parts.h"

namespace limberg {
namespace {

uint8_t bits_of(const Face& f) { return f.live() ? f.mat : uint8_t(0); }

void fill_face_bits(LatticeTopology& t, const MaterialSurface& surface) {
  t.face_bits.clear();
  t.face_bits.reserve(surface.faces.size());
  for (const Face& f : surface.faces) t.face_bits.push_back(bits_of(f));
  t.last_op = surface.orig.empty() ? 0 : surface.orig.back().op;
  t.operations = surface.operations();
}

/// Calls visit(cell) for the undivided cells of the box of a face's corners.
template <class Visit>
void cells_around(const CellTree& tree, LevelBuilders& builders, int32_t face, const CellBuilder::Layers& layers,
                  Visit&& visit) {
  struct Box {
    int32_t lo[3], hi[3];
  };
  const LatticeGrid& grid = builders.grid();
  auto box_of = [&](int level, const CellBuilder::Layers& q) {
    Box b;
    for (size_t a = 0; a < 3; ++a) {
      b.lo[a] = std::max(0, std::min({q[0][a], q[1][a], q[2][a]}));
      b.hi[a] = std::min((grid.count[int(a)] << level) - 1, std::max({q[0][a], q[1][a], q[2][a]}));
    }
    return b;
  };
  const Box whole = box_of(0, layers);
  Box fine{};
  bool fine_known = false;
  auto descend = [&](auto&& self, int32_t cell, int level, Int3 at) -> void {
    if (level > 0) {
      const int shift = kLevels - level;
      for (int a = 0; a < 3; ++a)
        if (((at[a] + 1) << shift) - 1 < fine.lo[a] || at[a] << shift > fine.hi[a]) return;
    }
    if (!tree.is_divided(cell)) return visit(cell);
    if (!fine_known) fine = box_of(kLevels, builders[kLevels].layers(face)), fine_known = true;
    for (int k = 0; k < 8; ++k)
      self(self, tree.part(cell, k), level + 1, {2 * at.x + (k & 1), 2 * at.y + (k >> 1 & 1), 2 * at.z + (k >> 2 & 1)});
  };
  for (int32_t z = whole.lo[2]; z <= whole.hi[2]; ++z)
    for (int32_t y = whole.lo[1]; y <= whole.hi[1]; ++y)
      for (int32_t x = whole.lo[0]; x <= whole.hi[0]; ++x) descend(descend, grid.cell_index({x, y, z}), 0, {x, y, z});
}

void relink(LatticeTopology& t, LevelBuilders& builders, const LatticeTopology* previous,
            std::span<const uint8_t> touched) {
  std::vector<Link> fresh, links;
  std::vector<int32_t> beyond;
  for (int32_t cell = 0; cell < t.tree.ids(); ++cell) {
    if (t.copies_of(cell) == 0) continue;  // divided, or without material
    for (int axis = 0; axis < 3; ++axis) {
      cells_beyond(t, cell, axis, beyond);
      for (int32_t next : beyond)
        if (!previous || touched[size_t(cell)] || touched[size_t(next)])
          find_links(t, builders, cell, axis, next, fresh);
    }
  }
  if (previous) {
    links.reserve(previous->links.size() + fresh.size());
    for (const auto& l : previous->links)
      if (!touched[size_t(l.cell_axis / 3)] && !touched[size_t(l.next)]) links.push_back(l);
  }
  const ptrdiff_t kept = ptrdiff_t(links.size());
  links.insert(links.end(), fresh.begin(), fresh.end());
  std::sort(links.begin() + kept, links.end());
  std::inplace_merge(links.begin(), links.begin() + kept, links.end());
  t.links.assign(links);
}

/// Divides what holds a front or is graded, until nothing is left to divide: tree and components. `named` as for
/// divide_cells.
void divide_all(LatticeTopology& t, LevelBuilders& builders, std::vector<int32_t> candidates,
                std::span<const uint8_t> named, NewParts& parts) {
  for (;;) {
    const std::vector<int32_t> cells = cells_to_divide(t, builders, candidates);
    if (cells.empty()) return;
    const int32_t first = t.tree.ids();
    divide_cells(t, builders, cells, named, parts);
    for (int32_t part = first; part < t.tree.ids(); ++part) candidates.push_back(part);
  }
}

/// Cells that an update has changed: the `touched` ones of before, and the parts of those that it has divided.
std::vector<uint8_t> marks_of(const LatticeTopology& t, std::span<const int32_t> touched, const NewParts& parts) {
  std::vector<uint8_t> marks(size_t(t.tree.ids()), 0);
  for (int32_t c : touched) marks[size_t(c)] = 1;
  for (int32_t c = parts.known; c < t.tree.ids(); ++c) marks[size_t(c)] = marks[size_t(t.tree.owner(c))] = 1;
  return marks;
}

/// The version in which these cells are divided as they need it; `before` is finished and has the same surface.
std::shared_ptr<const LatticeTopology> with_divisions(std::shared_ptr<const LatticeTopology> before,
                                                      LevelBuilders& builders, std::vector<int32_t> candidates,
                                                      bool locally) {
  if (!before->divides()) return before;
  auto t = std::make_shared<LatticeTopology>(*before);
  t->touched_cells = 0;
  NewParts parts;
  parts.known = t->tree.ids();
  divide_all(*t, builders, std::move(candidates), {}, parts);
  if (parts.empty()) return before;
  if (!locally || !finish_locally(*t, builders, *before, {}, parts))
    finish_topology(*t, builders, before.get(), marks_of(*t, {}, parts), parts);
  skip_parents(*before, *t);
  return t;
}

/// The components of the touched cells. Each cell is found by
/// itself, in groups that one worker takes one after another.
template <class Candidates>
void find_components(LatticeTopology& t, const LatticeTopology& previous, const MaterialSurface& surface,
                     std::span<const int32_t> touched, const Candidates& candidates_of,
                     std::span<const CellBuilder::Layers> layers_of_new, bool only_cuts, Workers* workers) {
  constexpr size_t kGroup = 16;
  std::vector<std::shared_ptr<const CellComponents>> found(touched.size());
  std::vector<std::exception_ptr> wrong((touched.size() + kGroup - 1) / kGroup);
  const LatticeTopology& now = t;
  const auto find = [&](LevelBuilders& builders, size_t begin, size_t end) {
    builders[0].know_layers(int32_t(previous.face_bits.size()), layers_of_new);
    std::vector<int32_t> candidates;
    for (size_t i = begin; i < end; ++i) {
      const int32_t cell = touched[i];
      if (i + 2 < end)
        if (const CellComponents* later = previous.components[size_t(touched[i + 2])].get()) {
          __builtin_prefetch(later);
          __builtin_prefetch(reinterpret_cast<const char*>(later) + 64);
        }
      if (i + 1 < end)
        if (const CellComponents* later = previous.components[size_t(touched[i + 1])].get())
          for (const void* list :
               {static_cast<const void*>(later->face.data()), static_cast<const void*>(later->relation.data()),
                static_cast<const void*>(later->of_side.data()), static_cast<const void*>(later->flux.data())})
            __builtin_prefetch(list);
      candidates.clear();
      candidates_of(cell, candidates);
      if (!std::is_sorted(candidates.begin(), candidates.end())) std::sort(candidates.begin(), candidates.end());
      const CellPlace place = now.tree.place(now.grid, cell);
      found[i] = builders[place.level].build(
          place.at, candidates, now.corners_in_material(cell),
          {true, previous.components[size_t(cell)].get(), previous.last_op, only_cuts, nullptr});
    }
  };
  // A step that a test lets fail is counted in the order of the cells.
  if (!workers || workers->count() == 1 || surface.points->fault) {
    LevelBuilders builders(t.grid, surface);
    find(builders, 0, touched.size());
  } else {
    workers->parallel_for(touched.size(), kGroup, [&](size_t begin, size_t end) {
      LevelBuilders builders(now.grid, surface);
      try {
        find(builders, begin, end);
      } catch (...) {
        wrong[begin / kGroup] = std::current_exception();
      }
    });
    for (const std::exception_ptr& e : wrong)
      if (e) std::rethrow_exception(e);  // the first cell's, whoever came to it
  }
  for (size_t i = 0; i < touched.size(); ++i) t.components[size_t(touched[i])] = std::move(found[i]);
}

/// The cells of the grid, none divided.
std::shared_ptr<LatticeTopology> build_whole(const LatticeGrid& grid, const MaterialSurface& surface,
                                             LevelBuilders& builders) {
  auto t = std::make_shared<LatticeTopology>();
  t->grid = grid;
  t->node_in_material = classify_nodes(grid, surface);
  fill_face_bits(*t, surface);
  const size_t cells = size_t(grid.count.x) * size_t(grid.count.y) * size_t(grid.count.z);
  t->tree.grid_cells = int32_t(cells);
  // Candidates of each cell, by counting sort: faces stay ascending.
  std::vector<int32_t> begin(cells + 1, 0), list;
  for (int pass = 0; pass < 2; ++pass) {
    for (size_t f = 0; f < surface.faces.size(); ++f)
      if (surface.faces[f].live())
        cells_around(t->tree, builders, int32_t(f), builders[0].layers(int32_t(f)), [&](int32_t c) {
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
    t->components[c] = builders[0].build(grid.cell_at(int32_t(c)), {list.data() + from, size_t(to - from)},
                                         t->corners_in_material(int32_t(c)), {});
    ++t->touched_cells;
  }
  finish_topology(*t, builders, nullptr, {}, {});
  return t;
}

}  // namespace

void finish_topology(LatticeTopology& t, LevelBuilders& builders, const LatticeTopology* previous,
                     std::span<const uint8_t> touched, const NewParts& parts) {
  number_copies(t, previous, touched, parts);
  relink(t, builders, previous, touched);
  if (previous) name_parents_by_neighbours(t, *previous);
  number_nodes(t, previous, parts);
  summarise(t);
}

std::shared_ptr<const LatticeTopology> build_topology(const LatticeGrid& grid, const MaterialSurface& surface,
                                                      int front_levels, const Grading& grading) {
  check_grading(grading);
  const bool divides = front_levels > 0 || !grading.empty();
  if (front_levels < 0 || front_levels > kLevels || (divides && !grid.divisible(kLevels)))
    throw InputError("", 0,
                     "cells of this lattice cannot be divided; a pitch of a multiple of 16 half-units, and at most " +
                         std::to_string(kLevels) + " levels, were expected");
  LevelBuilders builders(grid, surface);
  auto t = build_whole(grid, surface, builders);
  t->front_levels = front_levels, t->grading = grading;
  std::vector<int32_t> all(t->components.size());
  std::iota(all.begin(), all.end(), 0);
  return with_divisions(t, builders, std::move(all), false);
}

std::shared_ptr<const LatticeTopology> build_topology_like(const LatticeTopology& like,
                                                           const MaterialSurface& surface) {
  LevelBuilders builders(like.grid, surface);
  auto whole = build_whole(like.grid, surface, builders);
  whole->front_levels = like.front_levels, whole->grading = like.grading;
  if (like.tree.division.empty()) return whole;
  auto t = std::make_shared<LatticeTopology>(*whole);
  NewParts parts;
  parts.known = t->tree.ids();
  for (const CellTree::Division& d : std::as_const(like.tree.division))
    divide_cells(*t, builders, {&d.cell, 1}, {}, parts);
  finish_topology(*t, builders, whole.get(), marks_of(*t, {}, parts), parts);
  skip_parents(*whole, *t);
  return t;
}

std::shared_ptr<const LatticeTopology> update_topology(const LatticeTopology& previous, const MaterialSurface& surface,
                                                       Workers* workers, Divide divide) {
  return update_topology(previous, surface, true, workers, divide);
}

namespace {

/// Which cells a change of the surface has touched, and what it has added there.
struct Touches {
  std::vector<int32_t> cell;                // ascending
  bool material_has_gone = false;           // a face has lost a side, or a new wall has only one
  std::vector<int32_t> place;               // per cell of the version before, its place in `cell`; -1: not touched
  std::vector<int32_t> first;               // per touched cell and one more, where its faces begin
  std::vector<int32_t> face;                // that were added, ascending in each cell
  std::vector<CellBuilder::Layers> layers;  // per face that is new

  /// All faces that may lie in a cell: those that lay there, and those that were added.
  void candidates(const LatticeTopology& previous, int32_t in, std::vector<int32_t>& out) const {
    if (const CellComponents* old = previous.components[size_t(in)].get())
      out.insert(out.end(), old->face.begin(), old->face.end());
    if (const int32_t at = place[size_t(in)]; at >= 0)
      out.insert(out.end(), face.begin() + first[size_t(at)], face.begin() + first[size_t(at) + 1]);
  }
};

/// Brings t's bits of the faces up to date on the way.
Touches find_touches(LatticeTopology& t, const LatticeTopology& previous, const MaterialSurface& surface,
                     LevelBuilders& builders) {
  const size_t before = previous.face_bits.size(), now = surface.faces.size();
  if (now < before) throw std::logic_error("the surface has lost faces since the lattice's last version");
  Touches out;
  out.layers.resize(now - before);
  NumberSet cells(previous.components.size());
  std::vector<std::pair<int32_t, int32_t>> added;  // cell, face; faces ascend
  const auto look_at = [&](size_t f) {
    const uint8_t was = f < before ? previous.face_bits[f] : uint8_t(0), is = bits_of(surface.faces[f]);
    if (f >= before)
      t.face_bits.push_back(is);
    else if (was != is)
      t.face_bits[f] = is;
    if (was == is) return;
    out.material_has_gone |=
        (!surface.faces[f].retired && (was & ~is)) ||
        (f >= before && is != 3 && surface.orig[size_t(surface.faces[f].orig)].op > previous.last_op);
    const CellBuilder::Layers layers = builders[0].layers(int32_t(f));
    if (f >= before) out.layers[f - before] = layers;
    cells_around(t.tree, builders, int32_t(f), layers, [&](int32_t c) {
      cells.add(c);
      if (is && !was) added.push_back({c, int32_t(f)});
    });
  };
  // Faces and their corners lie all over the surface's arrays: they are fetched ahead.
  constexpr size_t kAhead = 8;
  const std::vector<int32_t> suspects = surface.suspects(previous.operations, before);
  const auto fetch_corners = [&](size_t f) {
    for (int32_t v : surface.faces[f].v) surface.points->prefetch(v);
  };
  for (size_t i = 0; i < suspects.size(); ++i) {
    if (i + 2 * kAhead < suspects.size()) __builtin_prefetch(&surface.faces[size_t(suspects[i + 2 * kAhead])]);
    if (i + kAhead < suspects.size()) fetch_corners(size_t(suspects[i + kAhead]));
    look_at(size_t(suspects[i]));
  }
  for (size_t f = before; f < now; ++f) {
    if (f + kAhead < now) fetch_corners(f + kAhead);
    look_at(f);
  }
  // The added faces by their cells.
  out.cell = cells.ascending();
  out.place.assign(previous.components.size(), -1);
  for (size_t i = 0; i < out.cell.size(); ++i) out.place[size_t(out.cell[i])] = int32_t(i);
  out.first.assign(out.cell.size() + 1, 0);
  for (const auto& [cell, face] : added) ++out.first[size_t(out.place[size_t(cell)]) + 1];
  for (size_t i = 0; i < out.cell.size(); ++i) out.first[i + 1] += out.first[i];
  out.face.resize(added.size());
  std::vector<int32_t> next(out.first.begin(), out.first.end() - 1);
  for (const auto& [cell, face] : added) out.face[size_t(next[size_t(out.place[size_t(cell)])]++)] = face;
  return out;
}

/// Nodes of cells and of their parts, where material has gone: each is asked whether it still lies in some.
void classify_again(LatticeTopology& t, const LatticeTopology& previous, const MaterialSurface& surface,
                    LevelBuilders& builders, const Touches& touches) {
  t.node_in_material = classify_nodes(t.grid, surface);
  const auto within = [&](auto&& self, int32_t cell, std::vector<int32_t>& out) -> void {
    if (!t.tree.is_divided(cell)) return touches.candidates(previous, cell, out);
    for (int k = 0; k < 8; ++k) self(self, t.tree.part(cell, k), out);
  };
  std::vector<int32_t> candidates;
  for (size_t i = 0; i < t.tree.division.size(); ++i) {
    const int32_t cell = std::as_const(t.tree.division)[i].cell;
    candidates.clear();
    within(within, cell, candidates);
    std::sort(candidates.begin(), candidates.end());
    candidates.erase(std::unique(candidates.begin(), candidates.end()), candidates.end());
    t.tree.division[i].node_in_material =
        classify_parts(builders, t.tree.place(t.grid, cell), t.corners_in_material(cell), candidates);
  }
}

}  // namespace

std::shared_ptr<const LatticeTopology> update_topology(const LatticeTopology& previous, const MaterialSurface& surface,
                                                       bool locally, Workers* workers, Divide divide) {
  const auto t = std::make_shared<LatticeTopology>(previous);
  t->hanging.clear();
  t->born.clear();
  LevelBuilders builders(t->grid, surface);
  const Touches touches = find_touches(*t, previous, surface, builders);
  const std::vector<int32_t>& touched = touches.cell;
  t->last_op = surface.orig.empty() ? 0 : surface.orig.back().op;
  t->operations = surface.operations();
  t->touched_cells = int(touched.size());
  // Where no material has gone, nodes are in the material that were, and so are the parts' corners.
  if (touches.material_has_gone) classify_again(*t, previous, surface, builders, touches);
  const auto candidates_of = [&](int32_t cell, std::vector<int32_t>& out) { touches.candidates(previous, cell, out); };
  find_components(*t, previous, surface, touched, candidates_of, touches.layers, !touches.material_has_gone, workers);

  NewParts parts;
  parts.known = previous.tree.ids();
  std::vector<uint8_t> marks = marks_of(*t, touched, parts);
  if (touches.material_has_gone) {  // what is left names its parents first, and is divided then
    std::vector<int32_t> changed = touched;
    for (size_t c = 0; c < marks.size(); ++c) {  // full cells that are empty now
      if (previous.components[c] || marks[c] || t->tree.is_divided(int32_t(c))) continue;
      if (previous.corners_in_material(int32_t(c)) != t->corners_in_material(int32_t(c)))
        marks[c] = 1, changed.push_back(int32_t(c));
    }
    finish_topology(*t, builders, &previous, marks, parts);
    if (divide == Divide::nothing) return t;
    std::sort(changed.begin(), changed.end());
    return with_divisions(t, builders, std::move(changed), locally);
  }
  if (t->divides() && divide == Divide::fronts) divide_all(*t, builders, touched, marks, parts);
  if (!locally || !finish_locally(*t, builders, previous, touched, parts))
    finish_topology(*t, builders, &previous, marks_of(*t, touched, parts), parts);
  return t;
}

}  // namespace limberg
