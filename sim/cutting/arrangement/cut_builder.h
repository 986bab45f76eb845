#pragma once
// One try of one cut. Everything before commit() works on scratch data and only appends points; abandon() forgets them.
//
//   prepare       jittered blade -> original triangles; the blade must be embedded
//   intersect     blade x every live original triangle near it -> segments
//   divide        segments x stored junctions -> points; scratch division of every touched triangle
//   find_patches  blade divided by barriers (junctions with live faces); flood; inside or outside by unanimous vote
//   select        patches in material that hold a seed
//   commit        divide only by what the kept patches need; walls in, gluing of dirty edges, local invariants
//
// cut_builder.cpp holds the frame and the divisions, cut_intersect.cpp the second step, cut_patches.cpp and
// cut_commit.cpp the last ones.
#include "sim/cutting/arrangement/cut_scratch.h"

namespace limberg {

/// Blade::shared_point without the points at which no wall is left to continue: where an earlier blade ran out of the
/// body, say. Such a point may be redrawn like any other.
std::vector<int32_t> live_shared_points(const ArrangementStore& store, const Blade& blade);

class CutBuilder {
 public:
  CutBuilder(ArrangementStore& store, const Blade& blade, std::vector<Int3> vertex);

  enum Outcome : uint8_t { ok, coincidence, nothing, refused };
  Outcome run(CutResult& result);
  const std::string& reason() const { return reason_; }

 private:
  using Mark = CutScratch::Mark;
  using Segment = CutScratch::Segment;
  using Touched = CutScratch::Touched;
  using Barrier = CutScratch::Barrier;

  Outcome fail(Outcome o, std::string why) {
    reason_ = std::move(why);
    return o;
  }
  Outcome prepare();
  Outcome intersect();
  void find_near();
  Outcome intersect_with(int32_t s, const IntTriangle& ts, int32_t f, const IntTriangle& tf);
  Outcome divide();
  Outcome divide_blade();
  Outcome find_patches(CutResult& result);
  Outcome commit(CutResult& result);
  void abandon();

  // cut_shared.cpp: blades that continue an older one through shared explicit points
  Outcome take_shared_edges();
  int vote_at_shared_edge(int32_t a, int32_t b, int32_t s, int32_t third) const;

  std::span<Mark> marks(const Segment& s) { return {mark_.data() + s.first, s.count}; }
  std::span<const Mark> marks(const Segment& s) const { return {mark_.data() + s.first, s.count}; }
  int16_t label_of(int32_t point, int32_t orig) const;  // of an end of a segment
  bool crosses(const Constraint& c, const Plane& plane_s, const Plane& plane_g, int32_t p, int32_t q, bool& zero) const;
  /// Points that a kept patch is bounded by.
  struct NeededPoints {
    int32_t first_new = 0;
    std::vector<uint8_t> is_new;  // by point, from first_new on
    std::vector<int32_t> old;     // ascending
    bool has(int32_t p) const;
  };
  NeededPoints find_needed();
  /// A triangle of which not all sub-edges are needed: divides it again, by those that are.
  Outcome divide_finally(uint32_t touched, const NeededPoints& needed_points);
  /// Division i of `from` becomes that of this original triangle.
  void write_division(int32_t orig, Divisions& from, size_t i);
  void retire_replaced(int32_t orig, std::span<const PlanarSplit::Piece> pieces);
  /// Sets the mates at the inner edges of a division whose faces are these.
  void glue_inside(std::span<const int32_t> face, std::span<const PlanarSplit::Piece> pieces);

  /// The kept pieces of the blade, as divisions of its triangles.
  void write_walls();
  /// What the cut has removed and added, into the edge map and the running sums; after making room without a failure.
  void enter_edges();
  /// At every edge that has changed. Null, or the contradiction.
  const char* glue_changed();
  /// Null, or which one: the divided surface encloses the same volume, every side that faces material is glued all
  /// round, junctions are edges of both triangles that they join.
  const char* broken_invariant() const;

  ArrangementStore& store_;
  const Blade& blade_;
  std::vector<Int3> vertex_;
  std::string reason_;

  OperationDelta delta_;
  LastOperation last_before_;
  bool committing_ = false, in_edges_ = false;
  std::vector<int32_t> blade_point_;
  bool continues_ = false;  // shares points with an older wall
  int32_t first_orig_ = 0, op_ = 0;
  CutScratch& room_;
  std::vector<Segment>& segment_ = room_.segment;
  std::vector<Mark>& mark_ = room_.mark;
  std::vector<Touched>& touched_ = room_.touched;
  std::vector<Barrier>& barrier_ = room_.barrier;
  Divisions& blade_divided_ = room_.blade_divided;
  std::vector<std::pair<int32_t, int32_t>>& shared_edge_ = room_.shared_edge;
  std::vector<std::array<int32_t, 3>>& edge_point_ = room_.edge_point;
  std::vector<size_t>& barrier_first_ = room_.barrier_first;
  std::vector<uint8_t>& keep_ = room_.keep;
};

}  // namespace limberg
