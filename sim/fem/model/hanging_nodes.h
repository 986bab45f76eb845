#pragma once
// Hanging nodes (fem_model.h) as the minimiser meets them: x_all = P x_free, g_free = P^T g_all.
//
// Both loops visit the list in its order, on one thread: the list is short (the rim of the divided cells), and the sums
// have the same bits for any number of workers. An empty list costs a test of its size.
#include <span>
#include <string>

#include "sim/base/simd.h"
#include "sim/fem/model/fem_model.h"

namespace limberg::fem {

/// u of every hanging node = weighted mean of its masters.
void follow_masters(std::span<const HangingNode> hanging, NodeArray& u);

/// Gradients of hanging nodes go to their masters and become zero; so does w, the sum of force sizes.
void give_to_masters(std::span<const HangingNode> hanging, NodeArray& g);

/// Per node: its place in the list, or -1. Empty when nothing hangs.
std::vector<int32_t> hanging_index(const FemModel& model);

/// Empty when the list is well formed: ascending, 2 or 4 masters that do not hang, weights that sum to 1, and rest
/// positions where the masters put them.
std::string check_hanging(const FemModel& model);

}  // namespace limberg::fem
