#pragma once
// What the lattice needs to know of the material's boundary: faces with two material bits, glued along sided
// half-edges, on exact points. A cutting arrangement fills it (see sync in the caller); a closed mesh can fill it too.
//
// All coordinates are half-units of the rest grid. A point is explicit (even integers), LPI (the line of two explicit
// points meets the plane of a triangle) or TPI (three planes of triangles meet). Every implicit point is turned at once
// into exact homogeneous integers and a double that is right to kApproxError, so later tests are a filter and, rarely,
// one wide-integer evaluation. Triangles are ORIGINAL triangles (body or blade): faces are pieces of them.
#include <cstdint>
#include <span>
#include <vector>

#include "sim/cutting/surface_view.h"
#include "sim/geometry/tri_mesh.h"
#include "sim/geometry/vec.h"
#include "sim/lattice/wide_int.h"

namespace limberg {

/// n . x = d, exact: n fits 46 bits, d fits 70.
struct ExactPlane {
  std::array<int64_t, 3> n{};
  Int128 d = 0;
};

struct MaterialFace {
  std::array<int32_t, 3> point{};
  int32_t triangle = 0;       // original triangle: its plane, oriented like the face
  uint8_t mat = 0;            // bit 0: material on the side the normal points to; bit 1: on the other; 0: not there
  FaceKind kind = FaceKind::skin;
  int32_t cut = -1;           // wall: number of the cut that made it; -1 for the body's own surface
  // Per side and edge (edge e runs from corner e to corner e+1): the sided half-edge glued to it, coded
  // 3 * (2 * face + side) + edge, or -1.
  std::array<std::array<int32_t, 3>, 2> mate{{{-1, -1, -1}, {-1, -1, -1}}};
};

class MaterialSurface {
 public:
  /// Bound on |approx(p) - p| per coordinate, half-units: implicit points are rounded from exact numerators and
  /// denominators (3 roundings of 2^-53 relative, |coordinate| < 2^22), explicit ones are exact.
  static constexpr double kApproxError = 0x1p-29;

  int32_t add_explicit(Int3 p);
  int32_t add_lpi(int32_t a, int32_t b, int32_t triangle);   // a, b explicit points
  int32_t add_tpi(int32_t t0, int32_t t1, int32_t t2);       // triangles
  int32_t add_triangle(Int3 a, Int3 b, Int3 c);
  /// Back to the sizes of an earlier version (undo).
  void truncate(size_t points, size_t triangles, size_t faces);

  std::vector<MaterialFace> faces;  // the filler appends, clears bits and sets mates

  size_t points() const { return approx_.size(); }
  size_t triangles() const { return plane_.size(); }
  const Vec3& approx(int32_t point) const { return approx_[size_t(point)]; }
  bool is_explicit(int32_t point) const { return exact_[size_t(point)] < 0; }
  const ExactPlane& plane(int32_t triangle) const { return plane_[size_t(triangle)]; }

  /// Exact homogeneous coordinates of an implicit point; w > 0.
  struct Homogeneous {
    std::array<Wide<3>, 3> x;
    Wide<3> w;
  };
  const Homogeneous& homogeneous(int32_t point) const { return implicit_[size_t(exact_[size_t(point)])]; }

  /// Any point in homogeneous form (explicit: w = 1).
  Homogeneous exact(int32_t point) const;

 private:
  int32_t add_implicit(const Homogeneous& h);
  std::vector<Vec3> approx_;
  std::vector<int32_t> exact_;  // index into implicit_, or -1
  std::vector<Homogeneous> implicit_;
  std::vector<ExactPlane> plane_;
};

/// The closed mesh as uncut material: one face per triangle, material inside, glued by its edges.
/// Returns false when the mesh is not closed and oriented.
bool fill_from_mesh(MaterialSurface& surface, std::span<const Int3> vertex, std::span<const Tri> tri,
                    std::span<const SurfaceTag> tag);

}  // namespace limberg
