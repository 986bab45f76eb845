#pragma once
// The nearest points of other sheets that face a place: a box tree over moving triangles that knows which way they look.
//
// Every node bounds the places and the normals of the triangles of its four children, so a walk skips what is too far and
// what does not look the other way, four at a time. Places and normals are refitted each step; the tree itself is built
// once, at rest.
//
// A triangle faces a place when n . n_T < -0.1, n the outward normal of the place's own surface, as things lie now. Asked
// for is the nearest point of each sheet: within near_mm anywhere, within deep_mm on the place's own inner side, where a
// sheet lies that it has gone through. (One sheet alone can be asked for.) Whether a point may answer at all is for the caller to say: most of what faces a place
// is behind it in the same piece of tissue.
#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

#include "sim/fem/simd.h"
#include "sim/geometry/triangle.h"
#include "sim/geometry/vec.h"
#include "sim/workers.h"

namespace limberg {

class FacingTree {
 public:
  static constexpr size_t kFeet = 4;
  struct Query {
    Vec3 p_mm, n;
    double near_mm = 0.75, deep_mm = 2.5;
    int32_t sheet = -1;  // the only one asked about; -1: all
    std::span<const int32_t> guess;  // triangles that may be near, or -1; the answer does not depend on them
  };
  struct Foot {
    int32_t triangle = -1, sheet = -1;
    Vec3 point_mm = Vec3::Zero();
    std::array<double, 3> bary{};
    double distance_mm = 0;
  };
  using Feet = std::array<Foot, kFeet>;

  FacingTree() = default;
  /// `sheet` per triangle. Triangles without area never answer.
  FacingTree(std::vector<Vec3> X_mm, std::vector<Tri> tri, std::vector<int32_t> sheet);

  void refit(std::span<const Vec3> x_mm, Workers& workers);
  /// The nearest facing point of each sheet for which `accept(triangle, bary)` holds, nearest first, of the kFeet nearest
  /// sheets; returns how many. Ties go to the lower triangle.
  template <class Accept>
  size_t nearest(const Query& query, Accept&& accept, Feet& feet) const;

  /// visit(triangle, its nearest point, distance squared) for every triangle within within_mm of p, whichever way it looks.
  template <class Visit>
  void near(const Vec3& p_mm, double within_mm, Visit&& visit) const;

  const std::vector<Tri>& triangles() const { return tri_; }
  const Vec3& place_mm(int32_t vertex) const { return x_[size_t(vertex)]; }
  const Vec3& rest_mm(int32_t vertex) const { return X_[size_t(vertex)]; }
  const Vec3& normal(int32_t triangle) const { return n_[size_t(triangle)]; }       // now
  const Vec3& rest_normal(int32_t triangle) const { return N_[size_t(triangle)]; }

 private:
  static constexpr double kFacing = -0.1;  // cosine between the normals of two surfaces that meet
  static constexpr int32_t kLeaf = 4;
  static constexpr int kStack = 96;
  /// Bounds of four children, one number of each in a lane; a little larger than what they hold, so that single precision
  /// never loses anything. An empty lane is nowhere.
  struct Node {
    fem::v4 lo[3], hi[3], normal_lo[3], normal_hi[3];
    std::array<int32_t, 4> child{};  // node, or first place in order_
    std::array<int32_t, 4> count{};  // > 0: a leaf of so many triangles; 0: a node; -1: empty
    std::array<int32_t, 4> sheet{};  // that all its triangles belong to, or -1
  };
  struct Box {
    Vec3f lo, hi, normal_lo, normal_hi;
  };
  void refit_leaves(Node& node) const;
  int32_t build(int32_t first, int32_t count, std::span<const Vec3> centre);
  int32_t split(int32_t first, int32_t count, std::span<const Vec3> centre);
  Box box_of(const Node& node) const;

