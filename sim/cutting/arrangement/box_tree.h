#pragma once
// A box tree over integer triangles that never change: what a blade may meet.
//
// Four boxes stand in a node, of further nodes or of single triangles, so that one look at one cache line serves
// four of them and a triangle is told apart without being read. Coordinates are half-units. A node keeps its boxes in
// steps of a power of two, 2^16 of them for the whole tree, rounded outwards: a query may find a triangle that lies
// beside it by less than a step, and misses none. The planes of a SlantBox have room for their rounding.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <span>
#include <type_traits>
#include <vector>

#include "sim/geometry/vec.h"

namespace limberg {

/// A closed box of half-units.
struct IntBox {
  Int3 lo, hi;
  bool meets(const IntBox& b) const {
    return lo.x <= b.hi.x && hi.x >= b.lo.x && lo.y <= b.hi.y && hi.y >= b.lo.y && lo.z <= b.hi.z && hi.z >= b.lo.z;
  }
};

inline IntBox box_around(const Int3& a, const Int3& b, const Int3& c) {
  return {{std::min({a.x, b.x, c.x}), std::min({a.y, b.y, c.y}), std::min({a.z, b.z, c.z})},
          {std::max({a.x, b.x, c.x}), std::max({a.y, b.y, c.y}), std::max({a.z, b.z, c.z})}};
}
inline IntBox box_around(const IntBox& a, const IntBox& b) {
  return {{std::min(a.lo.x, b.lo.x), std::min(a.lo.y, b.lo.y), std::min(a.lo.z, b.lo.z)},
          {std::max(a.hi.x, b.hi.x), std::max(a.hi.y, b.hi.y), std::max(a.hi.z, b.hi.z)}};
}

/// Of a box of fractions: the half-units within.
inline IntBox box_within(const Vec3& lo, const Vec3& hi) {
  static constexpr double far = 1 << 23;
  const auto up = [](double v) { return int32_t(std::clamp(std::ceil(v), -far, far)); };
  const auto down = [](double v) { return int32_t(std::clamp(std::floor(v), -far, far)); };
  return {{up(lo.x()), up(lo.y()), up(lo.z())}, {down(hi.x()), down(hi.y()), down(hi.z())}};
}

/// Around something flat that lies at a slant: of a box, what is between two parallel planes.
struct SlantBox {
  IntBox box;
  std::array<float, 3> normal{};
  float lo = 0, hi = 0;  // twice normal . x of the planes, with room for rounding (kRoom)
  /// Of the sums of three products of numbers below 2^22 (two
  /// corners of a box) with parts of a unit vector, all in `float`.
  static constexpr float kRoom = 4;
};

/// Up to eight boxes that follow each other in a list, looked at together: neighbours in the list of a blade's
/// triangles are mostly neighbours in space, so one walk down a tree serves them all.
struct BoxGroup {
  static constexpr size_t kMost = 8;
  size_t first = 0, count = 0;
  IntBox all;
  using Four [[gnu::vector_size(16)]] = int32_t;      // in one register
  std::array<std::array<Four, kMost / 4>, 3> lo, hi;  // [axis][four members]

  /// The group that begins at `start`: it ends where it would grow large beside its members.
  BoxGroup(std::span<const IntBox> box, size_t start) : first(start), all(box[start]) {
    const auto size = [](const IntBox& b) { return int64_t(b.hi.x) - b.lo.x + b.hi.y - b.lo.y + b.hi.z - b.lo.z; };
    int64_t members = 0;
    for (; count < kMost && first + count < box.size(); ++count) {
      const IntBox grown = box_around(all, box[first + count]);
      members += size(box[first + count]);
      if (size(grown) * int64_t(count + 1) > 3 * members) break;
      all = grown;
    }
    for (size_t i = 0; i < kMost; ++i)
      for (size_t k = 0; k < 3; ++k) {
        const IntBox& b = box[first + std::min(i, count - 1)];
        lo[k][i / 4][i % 4] = b.lo[int(k)], hi[k][i / 4][i % 4] = b.hi[int(k)];
      }
  }
  size_t end() const { return first + count; }
  /// Bit i: member i meets the box.
  uint32_t meeting(const IntBox& b) const {
    int32_t apart = 0;
    for (size_t h = 0; h < kMost / 4; ++h) {
      const Four gap = (hi[0][h] - b.lo.x) | (b.hi.x - lo[0][h]) | (hi[1][h] - b.lo.y) | (b.hi.y - lo[1][h]) |
                       (hi[2][h] - b.lo.z) | (b.hi.z - lo[2][h]);  // negative: there is one
      const Four bit = (gap >> 31) & Four{1, 2, 4, 8};
      apart |= (bit[0] | bit[1] | bit[2] | bit[3]) << 4 * h;
    }
    return ~uint32_t(apart) & ((1u << count) - 1);
  }
};

class BoxTree {
 public:
  BoxTree() = default;
  /// Corners of the triangles, |coordinate| < 2^21.
  explicit BoxTree(std::span<const std::array<Int3, 3>> triangle);

