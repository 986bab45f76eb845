#include "tests/bench/layered_block.h"

#include <algorithm>

#include "sim/fem/model/box_model.h"
#include "sim/lattice/shared_cells.h"

namespace limberg::bench {

FemModel layered_block(const LayeredBlock& block) {
  BoxSpec b;
  b.cells = block.cells, b.size_mm = block.size_mm, b.poisson = block.poisson;
  FemModel m = box_model(b);
  Body body;
  body.layers.resize(2);
  body.layers[0].material.young_kPa = block.fat_kPa, body.layers[1].material.young_kPa = block.skin_kPa;
  for (Layer& l : body.layers) l.material.poisson = block.poisson;
  const std::vector<LayerMatter> matter = layer_matter(body, m.laws);
  m.stencils.clear();
  const double border = (block.size_mm[2] - block.skin_mm) / m.cell_mm[2];  // in cells from below
  for (int k = 0; k < b.cells.z; ++k) {
    const double at = std::clamp(border - k, 0.0, 1.0);
    Stencil s;
    std::vector<LayerPart> parts;
    const auto add = [&](double lo, double hi, const LayerMatter& l) {
      if (hi - lo < 1e-9) return;
      add_box(s, m.cell_mm, {0, 0, lo}, {1, 1, hi}, l, {});
      parts.push_back({&l, box_moments(m.cell_mm, {0, 0, lo}, {1, 1, hi})});
    };
    add(0, at, matter[0]);
    add(at, 1, matter[1]);
    finish_stencil(s);
    share_cell(s, m.cell_mm, parts, {});
    m.stencils.push_back(s);
  }
  for (HexCell& cell : m.cells) cell.stencil = cell.at[2] / 2;
  m.fixed.assign(m.X_mm.size(), 0);
  return m;
}

}  // namespace limberg::bench
