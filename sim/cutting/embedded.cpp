// Is a blade a surface without contact with itself? What cutting rests on.
#include "sim/cutting/tri_tests.h"

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
  for (const IntTriangle& t : triangle) plane.push_back(plane_through(t.p[0], t.p[1], t.p[2]));
  return check_embedded(triangle, plane, tree_over(triangle));
}

std::string check_embedded(std::span<const IntTriangle> triangle, std::span<const Plane> plane, const BoxTree& tree) {
  for (const Plane& p : plane)
    if (p.n[0] == 0 && p.n[1] == 0 && p.n[2] == 0) return "the blade has a triangle without area";
  std::vector<IntBox> box;
  box.reserve(triangle.size());
  for (const IntTriangle& t : triangle) box.push_back(box_around(t.p[0], t.p[1], t.p[2]));
  // Neighbours in the list are mostly neighbours in space: one walk down the tree serves several.
  constexpr size_t kGroup = 8;
  std::vector<int32_t> near;
  for (size_t first = 0; first < triangle.size(); first += kGroup) {
    const size_t last = std::min(first + kGroup, triangle.size());
    IntBox group = box[first];
    for (size_t i = first + 1; i < last; ++i) group = box_around(group, box[i]);
    near.clear();
    tree.box(group, [&](int32_t j) {
      if (size_t(j) > first) near.push_back(j);
    });
    for (size_t i = first; i < last; ++i)
      for (int32_t j : near)
        if (size_t(j) > i && box[i].meets(box[size_t(j)]) &&
            meet_beyond_shared(triangle[i], plane[i], triangle[size_t(j)], plane[size_t(j)]))
          return "the blade runs through itself";
  }
  return {};
}

}  // namespace limberg