  std::vector<Vec3> X_, x_;
  std::vector<Tri> tri_;
  std::vector<int32_t> sheet_;
  std::vector<Vec3> N_, n_;
  std::vector<int32_t> order_;
  std::vector<Node> node_;
};

template <class Accept>
size_t FacingTree::nearest(const Query& q, Accept&& accept, Feet& feet) const {
  size_t count = 0;
  if (node_.empty()) return 0;
  const double near2 = q.near_mm * q.near_mm, deep2 = q.deep_mm * q.deep_mm, far2 = std::max(near2, deep2);
  // While it runs, distance_mm holds the square.
  const auto reach2 = [&](int32_t sheet) {  // farther than this nothing of the sheet can be an answer
    double worst = 0;
    if (q.sheet >= 0) return count > 0 ? feet[0].distance_mm : far2;
    for (size_t k = 0; k < count; ++k) {
      if (feet[k].sheet == sheet) return feet[k].distance_mm;
      worst = std::max(worst, feet[k].distance_mm);
    }
    return count == kFeet ? worst : far2;
  };
  const auto try_triangle = [&](int32_t t) {
    if (q.sheet >= 0 && sheet_[size_t(t)] != q.sheet) return;
    if (!(q.n.dot(n_[size_t(t)]) < kFacing)) return;
    const Tri& c = tri_[size_t(t)];
    const TrianglePoint at = closest_on_triangle(q.p_mm, x_[size_t(c[0])], x_[size_t(c[1])], x_[size_t(c[2])]);
    const Vec3 r = q.p_mm - at.point;
    const double d2 = r.squaredNorm();
    if (d2 > (r.dot(q.n) >= 0 ? deep2 : near2)) return;
    const int32_t sheet = sheet_[size_t(t)];
    size_t k = 0;
    while (k < count && feet[k].sheet != sheet) ++k;
    if (k < count) {
      if (d2 > feet[k].distance_mm || (d2 == feet[k].distance_mm && t >= feet[k].triangle)) return;
    } else if (k == kFeet) {
      for (size_t j = k = 0; j < kFeet; ++j)
        if (std::pair(feet[j].distance_mm, feet[j].sheet) > std::pair(feet[k].distance_mm, feet[k].sheet)) k = j;
      if (std::pair(d2, sheet) > std::pair(feet[k].distance_mm, feet[k].sheet)) return;
    }
    if (!accept(t, at.bary)) return;
    count = std::max(count, k + 1);
    feet[k] = {t, sheet, at.point, at.bary, d2};
  };
  for (int32_t t : q.guess)
    if (t >= 0) try_triangle(t);
  fem::v4 p[3], n[3];
  for (int a = 0; a < 3; ++a) p[a] = fem::v4{} + float(q.p_mm[a]), n[a] = fem::v4{} + float(q.n[a]);
  struct Item {
    int32_t child, count, sheet;
    float d2;
  } stack[kStack];
  int top = 0;
  stack[top++] = {0, 0, -1, 0};
  while (top > 0) {
    const Item it = stack[--top];
    if (double(it.d2) > reach2(it.sheet)) continue;
    if (it.count > 0) {
      for (int32_t i = it.child; i < it.child + it.count; ++i) try_triangle(order_[size_t(i)]);
      continue;
    }
    const Node& node = node_[size_t(it.child)];
    fem::v4 d2 = {}, facing = {}, inward = {};
    for (int a = 0; a < 3; ++a) {
      const fem::v4 under = node.lo[a] - p[a], over = p[a] - node.hi[a], zero = {};
      fem::v4 d = under > over ? under : over;
      d = d > zero ? d : zero;
      d2 += d * d;
      const fem::v4 l = n[a] * node.normal_lo[a], h = n[a] * node.normal_hi[a];
      facing += l < h ? l : h;
      const fem::v4 from = -n[a] * under, to = n[a] * over;  // n . (p - x) at the box's two sides
      inward += from > to ? from : to;
    }
    const int bottom = top;
    for (size_t k = 0; k < 4; ++k) {
      if (node.count[k] < 0 || double(facing[k]) >= kFacing || double(d2[k]) > (inward[k] >= 0 ? deep2 : near2)) continue;
      if (double(d2[k]) > reach2(node.sheet[k])) continue;
      if (q.sheet >= 0 && node.sheet[k] >= 0 && node.sheet[k] != q.sheet) continue;
      int at = top++;  // nearer ones on top
      for (; at > bottom && stack[at - 1].d2 < d2[k]; --at) stack[at] = stack[at - 1];
      stack[at] = {node.child[k], node.count[k], node.sheet[k], d2[k]};
    }
  }
  for (size_t k = 1; k < count; ++k)
    for (size_t j = k; j > 0 && std::pair(feet[j].distance_mm, feet[j].sheet) < std::pair(feet[j - 1].distance_mm, feet[j - 1].sheet); --j)
      std::swap(feet[j], feet[j - 1]);
  for (size_t k = 0; k < count; ++k) feet[k].distance_mm = std::sqrt(feet[k].distance_mm);
  return count;
}

template <class Visit>
void FacingTree::near(const Vec3& p_mm, double within_mm, Visit&& visit) const {
  if (node_.empty()) return;
  const double within2 = within_mm * within_mm;
  fem::v4 p[3];
  for (int a = 0; a < 3; ++a) p[a] = fem::v4{} + float(p_mm[a]);
  std::array<std::pair<int32_t, int32_t>, kStack> stack;
  size_t top = 0;
  stack[top++] = {0, 0};
  while (top > 0) {
    const auto [child, count] = stack[--top];
    for (int32_t i = child; i < child + count; ++i) {
      const int32_t t = order_[size_t(i)];
      const Tri& c = tri_[size_t(t)];
      const TrianglePoint at = closest_on_triangle(p_mm, x_[size_t(c[0])], x_[size_t(c[1])], x_[size_t(c[2])]);
      const double d2 = (at.point - p_mm).squaredNorm();
      if (d2 <= within2) visit(t, at, d2);
    }
    if (count > 0) continue;
    const Node& node = node_[size_t(child)];
    fem::v4 d2 = {};
    for (int a = 0; a < 3; ++a) {
      const fem::v4 under = node.lo[a] - p[a], over = p[a] - node.hi[a], zero = {};
      fem::v4 d = under > over ? under : over;
      d = d > zero ? d : zero;
      d2 += d * d;
    }
    for (size_t k = 0; k < 4; ++k)
      if (node.count[k] >= 0 && double(d2[k]) <= within2) stack[top++] = {node.child[k], node.count[k]};
  }
}

}  // namespace limberg
