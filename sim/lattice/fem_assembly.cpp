#include "sim/lattice/fem_assembly.h"

#include <algorithm>
#include <numeric>
#include <span>

#include "sim/base/number_set.h"
#include "sim/lattice/contradiction.h"
#include "sim/lattice/copy_layers.h"

namespace limberg {
namespace {

// A block's outermost cells miss this little at most (grid_fit.h): half of `count` half-units of thousands per cell,
// eight times that when cells can be divided, and in a part it is more of the whole.
double counts_as_full(bool divisible, int level) { return 1 - (divisible ? 0.006 : 0.002) * double(1 << level); }

class Assembly {
 public:
  Assembly(const StencilTable& table, const LatticeTopology& t, const MaterialSurface* surface)
      : table_(table), t_(t), surface_(surface), whole_mm3_(t.grid.cell_mm().prod()) {}

  HexCell cell(int32_t id) const {
    const CellCopy& copy = t_.cells[size_t(id)];
    HexCell out;
    out.node = copy.node;
    const CellPlace place = t_.tree.place(t_.grid, copy.cell);
    for (int a = 0; a < 3; ++a) out.at[size_t(a)] = int16_t(2 * place.at[a] >> place.level);
    out.level = uint8_t(place.level);
    out.stencil = stencil(id, table_.of_place(place));
    if (out.stencil < 0) throw Contradiction("material in a lattice cell for which there is no stencil");
    out.scale = scale(copy.fraction, place.level, out.stencil);
    return out;
  }
  int32_t stencil(int32_t id, int32_t whole) const {
    const int32_t cell = t_.cells[size_t(id)].cell;
    if (surface_ && t_.components[size_t(cell)])
      for (int k = 0; k < t_.copies_of(cell); ++k)
        if (t_.copy(cell, k) == id) return stencil_of_copy(table_, *surface_, t_, cell, k, whole);
    return whole;
  }
  float scale(double fraction, int level, int32_t stencil) const {
    const double whole = whole_mm3_ / double(1 << 3 * level), body = table_.body_mm3(stencil);
    if (body != whole) return float(std::max(fraction, kLeastFraction) * whole / body);
    return fraction > counts_as_full(t_.divides(), level) ? 1.0f : float(std::max(fraction, kLeastFraction));
  }
  double mass_kg(const CellCopy& copy, const HexCell& cell) const {
    // A part weighs as the cell that it is a part of, so that division does not change the mass; a copy with layers of
    // its own by so much more or less as they do. Those are rounded (kShareSteps), and with them the mass after a cut.
    const CellPlace place = t_.tree.place(t_.grid, copy.cell);
    const int32_t undivided = table_.of_cell(
        t_.grid.cell_index({place.at.x >> place.level, place.at.y >> place.level, place.at.z >> place.level}));
    const auto density = [&](int32_t stencil) { return table_.stencils()[size_t(stencil)].density_kg_mm3; };
    const double volume = whole_mm3_ / double(1 << 3 * cell.level);
    const double mass = std::max(copy.fraction, 0.0) * volume * density(undivided);
    const int32_t mixture = table_.of_place(place);
    if (table_.held_corners(mixture)) return mass;  // whichever of its corners are held
    return cell.stencil == mixture ? mass : mass * density(cell.stencil) / density(mixture);
  }
  /// A stencil for held corners takes for granted that they are: where a copy's are not, it takes another.
  void hold_as_found(FemModel& model, int32_t id, const std::vector<uint8_t>& carried) const {
    const CellCopy& copy = t_.cells[size_t(id)];
    const CellPlace place = t_.tree.place(t_.grid, copy.cell);
    const int32_t usual = table_.of_place(place);
    const uint8_t taken = usual < 0 ? 0 : table_.held_corners(usual);
    if (!taken) return;
    uint8_t held = taken;
    for (size_t k = 0; k < 8; ++k) {
      const size_t n = size_t(copy.node[k]);
      if (!model.fixed[n].any() && !carried[n]) held &= uint8_t(~(1u << k));
    }
    HexCell now = model.cells[size_t(id)];
    const int32_t found = stencil(id, held == taken ? usual : table_.of_place(place, held));
    if (found == now.stencil) return;
    now.stencil = found, now.scale = scale(copy.fraction, now.level, found);
    model.cells.set(size_t(id), now);
  }
  void hold_as_found(FemModel& model, std::span<const int32_t> ids) const {
    if (!table_.any_held_corners()) return;
    // A node that hangs is held where all of its masters are: half held it goes half their way.
    std::vector<uint8_t> carried(t_.nodes.size(), 0);
    for (const auto& h : t_.hanging) {
      bool all = true;
      for (size_t k = 0; k < size_t(h.count); ++k) all = all && model.fixed[size_t(h.master[k])].any();
      carried[size_t(h.node)] = all;
    }
    for (int32_t id : ids) hold_as_found(model, id, carried);
  }
  /// What of the node at its corner a copy holds.
  Held holds(int32_t cell, uint8_t fixed_sides, int32_t node, size_t corner) const {
    const uint8_t may = table_.fixed_candidate(t_.nodes[size_t(node)].at);
    Held h = (may & StencilTable::kNearFixed) ||
             ((may & StencilTable::kFarFixed) && !(t_.corners_in_material(cell) >> corner & 1));
    for (int side = 0; side < 6; ++side)
      if ((may & fixed_sides) >> side & 1) h |= table_.slides(side) ? Held::axis(side / 2) : Held(true);
    return h;
  }

