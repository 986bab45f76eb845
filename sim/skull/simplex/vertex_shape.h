#pragma once
// A vertex of a 2-simplex mesh seen from its three neighbours A, B, C (counter-clockwise from outside).
//
//   N      unit normal of the triangle ABC            r   its circumradius
//   F      foot of P on the plane of ABC = e1 A + e2 B + e3 C, the metric parameters, e1 + e2 + e3 = 1
//   L      height of P over the plane, along N        d   distance of F from the circumcentre
//   phi    simplex angle in (-pi, pi], tan phi = 2 r L / (r^2 - d^2 - L^2), positive on the side of N
//   H      sin(phi) / r = sign(L) / R, R the radius of the sphere through P, A, B, C: the discrete mean curvature
//
// (Delingette 1994; the forms used here avoid the circumcentre:
// r^2 - d^2 = e1 e2 |AB|^2 + e2 e3 |BC|^2 + e3 e1 |CA|^2.)
//
// From (A, B, C, e1, e2, phi) the height is a root of L^2 sin(phi) + 2 r L cos(phi) = k sin(phi), k
// = r^2 - d^2. Where the foot lies outside the circumcircle (k < 0) both roots have the same sign,
// so the angle alone does not name the vertex: one more bit does, `branch`. Where the two roots
// (nearly) meet, no bit helps: phi has an extremum there as a function of L, and loses half of its
// digits. A vertex whose angle code does not give it back is therefore stored by its scaled height
// L / sqrt(2 area(ABC)), which is as invariant under similarities. `encode` decides this by trying.
#include <array>
#include <cmath>
#include <cstdint>

#include "sim/base/elementary.h"
#include "sim/geometry/vec.h"

namespace limberg::simplex {

/// Geometry of P over its neighbours. Lengths in mm.
struct LocalFrame {
  Vec3 N = Vec3::Zero();                            // zero when degenerate
  double area2_mm2 = 0;                             // twice the area of ABC
  double r_mm = 0;                                  // circumradius of ABC
  double L_mm = 0;                                  // height of P
  double k_mm2 = 0;                                 // r^2 - d^2 = minus the power of F with respect to the circumcircle
  std::array<double, 3> e{1. / 3, 1. / 3, 1. / 3};  // metric parameters
  double sin_phi = 0, cos_phi = 1;
  bool degenerate = false;  // A, B, C (nearly) on a line: no plane, no angle; e is 1/3 each and L is 0

  double phi() const { return elementary::atan2(sin_phi, cos_phi); }
  /// Where the foot is outside the circumcircle and P near the
  /// plane: the branch on which phi is pi when P is in the plane.
  bool far_branch() const { return k_mm2 < 0 && L_mm * L_mm < -k_mm2; }
  /// How far the surface is bent: phi, and pi - phi on the far branch, so that it is 0 wherever P is in the plane.
  double bend() const { return elementary::atan2(sin_phi, far_branch() ? -cos_phi : cos_phi); }
  double mean_curvature_per_mm() const { return degenerate ? 0 : sin_phi / r_mm; }
};

/// A triangle counts as degenerate when its height over its longest edge is below this part of that edge.
inline constexpr double kDegenerateTriangle = 1e-9;

LocalFrame local_frame(const Vec3& P, const Vec3& A, const Vec3& B, const Vec3& C);

/// How the height is stored: the angle with the root nearer to
/// the plane, the angle with the farther root, or the height.
enum class ShapeBranch : uint8_t { near = 0, far = 1, height = 2 };
enum class ShapeCode : uint8_t { angle, height };  // what encode prefers

/// The place of a vertex with respect to its neighbours, up to a similarity.
struct VertexShape {
  double e1 = 1. / 3, e2 = 1. / 3;
  double phi = 0;     // rad
  double height = 0;  // L / sqrt(2 area(ABC)); used by ShapeBranch::height
  ShapeBranch branch = ShapeBranch::near;
  bool operator==(const VertexShape&) const = default;
};

/// Root of L^2 s + 2 r L c = k s, s = sin(phi), c = cos(phi), in the form without cancellation. Not finite when no
/// height has that angle (phi = pi with the near root and k > 0).
double height_from_angle(double r, double k, double s, double c, ShapeBranch branch);

/// Code of P. A degenerate triangle cannot hold a place off its line: then the code is that of the mean of A, B, C.
VertexShape encode(const Vec3& P, const Vec3& A, const Vec3& B, const Vec3& C, ShapeCode code = ShapeCode::angle);

/// The vertex with this code over A, B, C. Inverse of encode to rounding for every P whose ABC is not degenerate.
Vec3 decode(const VertexShape& shape, const Vec3& A, const Vec3& B, const Vec3& C);

}  // namespace limberg::simplex
