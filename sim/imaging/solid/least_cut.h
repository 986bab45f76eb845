#pragma once
// The cut through the least of what ties two sets of nodes together on an even grid (Boykov and Kolmogorov 2004).
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "sim/imaging/fit/grid_reach.h"

namespace limberg::imaging {

struct LeastCut {
  std::vector<uint8_t> first;                      // of each node: it stays with `a`
  std::vector<std::pair<size_t, size_t>> through;  // neighbours that are parted, the one of `a` first
};
/// `within`: the nodes of the network; `a` and `b` are parted. `tie`: how firmly two neighbours hold, above 0. What
/// neither set reaches goes with none.
LeastCut least_cut(const GridSize& size, const std::vector<uint8_t>& within, const std::vector<uint8_t>& a,
                   const std::vector<uint8_t>& b, const std::function<double(size_t, size_t)>& tie);

}  // namespace limberg::imaging
