#pragma once
// A box tree over integer triangles that never change: what a blade may meet.
//
// Four boxes stand in a node, each of a further node or of one triangle, so that one look at two cache lines serves
// four of them and a triangle is told apart without being read. Coordinates are half-units; nothing is rounded.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
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

class BoxTree {
 public:
  BoxTree() = default;
  /// Corners of the triangles, |coordinate| < 2^21.
  explicit BoxTree(std::span<const std::array<Int3, 3>> triangle);

  bool empty() const { return node_.empty(); }

  /// Calls visit(triangle) for every triangle whose box meets the given one, in an order of the tree's own.
  template <class Visit>
  void box(const IntBox& q, Visit&& visit) const {
    if (node_.empty()) return;
    int32_t stack[kStack];
    int n = 0;
    stack[n++] = 0;
    while (n > 0) {
      const int32_t at = stack[--n];
      if (at < 0) {
        visit(~at);
        continue;
      }
      const Node& node = node_[size_t(at)];
      std::array<int32_t, 4> apart;  // negative: somewhere apart
      for (size_t k = 0; k < 4; ++k)
        apart[k] = (q.hi.x - node.lo[0][k]) | (node.hi[0][k] - q.lo.x) | (q.hi.y - node.lo[1][k]) |
                   (node.hi[1][k] - q.lo.y) | (q.hi.z - node.lo[2][k]) | (node.hi[2][k] - q.lo.z);
      for (size_t k = 4; k-- > 0;) {  // the first on top
        stack[n] = node.child[k];
        n += apart[k] >= 0;
      }
    }
  }
  /// The same for a box of fractions.
  template <class Visit>
  void box(const Vec3& lo, const Vec3& hi, Visit&& visit) const {
    const auto up = [](double v) { return int32_t(std::clamp(std::ceil(v), -kFar, kFar)); };
    const auto down = [](double v) { return int32_t(std::clamp(std::floor(v), -kFar, kFar)); };
    box(IntBox{{up(lo.x()), up(lo.y()), up(lo.z())}, {down(hi.x()), down(hi.y()), down(hi.z())}},
        std::forward<Visit>(visit));
  }

 private:
  static constexpr double kFar = 1 << 23;
  static constexpr int kStack = 64;  // each level of 4-fold nodes leaves three behind: enough for 2^32 triangles
  struct Node {
    std::array<std::array<int32_t, 4>, 3> lo, hi;  // [axis][child]; of no child: a box that meets none
    std::array<int32_t, 4> child;                  // node, or ~triangle
  };
  struct Item {
    Int3 sum;  // of the corners: three times the centre
    int32_t triangle;
  };
  struct Builder;
  std::vector<Node> node_;
};

}  // namespace limberg
