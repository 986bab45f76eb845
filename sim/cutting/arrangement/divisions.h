#pragma once
// Finished divisions of triangles, one behind the other in memory:
// a cut makes hundreds, and reads each again once or twice.
#include "sim/cutting/arrangement/planar_split.h"

namespace limberg {

class Divisions {
 public:
  void clear() { piece_.clear(), junction_.clear(), end_.clear(); }
  /// Keeps what `split` has made of its triangle.
  void keep(const PlanarSplit& split);

  size_t size() const { return end_.size(); }
  size_t all_pieces() const { return piece_.size(); }
  /// Its first piece, among those of all.
  size_t first_piece(size_t i) const { return i == 0 ? 0 : end_[i - 1].piece; }
  /// Whose piece that is.
  size_t of_piece(size_t piece) const;
  std::span<PlanarSplit::Piece> pieces(size_t i) {
    return std::span(piece_).subspan(first_piece(i), end_[i].piece - first_piece(i));
  }
  /// By label, from PlanarSplit::kJunction on.
  std::span<const Constraint> junctions(size_t i) const {
    const size_t first = i == 0 ? 0 : end_[i - 1].junction;
    return std::span(junction_).subspan(first, end_[i].junction - first);
  }

  /// A junction with no material on either side is an ordinary edge again.
  void forget_dead_junctions(size_t i);
  /// The junctions as the store keeps them: one per sub-edge, in
  /// the order of the pieces, which are labelled anew to match.
  void number_junctions(size_t i, std::vector<Constraint>& numbered);

 private:
  struct End {
    size_t piece = 0, junction = 0;
  };
  std::vector<PlanarSplit::Piece> piece_;
  std::vector<Constraint> junction_;
  std::vector<End> end_;                          // of each
  std::vector<PlanarSplit::EdgeOf> junction_at_;  // room
};

}  // namespace limberg