  void all(FemModel& model) const;
  /// After a cut that takes nothing away: what it has not changed is shared.
  void changed(FemModel& model, const EarlierModel& before) const;

 private:
  void nodes_again(FemModel& model, std::span<const int32_t> nodes) const;

  const StencilTable& table_;
  const LatticeTopology& t_;
  const MaterialSurface* surface_;
  double whole_mm3_;
};

void Assembly::all(FemModel& model) const {
  const size_t nodes = t_.nodes.size();
  for (const NodeCopy& n : t_.nodes) model.X_mm.push_back(t_.grid.eighth_mm(n.at));
  std::vector<Held> fixed(nodes);
  std::vector<double> mass(nodes, 0);
  model.cells.reserve(t_.cells.size());
  for (size_t id = 0; id < t_.cells.size(); ++id) {
    const CellCopy& copy = t_.cells[id];
    const HexCell made = cell(int32_t(id));
    model.cells.push_back(made);
    const double share = mass_kg(copy, made) / 8;
    for (int32_t n : copy.node) mass[size_t(n)] += share;
  }
  for (size_t c = 0; c < t_.components.size(); ++c) {
    const auto& comp = t_.components[c];
    if (!comp) continue;
    for (size_t k = 0; k < comp->classes.size(); ++k) {
      if (!comp->classes[k].fixed_sides) continue;
      const auto& node = t_.cells[size_t(t_.copy(int32_t(c), int(k)))].node;
      for (size_t corner = 0; corner < 8; ++corner)
        fixed[size_t(node[corner])] |= holds(int32_t(c), comp->classes[k].fixed_sides, node[corner], corner);
    }
  }
  for (const auto& h : t_.hanging) fixed[size_t(h.node)] = false;  // its masters hold it
  model.fixed = fixed;
  std::vector<int32_t> every(t_.cells.size());
  std::iota(every.begin(), every.end(), 0);
  hold_as_found(model, every);
  model.mass_kg = mass;
}

void Assembly::changed(FemModel& model, const EarlierModel& before) const {
  model.X_mm = before.model.X_mm;
  model.cells = before.model.cells;
  model.fixed = before.model.fixed;
  model.mass_kg = before.model.mass_kg;
  model.X_mm.resize(t_.nodes.size(), Vec3::Zero());
  model.fixed.resize(t_.nodes.size());
  model.mass_kg.resize(t_.nodes.size(), 0);
  NumberSet nodes(t_.nodes.size());  // whose cells have changed
  std::vector<int32_t> carried;
  for_each_change(before.topology.nodes, t_.nodes, [&](size_t n) {
    model.X_mm[n] = t_.grid.eighth_mm(t_.nodes[n].at);
    nodes.add(int32_t(n));
  });
  for_each_change(before.topology.cells, t_.cells, [&](size_t c) {
    const CellCopy& copy = t_.cells[c];
    const size_t parent = size_t(t_.cell_parent[c]);
    HexCell now = before.model.cells[parent];
    if (copy.cell == before.topology.cells[parent].cell) {
      now.node = copy.node;
      if (surface_) now.stencil = stencil(int32_t(c), table_.of_place(t_.tree.place(t_.grid, copy.cell)));
      now.scale = scale(copy.fraction, now.level, now.stencil);
    } else {
      now = cell(int32_t(c));
    }
    if (c < model.cells.size())
      model.cells.set(c, now);
    else
      model.cells.push_back(now);
    nodes.add_all(copy.node);
    nodes.add_all(before.topology.cells[parent].node);
  });
  // A held face may be in another part now.
  const auto holds_any = [](const std::shared_ptr<const CellComponents>& c) {
    return c &&
           std::any_of(c->classes.begin(), c->classes.end(), [](const CellClass& k) { return k.fixed_sides != 0; });
  };
  for_each_change(before.topology.components, t_.components, [&](size_t cell) {
    if (cell >= before.topology.components.size()) return;  // a part: all its nodes are looked at already
    if (!holds_any(t_.components[cell]) && !holds_any(before.topology.components[cell])) return;
    for (int k = 0; k < t_.copies_of(int32_t(cell)); ++k)
      nodes.add_all(t_.cells[size_t(t_.copy(int32_t(cell), k))].node);
  });
  // Whether a node that hangs is held is said by its masters.
  for (const auto& h : t_.hanging)
    for (size_t k = 0; k < size_t(h.count); ++k)
      if (nodes.has(h.master[k])) carried.push_back(h.node);
  nodes.add_all(carried);
  nodes_again(model, nodes.ascending());
}

// From the copies around them, in their order: each copy is looked at once, for all of its corners.
void Assembly::nodes_again(FemModel& model, std::span<const int32_t> nodes) const {
  NumberSet cells(t_.components.size()), copies(t_.cells.size());
  const LatticeGrid finest = t_.grid.at_level(kLevels);
  for (int32_t n : nodes) {
    const Int3 at = t_.nodes[size_t(n)].at;
    for (int b = 0; b < 8; ++b) {
      const Int3 c{at.x - 1 + (b & 1), at.y - 1 + (b >> 1 & 1), at.z - 1 + (b >> 2 & 1)};
      if (c.x < 0 || c.y < 0 || c.z < 0 || c.x >= finest.count.x || c.y >= finest.count.y || c.z >= finest.count.z)
        continue;
      cells.add(t_.tree.find(t_.grid, kLevels, c));
    }
  }
  for (int32_t c : cells.ascending())
    for (int k = 0; k < t_.copies_of(c); ++k) copies.add(t_.copy(c, k));
  std::vector<int32_t> place(t_.nodes.size(), -1);
  for (size_t i = 0; i < nodes.size(); ++i) place[size_t(nodes[i])] = int32_t(i);
  std::vector<double> mass(nodes.size(), 0);
  std::vector<Held> fixed(nodes.size());
  const SharedArray<HexCell>& made = model.cells;
  for (int32_t id : copies.ascending()) {
    const CellCopy& copy = t_.cells[size_t(id)];
    const double share = mass_kg(copy, made[size_t(id)]) / 8;
    uint8_t sides = 0;
    if (const auto& comp = t_.components[size_t(copy.cell)])
      for (size_t k = 0; k < comp->classes.size(); ++k)
        if (comp->classes[k].fixed_sides && t_.copy(copy.cell, int(k)) == id) sides = comp->classes[k].fixed_sides;
    for (size_t corner = 0; corner < 8; ++corner) {
      const int32_t at = place[size_t(copy.node[corner])];
      if (at < 0) continue;
      mass[size_t(at)] += share;
      if (sides) fixed[size_t(at)] |= holds(copy.cell, sides, copy.node[corner], corner);
    }
  }
  for (size_t i = 0; i < nodes.size(); ++i) {
    model.mass_kg.set(size_t(nodes[i]), mass[i]);
    model.fixed.set(size_t(nodes[i]), fixed[i]);
  }
  for (const auto& h : t_.hanging) model.fixed.set(size_t(h.node), false);
  hold_as_found(model, copies.ascending());
}

}  // namespace

void make_parts_ready(const StencilTable& table, const LatticeTopology& t, const LatticeTopology* before,
                      Workers& workers) {
  std::vector<CellPlace> places;
  const auto want = [&](size_t c) { places.push_back(t.tree.place(t.grid, t.cells[c].cell)); };
  if (before)
    for_each_change(before->cells, t.cells, want);
  else
    for (size_t c = 0; c < t.cells.size(); ++c) want(c);
  table.make_ready(places, workers);
}

std::shared_ptr<const FemModel> assemble_fem(const StencilTable& table, const LatticeTopology& t,
                                             const EarlierModel* before, const MaterialSurface* surface) {
  auto model = std::make_shared<FemModel>();
  model->cell_mm = t.grid.cell_mm();
  model->graded = !t.grading.empty();
  model->parent = t.node_parent;
  for (const auto& b : t.born) {
    BornNode born{b.node, {}};
    for (auto [p, w] : b.from) born.from.push_back({p, float(w)});
    model->born.push_back(std::move(born));
  }
  for (const auto& h : t.hanging) {
    HangingNode out{h.node, h.count, h.master, {}};
    for (size_t k = 0; k < size_t(h.count); ++k) out.weight[k] = 1 / float(h.count);
    model->hanging.push_back(out);
  }
  const Assembly assembly(table, t, surface);
  const bool grows = before && t.cell_parent.same() >= before->topology.cells.size() &&
                     t.nodes.size() >= before->topology.nodes.size() &&
                     t.node_in_material == before->topology.node_in_material;
  if (grows)
    assembly.changed(*model, *before);
  else
    assembly.all(*model);
  // (Only now: places of parts may have added stencils.)
  model->stencils = table.stencils();
  model->laws = table.laws();
  return model;
}

}  // namespace limberg
