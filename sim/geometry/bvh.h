#pragma once
// A static bounding volume hierarchy over the triangles of a mesh, for rest surfaces and, refitted, for moving ones.
//
//   Bvh bvh(mesh.X_mm, mesh.tri);                  // build: allocates, O(n log n)
//   bvh.refit(x_mm);                               // same triangles, new positions: O(n), allocates nothing
//   auto c = bvh.closest(p);                       // queries: const, allocate nothing, may run on any thread
//   bvh.box(lo, hi, [&](int32_t triangle) {...});
//   int n = bvh.line(origin, direction, t0, t1, span);
//
// Nodes are stored depth first, a parent before its children, split at the median, so the depth is at most
// log2(n) + 1 and every walk runs on a fixed stack. Boxes are floats rounded outwards; triangles are tested in double.
// closest() walks a wider tree of the same nodes, four boxes at a time, down to boxes of single triangles.
// The same input gives the same tree and the same answers everywhere (ties go to the lower triangle index).
#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "sim/base/node4.h"
#include "sim/geometry/vec.h"

namespace limberg {

class Bvh {
 public:
  struct Closest {
    int32_t triangle = -1;  // -1: nothing within the distance asked for
    Vec3 point_mm = Vec3::Zero();
    std::array<double, 3> bary{};  // exact zeros name a corner or an edge (triangle.h)
    double distance_mm = std::numeric_limits<double>::infinity();
  };
  struct LineHit {
    double t = 0;  // point = origin + t * direction
    int32_t triangle = -1;
    std::array<double, 3> bary{};
    bool from_outside = false;  // the line enters through the triangle's counter-clockwise side
  };

  Bvh() = default;
  /// Keeps its own copy of both. Triangle indices must be valid.
  Bvh(std::span<const Vec3> X_mm, std::span<const Tri> tri) : Bvh(X_mm, tri, {}) {}
  /// Only over the triangles listed in `subset` (indices into tri; empty = all). Answers name indices into tri.
  Bvh(std::span<const Vec3> X_mm, std::span<const Tri> tri, std::span<const int32_t> subset);

  /// New positions of the same vertices; queries then see them.
  void refit(std::span<const Vec3> x_mm);
  void refit(std::span<const Vec3f> x_mm);

  bool empty() const { return node_.empty(); }
  size_t triangles() const { return order_.size(); }

  /// The nearest point of the surface within max_distance_mm.
  Closest closest(const Vec3& p_mm, double max_distance_mm = std::numeric_limits<double>::infinity()) const;

  /// All crossings of origin + t direction, t0 <= t <= t1, sorted by t (then triangle), as many as fit into `out`
  /// (the first ones); returns how many there are. A line through a shared edge or corner reports every triangle there,
  /// never none: the test is watertight. Triangles parallel to the line are not reported.
  int line(const Vec3& origin_mm, const Vec3& direction, double t0, double t1, std::span<LineHit> out) const;
  std::vector<LineHit> line(const Vec3& origin_mm, const Vec3& direction, double t0, double t1) const;

  /// Calls visit(triangle) for every triangle whose box meets [lo, hi]; order is that of the tree.
  template <class Visit>
  void box(const Vec3& lo_mm, const Vec3& hi_mm, Visit&& visit) const {
    if (node_.empty()) return;
    int32_t stack[kStack];
    int n = 0;
    stack[n++] = 0;
    while (n > 0) {
      const Node& node = node_[size_t(stack[--n])];
      if (!node.meets(lo_mm, hi_mm)) continue;
      if (node.count > 0) {
        for (int32_t i = node.first; i < node.first + node.count; ++i)
          if (triangle_meets(order_[size_t(i)], lo_mm, hi_mm)) visit(order_[size_t(i)]);
      } else {
        stack[n++] = node.second;
        stack[n++] = int32_t(&node - node_.data()) + 1;
      }
    }
  }

 private:
  static constexpr int kStack = 64;
  static constexpr int32_t kLeaf = 4;
  struct Node {
    Vec3f lo, hi;
    int32_t count = 0;   // > 0: a leaf of so many triangles
    int32_t first = 0;   // leaf: into order_
    int32_t second = 0;  // inner: the second child (the first is the next node)
    bool meets(const Vec3& a, const Vec3& b) const {
      return lo.x() <= b.x() && hi.x() >= a.x() && lo.y() <= b.y() && hi.y() >= a.y() && lo.z() <= b.z() &&
             hi.z() >= a.z();
    }
  };
  struct Four {  // children, side by side; those beyond `count` are empty
    v4 lo[3], hi[3];
    std::array<int32_t, 4> child{};  // another of these, or ~ of a triangle
    std::array<int32_t, 4> node{};   // whose box it is; of a triangle: unused
    int32_t count = 0;
  };
  int32_t build(int32_t first, int32_t count, std::span<const Vec3> centre);
  int32_t widen(int32_t node);
  void fit();
  void fit_fours();
  bool triangle_meets(int32_t t, const Vec3& lo, const Vec3& hi) const;
  template <class Visit>
  void walk_line(const Vec3& o, const Vec3& d, double t0, double t1, Visit&& visit) const;

  std::vector<Vec3> x_;
  std::vector<Tri> tri_;
  std::vector<int32_t> order_;
  std::vector<Node> node_;
  std::vector<Four> four_;  // the first is the root
};

}  // namespace limberg
