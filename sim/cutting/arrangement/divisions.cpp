#include "sim/cutting/arrangement/divisions.h"

#include <algorithm>

namespace limberg {

void Divisions::keep(const PlanarSplit& split) {
  piece_.insert(piece_.end(), split.pieces().begin(), split.pieces().end());
  junction_.insert(junction_.end(), split.junctions().begin(), split.junctions().end());
  end_.push_back({piece_.size(), junction_.size()});
}

size_t Divisions::of_piece(size_t piece) const {
  return size_t(std::upper_bound(end_.begin(), end_.end(), piece, [](size_t p, const End& e) { return p < e.piece; }) -
                end_.begin());
}

void Divisions::forget_dead_junctions(size_t i) {
  const auto piece = pieces(i);
  for (PlanarSplit::Piece& p : piece)
    for (size_t k = 0; k < 3; ++k)
      if (p.label[k] >= PlanarSplit::kJunction && p.mat == 0 && piece[size_t(p.neighbour[k])].mat == 0)
        p.label[k] = PlanarSplit::kFree;
}

void Divisions::number_junctions(size_t i, std::vector<Constraint>& numbered) {
  numbered.clear();
  const auto old = junctions(i);
  if (old.empty()) return;
  const auto piece = pieces(i);
  for (const auto& [t, k] : PlanarSplit::list_junctions(piece, junction_at_)) {
    PlanarSplit::Piece& p = piece[size_t(t)];
    PlanarSplit::Piece& q = piece[size_t(p.neighbour[size_t(k)])];
    const Constraint& from = old[size_t(p.label[size_t(k)] - PlanarSplit::kJunction)];
    p.label[size_t(k)] = q.label[q.edge_towards(t)] = int16_t(PlanarSplit::kJunction + int(numbered.size()));
    numbered.push_back({p.v[size_t(k)], p.v[size_t(k + 1) % 3], from.partner});
  }
}

}  // namespace limberg
