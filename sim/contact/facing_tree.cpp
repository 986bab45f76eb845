#include "sim/contact/facing_tree.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numeric>

namespace limberg {
namespace {

constexpr float kPlaceSlack_mm = 1e-3f, kNormalSlack = 1e-5f;  // far above what single precision rounds away

Vec3 unit_normal(const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 n = area_vector2(a, b, c);
  const double l = n.norm();
  return l > 1e-12 ? Vec3(n / l) : Vec3(0, 0, 0);
}

}  // namespace

FacingTree::FacingTree(std::vector<Vec3> X_mm, std::vector<Tri> tri, std::vector<int32_t> sheet)
    : X_(std::move(X_mm)), tri_(std::move(tri)), sheet_(std::move(sheet)) {
  const size_t n = tri_.size();
  order_.resize(n);
  std::iota(order_.begin(), order_.end(), 0);
  std::vector<Vec3> centre(n);
  N_.resize(n), n_.resize(n);
  for (size_t t = 0; t < n; ++t) {
    const Vec3 &a = X_[size_t(tri_[t][0])], &b = X_[size_t(tri_[t][1])], &c = X_[size_t(tri_[t][2])];
    centre[t] = (a + b + c) / 3;
    N_[t] = unit_normal(a, b, c);
  }
  if (n > 0) build(0, int32_t(n), centre);
  InlineWorkers here;
  refit(X_, here);
}

// Parts [first, first + count) of order_ in two; returns how many are in the first.
int32_t FacingTree::split(int32_t first, int32_t count, std::span<const Vec3> centre) {
  // By sheets first: once a place has a foot on a sheet, all else of the sheet that is farther is passed over.
  const auto sheet_of = [&](int32_t t) { return sheet_[size_t(t)]; };
  const auto whole = order_.begin() + first;
  if (std::any_of(whole, whole + count, [&](int32_t t) { return sheet_of(t) != sheet_of(*whole); })) {
    std::stable_sort(whole, whole + count, [&](int32_t a, int32_t b) { return sheet_of(a) < sheet_of(b); });
    int32_t best = 0;
    for (int32_t i = 1; i < count; ++i)
      if (sheet_of(whole[i]) != sheet_of(whole[i - 1]) && (best == 0 || std::abs(2 * i - count) < std::abs(2 * best - count))) best = i;
    return best;
  }
  // Then by normals, where they differ much: the two sides of a cut lie in the same place. Then by place.
  Vec3 lo = centre[size_t(order_[size_t(first)])], hi = lo, nlo = N_[size_t(order_[size_t(first)])], nhi = nlo;
  for (int32_t i = first; i < first + count; ++i) {
    const size_t t = size_t(order_[size_t(i)]);
    lo = lo.cwiseMin(centre[t]), hi = hi.cwiseMax(centre[t]);
    nlo = nlo.cwiseMin(N_[t]), nhi = nhi.cwiseMax(N_[t]);
  }
  const auto begin = order_.begin() + first, end = begin + count;
  int axis = 0;
  if ((nhi - nlo).maxCoeff(&axis) > 1) {
    const double middle = 0.5 * (nlo[axis] + nhi[axis]);
    const int32_t left = int32_t(std::stable_partition(begin, end, [&](int32_t t) { return N_[size_t(t)][axis] < middle; }) - begin);
    if (std::min(left, count - left) * 16 >= count) return left;
  }
  (hi - lo).maxCoeff(&axis);
  std::nth_element(begin, begin + count / 2, end, [&](int32_t a, int32_t b) {
    return std::pair(centre[size_t(a)][axis], a) < std::pair(centre[size_t(b)][axis], b);
  });
  return count / 2;
}

int32_t FacingTree::build(int32_t first, int32_t count, std::span<const Vec3> centre) {
  const int32_t self = int32_t(node_.size());
  node_.emplace_back();
  std::array<std::pair<int32_t, int32_t>, 4> part{{{first, count}}};
  size_t parts = 1;
  while (parts < 4) {
    size_t largest = 0;
    for (size_t k = 1; k < parts; ++k)
      if (part[k].second > part[largest].second) largest = k;
    auto& [f, c] = part[largest];
    if (c <= kLeaf) break;
    const int32_t left = split(f, c, centre);
    part[parts++] = {f + left, c - left};
    c = left;
  }
  for (size_t k = 0; k < 4; ++k) {
    int32_t child = 0, leaf = -1;
    if (k < parts && part[k].second > 0) {
      leaf = part[k].second <= kLeaf ? part[k].second : 0;
      child = leaf > 0 ? part[k].first : build(part[k].first, part[k].second, centre);
    }
    Node& node = node_[size_t(self)];
    node.child[k] = child, node.count[k] = leaf, node.sheet[k] = -1;
    if (leaf < 0) continue;
    const auto begin = order_.begin() + part[k].first, end = begin + part[k].second;
    const int32_t sheet = sheet_[size_t(*begin)];
    if (std::all_of(begin, end, [&](int32_t t) { return sheet_[size_t(t)] == sheet; })) node.sheet[k] = sheet;
  }
  return self;
}

FacingTree::Box FacingTree::box_of(const Node& node) const {
  Box b;
  for (int a = 0; a < 3; ++a) {
    b.lo[a] = b.normal_lo[a] = std::numeric_limits<float>::max();
    b.hi[a] = b.normal_hi[a] = -std::numeric_limits<float>::max();
    for (int k = 0; k < 4; ++k) {
      if (node.count[size_t(k)] < 0) continue;
      b.lo[a] = std::min(b.lo[a], node.lo[a][k]), b.hi[a] = std::max(b.hi[a], node.hi[a][k]);
      b.normal_lo[a] = std::min(b.normal_lo[a], node.normal_lo[a][k]), b.normal_hi[a] = std::max(b.normal_hi[a], node.normal_hi[a][k]);
    }
  }
  return b;
}

void FacingTree::refit_leaves(Node& node) const {
  for (size_t k = 0; k < 4; ++k) {
    if (node.count[k] <= 0) continue;
    const size_t t0 = size_t(order_[size_t(node.child[k])]);
    Vec3 lo = x_[size_t(tri_[t0][0])], hi = lo, nlo = n_[t0], nhi = nlo;
    for (int32_t j = node.child[k]; j < node.child[k] + node.count[k]; ++j) {
      const size_t t = size_t(order_[size_t(j)]);
      for (int32_t v : tri_[t]) lo = lo.cwiseMin(x_[size_t(v)]), hi = hi.cwiseMax(x_[size_t(v)]);
      nlo = nlo.cwiseMin(n_[t]), nhi = nhi.cwiseMax(n_[t]);
    }
    for (int a = 0; a < 3; ++a) {
      node.lo[a][k] = float(lo[a]) - kPlaceSlack_mm, node.hi[a][k] = float(hi[a]) + kPlaceSlack_mm;
      node.normal_lo[a][k] = float(nlo[a]) - kNormalSlack, node.normal_hi[a][k] = float(nhi[a]) + kNormalSlack;
    }
  }
}

void FacingTree::refit(std::span<const Vec3> x_mm, Workers& workers) {
  assert(x_mm.size() == X_.size());
  x_.assign(x_mm.begin(), x_mm.end());
  constexpr size_t grain = 512;
  workers.parallel_for(tri_.size(), grain, [&](size_t begin, size_t end) {
    for (size_t t = begin; t < end; ++t) n_[t] = unit_normal(x_[size_t(tri_[t][0])], x_[size_t(tri_[t][1])], x_[size_t(tri_[t][2])]);
  });
  workers.parallel_for(node_.size(), grain, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) refit_leaves(node_[i]);
  });
  for (size_t i = node_.size(); i-- > 0;) {  // children stand after their parent
    Node& node = node_[i];
    for (size_t k = 0; k < 4; ++k) {
      if (node.count[k] != 0) continue;
      const Box b = box_of(node_[size_t(node.child[k])]);
      for (int a = 0; a < 3; ++a) {
        node.lo[a][k] = b.lo[a], node.hi[a][k] = b.hi[a];
        node.normal_lo[a][k] = b.normal_lo[a], node.normal_hi[a][k] = b.normal_hi[a];
      }
    }
  }
}

}  // namespace limberg
