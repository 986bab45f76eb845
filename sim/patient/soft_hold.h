#pragma once
// What holds tissue softly where the body was cut out of a larger one (Body::soft_kPa_mm): springs to where it lies at
// rest, of so many kPa a mm of displacement.
//
// A face of the surface is held at its corners, each with a third of its area at rest. Corners in one copy of a cell
// share a spring, at their mean: 1 N/mm = 1000 kPa/mm mm^2. What a cut takes off goes without; the springs follow from
// the version of the surface alone, so undo brings them back.
#include <vector>

#include "sim/fem/model/fem_model.h"
#include "sim/patient/tissue.h"

namespace limberg {

class SoftHold {
 public:
  explicit SoftHold(const Tissue& tissue) : tissue_(tissue) {}
  /// Of the present version. Their numbers are above those of hooks and stitches, and below those of a press.
  const std::vector<Spring>& springs();
  /// Their sum on the tissue at the last step, mN.
  Vec3 force_mN() const;

 private:
  const Tissue& tissue_;
  uint64_t version_ = 0;
  bool found_ = false;
  std::vector<Spring> springs_;
};

}  // namespace limberg
