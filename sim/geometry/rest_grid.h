#pragma once
// The integer rest grid: every decision about topology is made on it, exactly.
//
// Rest (material) space never deforms. Coordinates are 32-bit integers in half-units: two half-units are one unit,
// a unit is unit_mm (1/8192 mm for a body within 256 mm). Body and blade vertices are EVEN, lattice planes are ODD,
// so no input vertex ever lies on a lattice plane. |coordinate| <= 2^21 - 2 half-units.
#include <cmath>

#include "sim/geometry/vec.h"

namespace limberg {

struct RestGrid {
  static constexpr int32_t kMaxCoordinate = (1 << 21) - 2;

  Vec3 origin_mm = Vec3::Zero();  // the centre of the domain
  double unit_mm = 1.0 / 8192;    // a power of two

  double half_unit_mm() const { return 0.5 * unit_mm; }
  /// Nearest even grid point. The caller checks fits() first.
  Int3 to_grid(const Vec3& p_mm) const {
    const Vec3 q = (p_mm - origin_mm) / unit_mm;
    return {2 * int32_t(std::lround(q.x())), 2 * int32_t(std::lround(q.y())), 2 * int32_t(std::lround(q.z()))};
  }
  Vec3 to_mm(const Int3& p) const { return origin_mm + half_unit_mm() * Vec3(p.x, p.y, p.z); }
  bool fits(const Vec3& p_mm) const {
    return p_mm.allFinite() && ((p_mm - origin_mm) / half_unit_mm()).cwiseAbs().maxCoeff() <= kMaxCoordinate - 2;
  }
};

}  // namespace limberg
