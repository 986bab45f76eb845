#pragma once
// The division of one original triangle: its triangulation, opened for inserting points and enforcing junctions.
//
// Every point that goes in is known to lie inside, on an edge of the original triangle, or on a junction, from what it
// is made of; nothing is ever decided "nearly". Edges carry labels: kFree may be flipped (both sides then hold the same
// material), 0..2 lies on that edge of the original triangle, kJunction + i is junction i. Pieces of an existing
// triangle that hold no material stay as they are: nothing can be cut there.
#include <span>
#include <string>
#include <vector>

#include "sim/cutting/arrangement/store.h"

namespace limberg {

class PlanarSplit {
 public:
  static constexpr int16_t kFree = -1, kJunction = 3;
  static constexpr size_t kMostJunctions = 32767 - kJunction + 1;  // that have a label; no more may be enforced

  struct Piece {
    std::array<int32_t, 3> v{};          // point ids
    std::array<int32_t, 3> neighbour{};  // piece across edge k, -1 outside
    std::array<int16_t, 3> label{kFree, kFree, kFree};
    uint8_t mat = 0;
    bool old = false;  // still the face that stood in its place when the division was opened
    /// The edge across which that neighbour lies.
    size_t edge_towards(int32_t piece) const { return size_t((neighbour[1] == piece) + 2 * (neighbour[2] == piece)); }
  };

  /// An edge k of a piece.
  struct EdgeOf {
    int32_t piece = 0, k = 0;
  };
  /// Edges labelled as junctions, each from its lower side, in the
  /// order in which the store keeps them. They stand in `room`.
  static std::span<const EdgeOf> list_junctions(std::span<const Piece> piece, std::vector<EdgeOf>& room);

  /// Opens the current division of an existing original triangle.
  void open(const ArrangementStore& store, int32_t orig);
  /// Opens a new, undivided triangle. Its plane is not copied.
  void open(const PointStore& points, const Plane& plane, const std::array<int32_t, 3>& v);
  void open(const PointStore& points, Plane&& plane, const std::array<int32_t, 3>& v) = delete;

  /// Inserts a point that lies on the chain of edges with this label (kFree: strictly inside). No effect when it is
  /// there already, or where there is no material. False: it is not where it was said to be, a coincidence.
  bool insert(int32_t point, int16_t label);
  /// Makes a-b an edge and labels it as a new junction with `partner`. All with one partner lie on one line; those that
  /// follow each other are enforced one after the other along it. No effect where there is no material. False: it would
  /// cross a junction or meet a point.
  bool enforce(int32_t a, int32_t b, int32_t partner);

  /// Flips free edges until every one is locally Delaunay. For explicit points in a plane z = const only.
  void make_delaunay();

  std::span<const Piece> pieces() const { return piece_; }
  std::span<const Constraint> junctions() const { return junction_; }  // by label, from kJunction on
  /// The edge that the last successful enforce() made; piece -1: none, there was no material.
  EdgeOf enforced() const { return enforced_; }

 private:
  /// Puts a point that lies in the closed piece t into it, given its sides of the three edges.
  bool insert_into(int32_t t, const std::array<int, 3>& side, int32_t point);
  int orient(int32_t a, int32_t b, int32_t c) const {
    if (a == b || b == c || c == a) return 0;  // the filter cannot see this zero, and wide integers are slow
    return points_->turn(*plane_, view_, a, b, c);
  }
  bool strictly_between(int32_t a, int32_t p, int32_t b) const;
  void split_piece(int32_t t, int32_t point);
  void split_edge(int32_t t, int k, int32_t point);
  void flip(int32_t t, int k);
  void relink(int32_t piece, int32_t from, int32_t to);
  /// On both sides. A face whose edge is another one now is a new face.
  void set_label(int32_t t, int k, int16_t label);
  int32_t& neighbour(int32_t t, int k) { return piece_[t].neighbour[size_t(k)]; }
  bool spared(int32_t t) const { return spares_ && (t < 0 || piece_[size_t(t)].mat == 0); }

  const PointStore* points_ = nullptr;
  const Plane* plane_ = nullptr;
  Projection view_;
  std::vector<Piece> piece_;
  std::vector<Constraint> junction_;
  int32_t last_ = 0;  // where the last point went in: the next is often near
  EdgeOf enforced_{-1, 0};
  bool spares_ = false;  // pieces without material; a new triangle's are yet to get theirs
};

}  // namespace limberg
