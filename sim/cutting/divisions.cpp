#include "sim/cutting/divisions.h"

#include <algorithm>

namespace limberg {

void Divisions::keep(const PlanarSplit& split) {
  piece_.insert(piece_.end(), split.pieces().begin(), split.pieces().end());
  junction_.insert(junction_.end(), split.junctions().begin(), split.junctions().end());
  end_.push_back({piece_.size(), junction_.size()});
}

size_t Divisions::of_piece(size_t piece) const {
  return size_t(std::upper_bound(end_.begin(), end_.end(), piece, [](size_t p, const End& e) { return p < e.piece; }) - end_.begin());
}

void Divisions::forget_dead_junctions(size_t i) {
  const auto piece = pieces(i);
  for (PlanarSplit::Piece& p : piece)
    for (size_t k = 0; k < 3; ++k)
      if (p.label[k] >= PlanarSplit::kJunction && p.mat == 0 && piece[size_t(p.neighbour[k])].mat == 0) p.label[k] = PlanarSplit::kFree;
}

void Divisions::number_junctions(size_t i, std::vector<Constraint>& numbered) {
  numbered.clear();
  const auto old = junctions(i);
  if (old.empty()) return;
  const auto piece = pieces(i);
  // Each from its lower side. They are listed first, without a branch, for which edges are junctions cannot be foreseen.
  numbered.resize(3 * piece.size() + 1);
  size_t n = 0;
  for (size_t t = 0; t < piece.size(); ++t)
    for (size_t k = 0; k < 3; ++k) {
      numbered[n] = {int32_t(t), int32_t(k), -1};
      n += piece[t].label[k] >= PlanarSplit::kJunction && piece[t].neighbour[k] > int32_t(t);
    }
  numbered.resize(n);
  for (size_t j = 0; j < n; ++j) {
    const int32_t t = numbered[j].a;
    const size_t k = size_t(numbered[j].b);
    PlanarSplit::Piece& p = piece[size_t(t)];
    PlanarSplit::Piece& q = piece[size_t(p.neighbour[k])];
    const size_t m = q.edge_towards(t);
    const Constraint& from = old[size_t(p.label[k] - PlanarSplit::kJunction)];
    p.label[k] = q.label[m] = int16_t(PlanarSplit::kJunction + int(j));
    numbered[j] = {p.v[k], p.v[(k + 1) % 3], from.partner};
  }
}

}  // namespace limberg
