#pragma once
// The nearest triangle that faces a place: a box tree over moving triangles that knows which way they look.
//
// Every node bounds the places and the normals of the triangles of its four children, so a walk skips what is too far and
// what does not look the other way, four at a time. Places and normals are refitted each step; the tree itself is built
// once, at rest.
//
// A triangle faces a place when n . n_T < -0.2, n the outward normal of the place's own surface, as things lie now. Whether
// it may answer at all is for the caller to say: most of what faces a place is behind it in the same piece of tissue.
#include <array>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

#include "sim/fem/simd.h"
#include "sim/geometry/triangle.h"
#include "sim/geometry/vec.h"

namespace limberg {

class FacingTree {
 public:
  struct Query {
    Vec3 p_mm, n;
    double within_mm = 2;
    int32_t guess = -1;    // a triangle that may be near; the answer does not depend on it
  };
  struct Foot {
    int32_t triangle = -1;  // -1: none
    Vec3 point_mm = Vec3::Zero();
    std::array<double, 3> bary{};
    double distance_mm = 0;
  };

  FacingTree() = default;
  /// Triangles without area never answer.
  FacingTree(std::vector<Vec3> X_mm, std::vector<Tri> tri);

  void refit(std::span<const Vec3> x_mm);
  /// The nearest facing triangle for which `accept(triangle, bary of its nearest point)` holds. Ties go to the lower index.
  template <class Accept>
  Foot nearest(const Query& query, Accept&& accept) const;

  const std::vector<Tri>& triangles() const { return tri_; }
  const Vec3& place_mm(int32_t vertex) const { return x_[size_t(vertex)]; }
  const Vec3& rest_mm(int32_t vertex) const { return X_[size_t(vertex)]; }
  const Vec3& normal(int32_t triangle) const { return n_[size_t(triangle)]; }       // now
  const Vec3& rest_normal(int32_t triangle) const { return N_[size_t(triangle)]; }

 private:
  static constexpr double kFacing = -0.2;  // cosine between the normals of two surfaces that meet
  static constexpr int32_t kLeaf = 4;
  static constexpr int kStack = 96;
  /// Bounds of four children, one number of each in a lane; a little larger than what they hold, so that single precision
  /// never loses anything. An empty lane is nowhere.
  struct Node {
    fem::v4 lo[3], hi[3], normal_lo[3], normal_hi[3];
    std::array<int32_t, 4> child{};  // node, or first place in order_
    std::array<int32_t, 4> count{};  // > 0: a leaf of so many triangles; 0: a node; -1: empty
  };
  struct Box {
    Vec3f lo, hi, normal_lo, normal_hi;
  };
  int32_t build(int32_t first, int32_t count, std::span<const Vec3> centre);
  int32_t split(int32_t first, int32_t count, std::span<const Vec3> centre);
  Box box_of(const Node& node) const;

  std::vector<Vec3> X_, x_;
  std::vector<Tri> tri_;
  std::vector<Vec3> N_, n_;
  std::vector<int32_t> order_;
  std::vector<Node> node_;
};

template <class Accept>
FacingTree::Foot FacingTree::nearest(const Query& q, Accept&& accept) const {
  Foot foot;
  if (node_.empty()) return foot;
  double best2 = q.within_mm * q.within_mm;
  const auto try_triangle = [&](int32_t t) {
    if (!(q.n.dot(n_[size_t(t)]) < kFacing)) return;
    const Tri& c = tri_[size_t(t)];
    const TrianglePoint at = closest_on_triangle(q.p_mm, x_[size_t(c[0])], x_[size_t(c[1])], x_[size_t(c[2])]);
    const double d2 = (at.point - q.p_mm).squaredNorm();
    if (d2 > best2 || (d2 == best2 && foot.triangle >= 0 && t >= foot.triangle) || !accept(t, at.bary)) return;
    best2 = d2;
    foot.triangle = t, foot.point_mm = at.point, foot.bary = at.bary;
  };
  if (q.guess >= 0) try_triangle(q.guess);
  fem::v4 p[3], n[3];
  for (int a = 0; a < 3; ++a) p[a] = fem::v4{} + float(q.p_mm[a]), n[a] = fem::v4{} + float(q.n[a]);
  struct Item {
    int32_t child, count;
    float d2;
  } stack[kStack];
  int top = 0;
  stack[top++] = {0, 0, 0};
  while (top > 0) {
    const Item it = stack[--top];
    if (double(it.d2) > best2) continue;
    if (it.count > 0) {
      for (int32_t i = it.child; i < it.child + it.count; ++i) try_triangle(order_[size_t(i)]);
      continue;
    }
    const Node& node = node_[size_t(it.child)];
    fem::v4 d2 = {}, facing = {};
    for (int a = 0; a < 3; ++a) {
      const fem::v4 under = node.lo[a] - p[a], over = p[a] - node.hi[a], zero = {};
      fem::v4 d = under > over ? under : over;
      d = d > zero ? d : zero;
      d2 += d * d;
      const fem::v4 l = n[a] * node.normal_lo[a], h = n[a] * node.normal_hi[a];
      facing += l < h ? l : h;
    }
    const int bottom = top;
    for (size_t k = 0; k < 4; ++k) {
      if (double(d2[k]) > best2 || double(facing[k]) >= kFacing || node.count[k] < 0) continue;
      int at = top++;  // nearer ones on top
      for (; at > bottom && stack[at - 1].d2 < d2[k]; --at) stack[at] = stack[at - 1];
      stack[at] = {node.child[k], node.count[k], d2[k]};
    }
  }
  foot.distance_mm = foot.triangle >= 0 ? std::sqrt(best2) : 0;
  return foot;
}

}  // namespace limberg
