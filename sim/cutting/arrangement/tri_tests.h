#pragma once
// Exact tests between integer triangles.
#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sim/cutting/arrangement/box_tree.h"
#include "sim/geometry/exact/predicates.h"

namespace limberg {

struct IntTriangle {
  std::array<Int3, 3> p;
  std::array<int32_t, 3> id{};  // vertex names: equal names are the same vertex
};

/// Do two triangles have a point in common besides the vertices and the edge that they share by name? Touching counts.
bool meet_beyond_shared(const IntTriangle& s, const IntTriangle& t);
bool meet_beyond_shared(const IntTriangle& s, const Plane& plane_s, const IntTriangle& t, const Plane& plane_t);

/// Where two triangles without shared vertices cross in general position: the two ends of the common segment.
struct CrossingEnd {
  bool edge_of_s = false;  // an edge of s ends inside t; else an edge of t inside s
  int edge = 0;            // from corner edge to edge + 1
};
struct Crossing {
  enum Kind : uint8_t { apart, crossing, coincidence } kind = apart;
  std::array<CrossingEnd, 2> end;
};
Crossing cross_triangles(const IntTriangle& s, const Plane& plane_s, const IntTriangle& t, const Plane& plane_t);

/// The same when s holds vertices that cannot be moved: a vertex that lies in the other's plane, but not on the other
/// triangle, is no coincidence. (Below a straight incision the continuing blade lies in its plane.)
Crossing cross_triangles_exactly(const IntTriangle& s, const Plane& plane_s, const IntTriangle& t,
                                 const Plane& plane_t);

/// Triangles by their vertices' indices and places.
std::vector<IntTriangle> int_triangles(std::span<const Int3> vertex, std::span<const Tri> tri);
/// Around triangles that lie in nearly one plane; around any others it is a box and little else.
SlantBox slant_box(const IntBox& box, std::span<const IntTriangle> triangle, std::span<const Plane> plane);
BoxTree tree_over(std::span<const IntTriangle> triangle);

/// Is a blade surface embedded? Empty when it is; else what is wrong.
/// Triangles named by their vertices, with their planes and boxes.
std::string check_embedded(std::span<const IntTriangle> triangle, std::span<const Plane> plane,
                           std::span<const IntBox> box);
std::string check_embedded(std::span<const Int3> vertex, std::span<const Tri> tri);

}  // namespace limberg
