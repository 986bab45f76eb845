#pragma once
// Pieces that nothing holds: how far one iterate may carry them.
//
// Elasticity does not say where such a piece lies, so the metric is next to nothing along its rigid motions
// (floating_shift), and a contact that pushes it asks for a step of metres: it went there, out of reach of the contact
// and of every picture. A contact pushes over its overlap, some tenths of a millimetre. So of the direction of a
// quasi-static iterate each such piece goes at most kLooseStep_mm: the next contact list finds it beside what pushed.
#include <span>
#include <vector>

#include "sim/base/simd.h"
#include "sim/fem/model/fem_model.h"

namespace limberg::fem {

inline constexpr double kLooseStep_mm = 0.5;

class LoosePieces {
 public:
  LoosePieces() = default;  // none
  LoosePieces(const FemModel& model, std::span<const Spring> springs);

  bool empty() const { return pieces_.empty(); }
  /// Scales what the direction has at each of them so that no node goes farther; true: it did.
  bool shorten(NodeArray& d) const;

 private:
  std::vector<std::vector<int32_t>> pieces_;  // nodes of each
};

}  // namespace limberg::fem
