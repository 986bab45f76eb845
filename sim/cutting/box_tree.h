#pragma once
// A box tree over integer triangles that never change: what a blade may meet.
//
// Four boxes stand in a node, of further nodes or of single triangles, so that one look at two cache lines serves
// four of them and a triangle is told apart without being read. Coordinates are half-units; nothing is
// rounded but the planes of a SlantBox, which have room for it.
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
  /// Of the sums of three products of numbers below 2^22 (two corners of a box) with parts of a unit vector, all in `float`.
  static constexpr float kRoom = 4;
};

/// Up to eight boxes that follow each other in a list, looked at together: neighbours in the list of a blade's triangles
/// are mostly neighbours in space, so one walk down a tree serves them all.
struct BoxGroup {
  static constexpr size_t kMost = 8;
  size_t first = 0, count = 0;
  IntBox all;
  using Four [[gnu::vector_size(16)]] = int32_t;       // in one register
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

  /// Calls visit(triangle) or visit(triangle, its box) for every triangle whose box meets the given one (of a SlantBox: and comes
  /// between its planes, or nearly so), in an order of the tree's own.
  template <class Query, class Visit>
  void box(const Query& query, Visit&& visit) const {
    const IntBox& q = box_of(query);
    if (node_.empty()) return;
    int32_t stack[kStack];
    int n = 0;
    stack[n++] = 0;
    while (n > 0) {
      const Node& node = node_[size_t(stack[--n])];
      std::array<int32_t, 4> apart;  // negative: somewhere apart
      for (size_t k = 0; k < 4; ++k)
        apart[k] = (q.hi.x - node.lo[0][k]) | (node.hi[0][k] - q.lo.x) | (q.hi.y - node.lo[1][k]) |
                   (node.hi[1][k] - q.lo.y) | (q.hi.z - node.lo[2][k]) | (node.hi[2][k] - q.lo.z);
      if constexpr (std::is_same_v<Query, SlantBox>) node.leave_what_is_aside(query, apart);
      if (node.child[0] < 0) {
        for (size_t k = 0; k < 4; ++k) {
          if (apart[k] < 0) continue;
          if constexpr (std::is_invocable_v<Visit, int32_t, const IntBox&>)
            visit(~node.child[k], IntBox{{node.lo[0][k], node.lo[1][k], node.lo[2][k]}, {node.hi[0][k], node.hi[1][k], node.hi[2][k]}});
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
  IntBox all() const;

 private:
  static constexpr int kStack = 64;  // each level of 4-fold nodes leaves three behind: enough for 2^32 triangles
  struct Node {
    std::array<std::array<int32_t, 4>, 3> lo, hi;  // [axis][child]; of no child: a box that meets none
    std::array<int32_t, 4> child;                  // nodes, or ~triangles

    void leave_what_is_aside(const SlantBox& q, std::array<int32_t, 4>& apart) const {
      using Ints = BoxGroup::Four;
      using Floats [[gnu::vector_size(16)]] = float;
      Floats middle{}, reach{};  // both twice
      for (size_t i = 0; i < 3; ++i) {
        const Ints from = std::bit_cast<Ints>(lo[i]), to = std::bit_cast<Ints>(hi[i]);
        middle += q.normal[i] * __builtin_convertvector(from + to, Floats);
        reach += std::abs(q.normal[i]) * __builtin_convertvector(to - from, Floats);
      }
      apart = std::bit_cast<std::array<int32_t, 4>>(std::bit_cast<Ints>(apart) | (middle - reach > q.hi) | (middle + reach < q.lo));
    }
  };
  static const IntBox& box_of(const IntBox& q) { return q; }
  static const IntBox& box_of(const SlantBox& q) { return q.box; }
  struct Item {
    Int3 sum;  // of the corners: three times the centre
    int32_t triangle;
  };
  struct Builder;
  std::vector<Node> node_;
};

}  // namespace limberg
