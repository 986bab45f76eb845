#pragma once
// What of a model hangs together, and what of that something holds.
//
// A piece: cells that share nodes (hanging nodes with their masters), and pieces that a spring ties. It is held along
// an axis where one of its nodes is, and whole where a spring ties it to the world.
#include <span>
#include <vector>

#include "sim/fem/model/fem_model.h"

namespace limberg::fem {

struct HeldPieces {
  std::vector<int32_t> piece;  // per node: a node of its piece, the same for all of them
  std::vector<Held> held;      // per node: along which axes its piece is held
};
/// O(cells + springs).
HeldPieces held_pieces(const FemModel& model, std::span<const Spring> springs);

}  // namespace limberg::fem
