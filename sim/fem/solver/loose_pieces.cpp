#include "sim/fem/solver/loose_pieces.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "sim/fem/model/held_pieces.h"

namespace limberg::fem {

LoosePieces::LoosePieces(const FemModel& model, std::span<const Spring> springs) {
  const HeldPieces all = held_pieces(model, springs);
  std::map<int32_t, std::vector<int32_t>> loose;
  for (size_t v = 0; v < all.piece.size(); ++v)
    if (!all.held[v].any()) loose[all.piece[v]].push_back(int32_t(v));
  for (auto& [first, nodes] : loose) pieces_.push_back(std::move(nodes));
}

bool LoosePieces::shorten(NodeArray& d) const {
  bool any = false;
  for (const std::vector<int32_t>& nodes : pieces_) {
    double farthest = 0;
    for (int32_t v : nodes) {
      const Node4& x = d[size_t(v)];
      farthest = std::max(farthest,
                          std::sqrt(double(x.x) * double(x.x) + double(x.y) * double(x.y) + double(x.z) * double(x.z)));
    }
    if (!(farthest > kLooseStep_mm)) continue;
    const float share = float(kLooseStep_mm / farthest);
    for (int32_t v : nodes) store(d[size_t(v)], share * load(d[size_t(v)]));
    any = true;
  }
  return any;
}

}  // namespace limberg::fem