  bool empty() const { return node_.empty(); }

  /// Calls visit(triangle) or visit(triangle, its box, rounded outwards) for every triangle whose box, so rounded,
  /// meets the given one (of a SlantBox: and comes between its planes, or nearly so), in an order of the tree's own.
  template <class Query, class Visit>
  void box(const Query& query, Visit&& visit) const {
    const IntBox& q = box_of(query);
    if (node_.empty()) return;
    int32_t stack[kStack];
    int n = 0;
    stack[n++] = 0;
    while (n > 0) {
      const Node& node = node_[size_t(stack[--n])];
      const FourBoxes of = steps_.boxes(node);
      const Four apart = of.none | (q.hi.x - of.lo[0]) | (of.hi[0] - q.lo.x) | (q.hi.y - of.lo[1]) |
                         (of.hi[1] - q.lo.y) | (q.hi.z - of.lo[2]) | (of.hi[2] - q.lo.z) |
                         aside(query, of);  // negative: somewhere apart
      if (node.child[0] < 0) {
        for (size_t k = 0; k < 4; ++k) {
          if (apart[k] < 0) continue;
          if constexpr (std::is_invocable_v<Visit, int32_t, const IntBox&>)
            visit(~node.child[k],
                  IntBox{{of.lo[0][k], of.lo[1][k], of.lo[2][k]}, {of.hi[0][k], of.hi[1][k], of.hi[2][k]}});
          else
            visit(~node.child[k]);
        }
        continue;
      }
      for (size_t k = 4; k-- > 0;) {  // the first on top
        stack[n] = node.child[k];
        n += apart[k] >= 0;
      }
    }
  }
  /// Around all triangles.
  const IntBox& all() const { return steps_.all; }
  /// By how much a box may be rounded, half-units.
  int32_t step() const { return 1 << steps_.shift; }

 private:
  static constexpr int kStack = 64;  // each level of 4-fold nodes leaves three behind: enough for 2^32 triangles
  using Four = BoxGroup::Four;
  struct alignas(64) Node {
    std::array<std::array<uint16_t, 4>, 3> lo{}, hi{};  // [axis][child], in steps
    std::array<int32_t, 4> child{};                     // nodes, or ~triangles; 0: none
  };
  struct FourBoxes {
    std::array<Four, 3> lo, hi;  // [axis], half-units
    Four none;                   // -1: no child
  };
  struct Steps {
    IntBox all{};
    int shift = 0;

    uint16_t rounded(int32_t x, size_t axis) const { return uint16_t((x - all.lo[int(axis)]) >> shift); }
    FourBoxes boxes(const Node& node) const {
      using Shorts [[gnu::vector_size(8)]] = uint16_t;
      FourBoxes b;
      for (size_t i = 0; i < 3; ++i) {
        const Four from = __builtin_convertvector(std::bit_cast<Shorts>(node.lo[i]), Four);
        const Four to = __builtin_convertvector(std::bit_cast<Shorts>(node.hi[i]), Four);
        b.lo[i] = (from << shift) + all.lo[int(i)];
        b.hi[i] = ((to + 1) << shift) + (all.lo[int(i)] - 1);
      }
      b.none = std::bit_cast<Four>(node.child) == 0;
      return b;
    }
  };
  static Four aside(const IntBox&, const FourBoxes&) { return Four{}; }
  static Four aside(const SlantBox& q, const FourBoxes& of) {
    using Floats [[gnu::vector_size(16)]] = float;
    Floats middle{}, reach{};  // both twice
    for (size_t i = 0; i < 3; ++i) {
      middle += q.normal[i] * __builtin_convertvector(of.lo[i] + of.hi[i], Floats);
      reach += std::abs(q.normal[i]) * __builtin_convertvector(of.hi[i] - of.lo[i], Floats);
    }
    return (middle - reach > q.hi) | (middle + reach < q.lo);
  }
  static const IntBox& box_of(const IntBox& q) { return q; }
  static const IntBox& box_of(const SlantBox& q) { return q.box; }
  struct Item {
    Int3 sum;  // of the corners: three times the centre
    int32_t triangle;
  };
  struct Builder;
  std::vector<Node> node_;
  Steps steps_;
};

}  // namespace limberg
