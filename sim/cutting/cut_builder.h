#pragma once
// One try of one cut. Everything before commit() works on scratch data and only appends points; abandon() forgets them.
//
//   prepare       jittered blade -> original triangles; the blade must be embedded
//   intersect     blade x every live original triangle near it -> segments
//   divide        segments x stored junctions -> points; scratch division of every touched triangle
//   find_patches  blade divided by barriers (junctions with live faces); flood; inside or outside by unanimous vote
//   select        patches in material that hold a seed
//   commit        divide only by what the kept patches need; walls in, gluing of dirty edges, local invariants
#include "sim/cutting/planar_split.h"
#include "sim/cutting/tri_tests.h"

namespace limberg {

class CutBuilder {
 public:
  CutBuilder(ArrangementStore& store, const Blade& blade, std::vector<Int3> vertex);

  enum Outcome : uint8_t { ok, coincidence, nothing, refused };
  Outcome run(CutResult& result);
  const std::string& reason() const { return reason_; }

 private:
  struct Mark {
    int32_t point = 0;
    int16_t label = 0;  // where it lies on f (PlanarSplit labels)
  };
  struct Segment {
    int32_t s = 0, f = 0;          // blade triangle and existing one, both as original triangles
    uint32_t first = 0, count = 0;  // its marks: ends, and between them crossings of junctions, in order
  };
  struct Touched {
    int32_t orig = 0;
    size_t first = 0, count = 0;  // its segments
    PlanarSplit scratch;
    std::vector<std::pair<int32_t, int32_t>> needed;  // sub-edges, ascending ends
  };
  struct Barrier {  // a sub-edge of a segment next to live material
    int32_t s = 0, f = 0, a = 0, b = 0;
    size_t touched = 0;
    uint8_t mat = 0;
  };

  Outcome fail(Outcome o, const char* why) {
    reason_ = why;
    return o;
  }
  Outcome prepare();
  Outcome intersect();
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
  IntTriangle triangle(int32_t orig) const;
  int16_t label_of(int32_t point, int32_t orig) const;  // of an end of a segment
  bool crosses(const Constraint& c, const Plane& plane_s, const Plane& plane_g, int32_t p, int32_t q, bool& zero) const;
  /// Points that a kept patch is bounded by.
  struct NeededPoints {
    int32_t first_new = 0;
    std::vector<uint8_t> is_new;  // by point, from first_new on
    std::vector<int32_t> old;     // ascending
    bool has(int32_t p) const;
  };
  Outcome divide_finally(const Touched& t, PlanarSplit& out, const NeededPoints& needed_points) const;
  void write_division(int32_t orig, const PlanarSplit& split);

  ArrangementStore& store_;
  const Blade& blade_;
  std::vector<Int3> vertex_;
  std::string reason_;

  Delta delta_;
  LastOperation last_before_;
  bool committing_ = false, accounted_ = false;
  std::shared_ptr<OrigTree> tree_;  // over the blade
  std::vector<int32_t> blade_point_;
  bool continues_ = false;  // shares points with an older wall
  int32_t first_orig_ = 0, op_ = 0;
  std::vector<Segment> segment_;
  std::vector<Mark> mark_;
  std::vector<Touched> touched_;
  std::vector<Barrier> barrier_;
  std::vector<PlanarSplit> blade_split_;                  // per blade triangle
  std::vector<std::pair<int32_t, int32_t>> shared_edge_;  // sub-edges shared with older walls, ascending ends
  std::vector<std::array<int32_t, 3>> edge_point_;        // blade edge (ascending ends), point on it
  std::vector<int32_t> kept_;                             // room for write_division
  // Enforced in the order of barrier_, so junction j of blade triangle i is barrier barrier_first_[i] + j.
  std::vector<size_t> barrier_first_;
  std::vector<size_t> piece_first_;  // per blade triangle: its first piece among all
  std::vector<uint8_t> keep_;        // per piece
};

}  // namespace limberg
