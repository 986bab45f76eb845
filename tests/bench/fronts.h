#pragma once
// Where does a slit really end? A straight incision across the tension of the skin, that ends
// inside lattice cells at both ends and at its bottom, opened to equilibrium on different lattices.
//
// A cell in which a crack ends stays one piece, so the slit opens only up to that cell. With
// divided fronts (sim/lattice/topology.h) the piece that stays closed is a quarter as large. Rows
// of `limberg bench cutting`: for cells of 5 and 3.5 mm as they are, with fronts divided, and
// uniform lattices of a half and a quarter of the cell; the error is the root mean square
// difference of the width along the skin from that of the uniform quarter lattice, relative to the
// greatest width. What the lattice alone keeps closed is asked at all angles (slit_in_lattice).
#include <vector>

#include "sim/base/workers.h"
#include "sim/geometry/vec.h"
#include "tests/bench/cutting.h"

namespace limberg::bench {

struct SlitSpec {
  Vec3 block_mm{80, 60, 10};  // sides and bottom held
  double skin_cell_mm = 1;
  double from_mm = -18.7, to_mm = 21.3;  // the ends, along the slit: at 0 degrees inside cells of 5 and of 3.5 mm
  double y_mm = 0.37;                    // to the left of the block's middle
  double angle_deg = 0;                  // to the lattice, about the block's middle; the tension stays across the slit
  double depth_mm = 6.1;
  double cell_mm = 5;
  int front_levels = 0;
  double residual = 3e-5;  // of the equilibrium
  int max_iterations = 600;
};

struct SlitOpening {
  Vec3 cell_mm = Vec3::Zero();  // as fitted
  size_t nodes = 0, hanging = 0, cells = 0;
  double lattice_ms = 0, assembly_ms = 0, solve_ms = 0;  // CPU time
  int iterations = 0;
  double reached = 0;                  // residual
  std::vector<double> x_mm, width_mm;  // along the skin
  double widest_mm = 0;
  // From where the width exceeds a thousandth of the greatest to the true end.
  double closed_low_mm = 0, closed_high_mm = 0, closed_deep_mm = 0;
  double closed_cells() const;  // the largest of the three, in edges of a cell
};

/// Throws std::runtime_error when the cut is refused.
SlitOpening open_slit(const SlitSpec& spec, Workers& workers);

/// The same without equilibrium: closed is where both banks hang on the same nodes with the same weights, so that no
/// load can part them. Only nodes, cells, times and what is closed are filled in.
SlitOpening slit_in_lattice(const SlitSpec& spec);

/// The rows and bars.
void fronts(Result& out, const CuttingSettings& settings);

}  // namespace limberg::bench
