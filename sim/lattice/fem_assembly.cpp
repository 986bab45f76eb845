#include "sim/lattice/fem_assembly.h"

#include <algorithm>
#include <stdexcept>

namespace limberg {
namespace {

constexpr double kFloor = 1e-2;  // of the fraction, for conditioning: a sliver's nodes stay solvable in float

// A block's outermost cells miss this little at most (grid_fit.h): half of `count` half-units of thousands per cell, four
// times that when cells can be divided, and in a part it is more of the whole.
double counts_as_full(bool divisible, int level) { return 1 - (divisible ? 0.003 : 0.002) * double(1 << level); }

}  // namespace

std::shared_ptr<const FemModel> assemble_fem(const StencilTable& table, const LatticeTopology& t,
                                             const EarlierModel* before) {
  auto model = std::make_shared<FemModel>();
  model->cell_mm = t.grid.cell_mm();
  const size_t nodes = t.nodes.size();
  model->X_mm.reserve(nodes);
  model->parent.reserve(nodes);
  const size_t nodes_before = before ? before->topology.nodes.size() : 0;
  for (size_t i = 0; i < nodes; ++i) {
    const NodeCopy& n = t.nodes[i];
    const bool same = i < nodes_before && before->topology.nodes[i].at == n.at;
    model->X_mm.push_back(same ? before->model.X_mm[i] : t.grid.quarter_mm(n.at));
    model->parent.push_back(n.parent);
  }
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
  model->fixed.assign(nodes, 0);
  model->mass_kg.assign(nodes, 0);
  model->cells.resize(t.cells.size());
  const double whole = model->cell_mm.prod();
  const auto scale_of = [&](double fraction, int level) {
    return fraction > counts_as_full(t.front_levels > 0, level) ? 1.0f : float(std::max(fraction, kFloor));
  };
  for (size_t c = 0; c < t.cells.size(); ++c) {
    const CellCopy& copy = t.cells[c];
    HexCell& cell = model->cells[c];
    const bool same = before && copy.parent >= 0 && before->topology.cells[size_t(copy.parent)].cell == copy.cell;
    if (same && before->model.cells[size_t(copy.parent)].level == 0) {  // where it lies, and of what it is
      cell = before->model.cells[size_t(copy.parent)];
      cell.node = copy.node;
      cell.scale = scale_of(copy.fraction, 0);
      const double mass =
          std::max(copy.fraction, 0.0) * whole * table.stencils()[size_t(cell.stencil)].density_kg_mm3;
      for (int32_t n : copy.node) model->mass_kg[size_t(n)] += mass / 8;
      continue;
    }
    cell.node = copy.node;
    const CellPlace place = t.tree.place(t.grid, copy.cell);
    for (int a = 0; a < 3; ++a) cell.at[size_t(a)] = int16_t(2 * place.at[a] >> place.level);
    cell.level = uint8_t(place.level);
    cell.stencil = table.of_place(place);
    if (cell.stencil < 0) throw std::logic_error("material in a lattice cell for which there is no stencil");
    cell.scale = scale_of(copy.fraction, place.level);
    const double volume = whole / double(1 << 3 * place.level);
    // A part weighs as the cell that it is a part of: division does not change the mass.
    const int32_t root = table.of_cell(
        t.grid.cell_index({place.at.x >> place.level, place.at.y >> place.level, place.at.z >> place.level}));
    const double mass = std::max(copy.fraction, 0.0) * volume * table.stencils()[size_t(root)].density_kg_mm3;
    for (int32_t n : copy.node) model->mass_kg[size_t(n)] += mass / 8;
  }
  // Held nodes.
  for (size_t cell = 0; cell < t.components.size(); ++cell) {
    const auto& comp = t.components[cell];
    if (!comp) continue;
    for (size_t k = 0; k < comp->classes.size(); ++k) {
      const uint8_t sides = comp->classes[k].fixed_sides;
      if (!sides) continue;
      const auto& node = t.cells[size_t(t.copy(int32_t(cell), int(k)))].node;
      const uint8_t in = t.corners_in_material(int32_t(cell));
      for (size_t corner = 0; corner < 8; ++corner) {
        const uint8_t may = table.fixed_candidate(t.nodes[size_t(node[corner])].at);
        if ((may & sides & 0x3f) || (may & StencilTable::kNearFixed) ||
            ((may & StencilTable::kFarFixed) && !(in >> corner & 1)))
          model->fixed[size_t(node[corner])] = 1;
      }
    }
  }
  for (const auto& h : t.hanging) model->fixed[size_t(h.node)] = 0;  // its masters hold it
  // (Only now: places of parts may have added stencils.)
  model->stencils = table.stencils();
  model->laws = table.laws();
  return model;
}

}  // namespace limberg
