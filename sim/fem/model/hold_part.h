#pragma once
// A model of which a part holds still: what lies outside is absent (scale 0), what lies on the rim is held.
#include <memory>
#include <span>
#include <vector>

#include "sim/fem/model/fem_model.h"

namespace limberg {

/// `out`, per node: 1 where it holds still. Cells of nothing but such nodes get scale 0. A hanging node holds still
/// where all its masters do, whatever it says of it; it is never held itself.
std::shared_ptr<const FemModel> hold_part(const FemModel& model, std::vector<uint8_t> out);

}  // namespace limberg
