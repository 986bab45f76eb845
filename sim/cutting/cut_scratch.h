#pragma once
// Working space of a cut. It stays with the arrangement from cut to cut, so that a cut asks the heap for little more than
// what it leaves behind. Nothing in it means anything between two tries.
#include <utility>
#include <vector>

#include "sim/cutting/planar_split.h"
#include "sim/cutting/tri_tests.h"

namespace limberg {

/// A list whose elements keep their memory when it is cleared: they are handed out again as they were left.
template <class T>
class Recycled {
 public:
  void clear() { size_ = 0; }
  T& next() {
    if (size_ == all_.size()) all_.emplace_back();
    return all_[size_++];
  }
  void take(size_t n) {
    if (all_.size() < n) all_.resize(n);
    size_ = n;
  }
  size_t size() const { return size_; }
  T& operator[](size_t i) { return all_[i]; }
  const T& operator[](size_t i) const { return all_[i]; }
  T* begin() { return all_.data(); }
  T* end() { return all_.data() + size_; }

 private:
  std::vector<T> all_;
  size_t size_ = 0;
};

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
    size_t first = 0, count = 0;  // its segments
    bool changes = false;         // the kept patches need something of it
    PlanarSplit scratch;
    std::vector<std::pair<int32_t, int32_t>> needed;  // sub-edges, ascending ends
  };
  struct Barrier {  // a sub-edge of a segment next to live material
    int32_t s = 0, f = 0, a = 0, b = 0;
    int16_t label_a = 0, label_b = 0;  // where its ends lie on s
    uint32_t touched = 0;
    uint8_t mat = 0;
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
  std::vector<BoxGroup> group;  // of blade triangles
  std::vector<Near> near;                            // of one group
  std::array<std::vector<uint32_t>, BoxGroup::kMost> chosen;       // of those, by each blade triangle of the group
  std::vector<Segment> segment, segment_room;
  std::vector<Mark> mark, between;
  // divide
  Recycled<Touched> touched;
  std::vector<Barrier> barrier, barrier_room;
  Recycled<PlanarSplit> blade_split;                     // per blade triangle
  std::vector<std::pair<int32_t, int32_t>> shared_edge;  // sub-edges shared with older walls, ascending ends
  std::vector<std::array<int32_t, 3>> edge_point;        // blade edge (ascending ends), point on it
  // Enforced in the order of `barrier`, so junction j of blade triangle i is barrier barrier_first[i] + j.
  std::vector<size_t> barrier_first;
  // patches
  std::vector<size_t> piece_first;  // per blade triangle: its first piece among all
  std::vector<int32_t> parent;      // per piece
  std::vector<uint8_t> keep, seeded;
  std::vector<BorderEdge> border;
  std::vector<Vote> vote;
  std::vector<int32_t> table;
  // commit
  std::vector<int32_t> kept;
  std::vector<Constraint> junction;

  void clear() {
    hit.clear(), group.clear(), near.clear(), segment.clear(), mark.clear(), touched.clear(), barrier.clear();
    shared_edge.clear(), edge_point.clear(), barrier_first.clear(), piece_first.clear(), keep.clear();
    border.clear(), vote.clear();
    blade_split.clear();
  }
};

}  // namespace limberg
