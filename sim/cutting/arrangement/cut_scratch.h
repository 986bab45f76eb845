#pragma once
// Working space of a cut. It stays with the arrangement from cut to cut, so that a cut asks the heap for little more
// than what it leaves behind. Nothing in it means anything between two tries.
#include <vector>

#include "sim/base/union_find.h"
#include "sim/cutting/arrangement/divisions.h"
#include "sim/cutting/arrangement/tri_tests.h"

namespace limberg {

struct CutScratch {
  struct Mark {
    int32_t point = 0;
    int16_t label = 0;  // where it lies on f (PlanarSplit labels)
  };
  struct Segment {
    int32_t s = 0, f = 0;           // blade triangle and existing one, both as original triangles
    uint32_t first = 0, count = 0;  // its marks: ends, and between them crossings of junctions, in order
  };
  struct Touched {
    int32_t orig = 0;
    uint32_t first = 0, count = 0;  // its segments
    uint32_t division = 0;          // of `divided`
    uint32_t sub_edges = 0;         // of its segments, next to live material
    uint32_t needed = 0;            // by the kept patches, of those
    bool changes = false;           // they need something of it
    bool in_part = false;           // but not all sub-edges
  };
  struct Barrier {  // a sub-edge of a segment next to live material
    int32_t s = 0, f = 0, a = 0, b = 0;
    int16_t label_a = 0, label_b = 0;  // where its ends lie on s
    uint32_t touched = 0;
    uint8_t mat = 0;
    bool needed = false;  // by a kept patch
  };
  struct NeededEdge {  // of a touched triangle, ascending ends
    uint32_t touched = 0;
    int32_t a = 0, b = 0;
    auto operator<=>(const NeededEdge&) const = default;
  };
  struct Hit {  // an existing triangle whose box meets that of a blade triangle
    int32_t orig = 0;
    uint32_t group = 0, members = 0;  // of blade triangles; which of them
  };
  struct Near {  // an existing triangle that a blade triangle may meet
    int32_t orig = 0;
    IntTriangle triangle;
  };
  struct BorderEdge {  // of a piece of the blade
    int32_t a = 0, b = 0, piece = 0;
    auto operator<=>(const BorderEdge&) const = default;
  };
  struct Vote {
    int32_t piece = 0;
    bool inside = false;
  };

  // prepare, intersect
  std::vector<IntTriangle> triangle;  // of the blade, named by its vertices until they have points
  std::vector<Plane> plane;
  std::vector<IntBox> box;
  std::vector<Hit> hit;
  std::vector<BoxGroup> group;                                // of blade triangles
  std::vector<Near> near;                                     // of one group
  std::array<std::vector<uint32_t>, BoxGroup::kMost> chosen;  // of those, by each blade triangle of the group
  std::vector<Segment> segment, segment_room;
  std::vector<Mark> mark, between;
  // divide
  PlanarSplit split;  // the one that is being made
  std::vector<Touched> touched;
  Divisions divided;  // of those, in their order; then those that have become others in the end
  std::vector<Barrier> barrier, barrier_room;
  Divisions blade_divided;                               // per blade triangle
  std::vector<std::pair<int32_t, int32_t>> shared_edge;  // sub-edges shared with older walls, ascending ends
  std::vector<std::array<int32_t, 3>> edge_point;        // blade edge (ascending ends), point on it
  // Enforced in the order of `barrier`, so junction j of blade triangle i is barrier barrier_first[i] + j.
  std::vector<size_t> barrier_first;
  // patches
  UnionFind patch;  // of the pieces of the blade
  std::vector<uint8_t> keep, seeded;
  std::vector<BorderEdge> border;
  std::vector<Vote> vote;
  std::vector<int32_t> table;
  // commit
  std::vector<NeededEdge> needed;  // of the triangles that need some of their sub-edges, not all
  std::vector<Constraint> junction;

  void clear() {
    hit.clear(), group.clear(), near.clear(), segment.clear(), mark.clear(), touched.clear(), barrier.clear();
    shared_edge.clear(), edge_point.clear(), barrier_first.clear(), keep.clear(), needed.clear();
    border.clear(), vote.clear();
    divided.clear(), blade_divided.clear();
  }
};

}  // namespace limberg
