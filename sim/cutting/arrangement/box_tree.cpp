#include "sim/cutting/arrangement/box_tree.h"

namespace limberg {

// Split at the median of the centres along the longest side, down to leaves of four triangles. Two levels of such
// splits make one node.
struct BoxTree::Builder {
  std::span<const std::array<Int3, 3>> triangle;
  std::vector<Item> item;
  std::vector<Node>& node;
  const Steps& steps;
  std::vector<uint32_t> up, down;  // room: what stands too far left, too far right

  struct Range {
    int32_t first, count;
  };
  static constexpr int32_t kLeaf = 4;

  // Along an axis, the name after it: no two are equal.
  int64_t key(const Item& x, int axis) const {
    return int64_t(uint64_t(int64_t(x.sum[axis])) << 32 | uint32_t(x.triangle));
  }

  /// Brings the lower half to the front: quickselect by Hoare's partition about the median of three. Which elements are
  /// to change places is found without a branch on how two compare, which no processor can foresee.
  void halve(const Range& r, int axis) {
    Item* first = item.data() + r.first;
    Item* last = first + r.count;
    Item* const nth = first + r.count / 2;
    const auto less = [&](const Item* x, const Item* y) { return key(*x, axis) < key(*y, axis); };
    while (last - first > 3) {
      Item *u = first + 1, *v = first + (last - first) / 2, *w = last - 1;  // their median becomes the first
      if (less(v, u)) std::swap(u, v);
      if (less(w, v)) v = less(w, u) ? u : w;
      std::swap(*first, *v);
      const int64_t pivot = key(*first, axis);
      const uint32_t n = uint32_t(last - first);
      uint32_t ups = 0;
      for (uint32_t i = 1; i < n; ++i) {  // each goes to both lists, and stays in one
        up[ups] = i;
        down[i - 1 - ups] = i;
        ups += key(first[i], axis) > pivot;
      }
      const uint32_t downs = n - 1 - ups;
      for (uint32_t i = 0; i < std::min(ups, downs) && up[i] < down[downs - 1 - i]; ++i)
        std::swap(first[up[i]], first[down[downs - 1 - i]]);
      Item* const cut = first + 1 + downs;
      if (cut <= nth)
        first = cut;
      else
        last = cut;
    }
    for (Item* i = first; i != last; ++i)
      for (Item* j = i; j != first && less(j, j - 1); --j) std::swap(*j, *(j - 1));
  }

  void split(const Range& r, Range& a, Range& b) {
    Int3 lo = item[size_t(r.first)].sum, hi = lo;
    for (int32_t i = r.first; i < r.first + r.count; ++i) {
      const Int3& s = item[size_t(i)].sum;
      lo = {std::min(lo.x, s.x), std::min(lo.y, s.y), std::min(lo.z, s.z)};
      hi = {std::max(hi.x, s.x), std::max(hi.y, s.y), std::max(hi.z, s.z)};
    }
    int axis = 0;
    double longest = -1;
    for (int k = 0; k < 3; ++k) {
      const double side = double(hi[k]) / 3 - double(lo[k]) / 3;
      if (side > longest) longest = side, axis = k;
    }
    halve(r, axis);
    a = {r.first, r.count / 2};
    b = {r.first + r.count / 2, r.count - r.count / 2};
  }

  IntBox build(int32_t at, const Range& r) {
    std::array<Range, 4> part;
    size_t parts = 0;
    const bool leaf = r.count <= kLeaf;
    if (leaf) {
      for (int32_t i = 0; i < r.count; ++i) part[parts++] = {r.first + i, 1};
    } else {
      Range half[2];
      split(r, half[0], half[1]);
      for (const Range& h : half) {
        if (h.count <= kLeaf) {
          part[parts++] = h;
        } else {
          split(h, part[parts], part[parts + 1]);
          parts += 2;
        }
      }
    }
    IntBox all{};
    for (size_t k = 0; k < parts; ++k) {
      IntBox b;
      int32_t child;
      if (leaf) {
        const int32_t t = item[size_t(part[k].first)].triangle;
        b = box_around(triangle[size_t(t)][0], triangle[size_t(t)][1], triangle[size_t(t)][2]);
        child = ~t;
      } else {
        child = int32_t(node.size());
        node.emplace_back();
        b = build(child, part[k]);
      }
      all = k == 0 ? b : box_around(all, b);
      Node& n = node[size_t(at)];
      for (size_t i = 0; i < 3; ++i)
        n.lo[i][k] = steps.rounded(b.lo[int(i)], i), n.hi[i][k] = steps.rounded(b.hi[int(i)], i);
      n.child[k] = child;
    }
    return all;
  }
};

BoxTree::BoxTree(std::span<const std::array<Int3, 3>> triangle) {
  if (triangle.empty()) return;
  Builder b{triangle,
            {},
            node_,
            steps_,
            std::vector<uint32_t>(triangle.size() + 1),
            std::vector<uint32_t>(triangle.size() + 1)};
  b.item.reserve(triangle.size());
  IntBox& all = steps_.all;
  for (size_t t = 0; t < triangle.size(); ++t) {
    const auto& [p, q, r] = triangle[t];
    b.item.push_back({{p.x + q.x + r.x, p.y + q.y + r.y, p.z + q.z + r.z}, int32_t(t)});
    all = t == 0 ? box_around(p, q, r) : box_around(all, box_around(p, q, r));
  }
  const int32_t longest = std::max({all.hi.x - all.lo.x, all.hi.y - all.lo.y, all.hi.z - all.lo.z});
  while (longest >> steps_.shift > UINT16_MAX) ++steps_.shift;
  node_.reserve(triangle.size() * 3 / 4 + 1);
  node_.emplace_back();
  b.build(0, {0, int32_t(triangle.size())});
  node_.shrink_to_fit();
}

}  // namespace limberg
