#pragma once
// Models built directly, without a body or a lattice: boxes of one or two layers for tests and benches.
#include <functional>
#include <vector>

#include "sim/fem/model/fem_model.h"

namespace limberg {

/// Isotropic stable neo-Hookean constants, reparametrised as in fem_model.h: mu of E and nu, lambda = lambda_Lame + mu.
struct Elastic {
  double mu_kPa = 0, lambda_kPa = 0;
};
Elastic elastic_from_young(double young_kPa, double poisson);

/// Stencil of a homogeneous cell; exact (2x2x2 Gauss points integrate the trilinear products exactly).
/// `prestretch`: F0 of fem_model.h, det 1. `p0` = mu n.A n with n = z.
Stencil box_stencil(const Vec3& cell_mm, const Elastic& e, double density_kg_mm3 = 1e-6,
                    const Mat3& prestretch = Mat3::Identity());

struct BoxSpec {
  Int3 cells{4, 4, 4};
  Vec3 size_mm{10, 10, 10};                          // centred in x and y, z from 0
  double young_bottom_kPa = 60, young_top_kPa = 60;  // lower and upper half of the layers
  double poisson = 0.45;
  double density_kg_mm3 = 1e-6;
  bool fix_sides = false;   // the four lateral faces
  bool fix_bottom = false;  // z = 0
  double hole_length_mm = 0,
         hole_width_mm = 0;  // fusiform hole along x through the middle: cells with their centre inside
};

/// Nodes without a cell are left out. Corner order and units of fem_model.h; parents are -1.
FemModel box_model(const BoxSpec& spec);

/// The model after a cut along squares of its lattice: cells that share one are
/// parted when `apart(centre, other centre)`. Corners that no square joins any more
/// become copies, which come after the nodes of before; cells keep their order.
FemModel part_cells(const FemModel& model, const std::function<bool(const Vec3& a_mm, const Vec3& b_mm)>& apart);

/// The point of the model's material nearest to X (inside a cell if X is).
EmbeddedPoint embed(const FemModel& model, const Vec3& X_mm);

/// The scene of the speed bench: 120 x 120 x 10 mm, sides fixed, 18 kPa below and 60 kPa above, fusiform hole of 40 x 9
/// mm with 20 sutures of 1 N/mm across it, hook of 0.5 N/mm at (20, 15, top).
struct BenchScene {
  FemModel model;
  std::vector<Spring> springs;  // the hook is the last
};
BenchScene bench_scene(int cells_per_side, int layers, double poisson);

}  // namespace limberg
