#include "sim/lattice/fem_assembly.h"

#include <algorithm>
#include <stdexcept>

namespace limberg {
namespace {

constexpr double kFloor = 1e-2;  // of the fraction, for conditioning: a sliver's nodes stay solvable in float
constexpr double kFull = 0.998;  // a block's outermost cells miss this little at most (grid_fit.h)

}  // namespace

std::shared_ptr<const FemModel> assemble_fem(const StencilTable& table, const LatticeTopology& t) {
  auto model = std::make_shared<FemModel>();
  model->cell_mm = t.grid.cell_mm();
  model->stencils = table.stencils();
  const size_t nodes = t.nodes.size();
  model->X_mm.reserve(nodes);
  model->parent.reserve(nodes);
  for (const NodeCopy& n : t.nodes) {
    model->X_mm.push_back(t.grid.node_mm(t.grid.node_at(n.lattice_node)));
    model->parent.push_back(n.parent);
  }
  model->fixed.assign(nodes, 0);
  model->mass_kg.assign(nodes, 0);
  model->cells.resize(t.cells.size());
  const double volume = model->cell_mm.prod();
  for (size_t c = 0; c < t.cells.size(); ++c) {
    const CellCopy& copy = t.cells[c];
    HexCell& cell = model->cells[c];
    cell.node = copy.node;
    const Int3 at = t.grid.cell_at(copy.cell);
    cell.at = {int16_t(2 * at.x), int16_t(2 * at.y), int16_t(2 * at.z)};
    cell.stencil = table.of_cell(copy.cell);
    if (cell.stencil < 0) throw std::logic_error("material in a lattice cell for which there is no stencil");
    cell.scale = copy.fraction > kFull ? 1.0f : float(std::max(copy.fraction, kFloor));
    const double mass = std::max(copy.fraction, 0.0) * volume * table.stencils()[size_t(cell.stencil)].density_kg_mm3;
    for (int32_t n : copy.node) model->mass_kg[size_t(n)] += mass / 8;
  }
  // Held nodes.
  for (size_t cell = 0; cell < t.components.size(); ++cell) {
    const auto& comp = t.components[cell];
    if (!comp) continue;
    for (size_t k = 0; k < comp->classes.size(); ++k) {
      const uint8_t sides = comp->classes[k].fixed_sides;
      if (!sides) continue;
      for (int32_t n : t.cells[size_t(t.copy(int32_t(cell), int(k)))].node) {
        const int32_t at = t.nodes[size_t(n)].lattice_node;
        const uint8_t may = table.fixed_candidates()[size_t(at)];
        if ((may & sides & 0x3f) || (may & StencilTable::kNearFixed) ||
            ((may & StencilTable::kFarFixed) && !t.node_in_material[size_t(at)]))
          model->fixed[size_t(n)] = 1;
      }
    }
  }
  return model;
}

}  // namespace limberg
