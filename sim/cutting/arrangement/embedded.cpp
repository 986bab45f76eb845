// Is a blade a surface without contact with itself? What cutting rests on.
#include <algorithm>

#include "sim/cutting/arrangement/tri_tests.h"

namespace limberg {

BoxTree tree_over(std::span<const IntTriangle> triangle) {
  std::vector<std::array<Int3, 3>> corner;
  corner.reserve(triangle.size());
  for (const IntTriangle& t : triangle) corner.push_back(t.p);
  return BoxTree(corner);
}

std::vector<IntTriangle> int_triangles(std::span<const Int3> vertex, std::span<const Tri> tri) {
  std::vector<IntTriangle> out(tri.size());
  for (size_t i = 0; i < tri.size(); ++i) {
    out[i].id = tri[i];
    for (size_t k = 0; k < 3; ++k) out[i].p[k] = vertex[size_t(tri[i][k])];
  }
  return out;
}

std::string check_embedded(std::span<const Int3> vertex, std::span<const Tri> tri) {
  const std::vector<IntTriangle> triangle = int_triangles(vertex, tri);
  std::vector<Plane> plane;
  std::vector<IntBox> box;
  for (const IntTriangle& t : triangle) {
    plane.push_back(plane_through(t.p[0], t.p[1], t.p[2]));
    box.push_back(box_around(t.p[0], t.p[1], t.p[2]));
  }
  return check_embedded(triangle, plane, box);
}

std::string check_embedded(std::span<const IntTriangle> triangle, std::span<const Plane> plane,
                           std::span<const IntBox> box) {
  for (const Plane& p : plane)
    if (p.n[0] == 0 && p.n[1] == 0 && p.n[2] == 0) return "the blade has a triangle without area";
  const auto meet = [&](size_t i, size_t j) {
    return meet_beyond_shared(triangle[i], plane[i], triangle[j], plane[j]);
  };
  constexpr const char* kThroughItself = "the blade runs through itself";
  std::vector<BoxGroup> group;
  for (size_t i = 0; i < triangle.size(); i = group.back().end()) group.emplace_back(box, i);
  constexpr size_t kFew = 64;
  if (group.size() <= kFew) {  // a tree would cost more than asking every pair of groups
    for (size_t g = 0; g < group.size(); ++g)
      for (size_t h = g; h < group.size(); ++h) {
        if (!group[g].all.meets(group[h].all)) continue;
        for (size_t j = std::max(group[h].first, group[g].first + 1); j < group[h].end(); ++j) {
          const uint32_t bits = group[g].meeting(box[j]);
          for (size_t i = 0; i < group[g].count && bits >> i != 0; ++i)
            if ((bits >> i & 1) && group[g].first + i < j && meet(group[g].first + i, j)) return kThroughItself;
        }
      }
    return {};
  }
  const BoxTree tree = tree_over(triangle);
  bool folded = false;
  for (const BoxGroup& g : group) {
    tree.box(g.all, [&](int32_t at, const IntBox& its) {
      const size_t j = size_t(at);
      if (folded || j <= g.first) return;
      const uint32_t bits = g.meeting(its);
      for (size_t i = 0; i < g.count && bits >> i != 0; ++i)
        folded = folded || ((bits >> i & 1) && g.first + i < j && meet(g.first + i, j));
    });
    if (folded) return kThroughItself;
  }
  return {};
}

}  // namespace limberg
