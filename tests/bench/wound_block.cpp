#include "tests/bench/wound_block.h"

#include <cmath>

#include "sim/fem/model/box_model.h"

namespace limberg::bench {

FemModel sided_block(int cells_per_side, int layers) {
  BoxSpec b;
  b.cells = {cells_per_side, cells_per_side, layers};
  b.size_mm = {120, 120, 10};
  b.young_bottom_kPa = 18, b.young_top_kPa = 60;
  b.poisson = 0.49;
  b.fix_sides = true;
  return box_model(b);
}

FemModel wounded_block(const FemModel& before, double flap_mm) {
  constexpr double slit_half_mm = 25;
  const Vec3 h = before.cell_mm;
  const double under = 10 - h[2] * std::ceil(0.5 * (10 / h[2]));
  return part_cells(before, [&](const Vec3& p, const Vec3& q) {
    const Vec3 m = 0.5 * (p + q);
    const bool across_y = std::fabs(p[1] - q[1]) > 0.5 * h[1];
    const bool across_z = std::fabs(p[2] - q[2]) > 0.5 * h[2];
    if (across_y && std::fabs(m[1]) < 0.3 * h[1] && std::fabs(m[0]) < slit_half_mm) return true;
    return flap_mm > 0 && across_z && std::fabs(m[2] - under) < 0.3 * h[2] && m[1] > 0 && m[1] < flap_mm &&
           std::fabs(m[0]) < slit_half_mm;
  });
}

Spring lip_hook(const FemModel& m, double pulled) {
  Spring s;
  s.id = 1, s.to_world = true, s.k_N_per_mm = 0.5;
  const Vec3 at(0.1, 1, 9.9);
  s.a = embed(m, at);
  s.target_mm = at + pulled * Vec3(0, 8, 12);
  return s;
}

}  // namespace limberg::bench
