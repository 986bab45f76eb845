#pragma once
// Moving on a triangulated surface by a displacement in space.
//
//   dx = P(x) dd        P: projection onto the surface's tangent plane at x
//
// Walked exactly from triangle to triangle: within one the path is straight; at an edge what is left of the
// displacement is projected anew onto the triangle in which it leads onward. So the path depends on the surface and not
// on how it is cut into triangles. Where both sides of an edge send the path back onto it (a ridge, the rim of the
// surface), it goes along the edge; where every way from a point leads back, the point is the furthest in that
// direction and the walk rests there
// until the displacement turns. Nothing is added beyond the displacement: a step is never longer than it, so that a
// walk never jumps. Triangles lower than kSliver of their longest edge have no tangent plane worth following: they are
// crossed.
//
// A walk allocates nothing. Positions are those of the snapshot; which triangles meet is read off the topology.
#include <array>
#include <cstdint>
#include <vector>

#include "sim/patient/snapshot.h"

namespace limberg {

/// A place of the surface: exact zeros in bary name an edge or a corner.
struct SurfacePlace {
  int32_t triangle = -1;
  std::array<double, 3> bary{1, 0, 0};
  bool operator==(const SurfacePlace&) const = default;
};

class SurfaceWalk {
 public:
  static constexpr double kSliver = 1e-3;
  static constexpr int kMostCrossings = 64;  // in one walk; what is left then is returned

  /// What is not `ground` is not part of the surface; where it begins is its rim.
  explicit SurfaceWalk(Ground ground = Ground::skin) : ground_(ground) {}

  /// Moves `place` by d_mm. Returns what is left of d_mm when the crossings were used up, else zero.
  Vec3 walk(const Snapshot& s, SurfacePlace& place, const Vec3& d_mm) const;

  /// The place nearest to X_mm at rest; among places equally near (the two banks of a cut) the one whose deformed
  /// position is nearest to x_mm. One pass over the triangles.
  SurfacePlace nearest_at_rest(const Snapshot& s, const Vec3& X_mm, const Vec3& x_mm) const;
  /// The place nearest to x_mm as it is now. One pass over the triangles.
  SurfacePlace nearest(const Snapshot& s, const Vec3& x_mm) const;

  Vec3 position(const Snapshot& s, const SurfacePlace& p) const;
  Vec3 rest_position(const Snapshot& s, const SurfacePlace& p) const;
  Vec3 normal(const Snapshot& s, const SurfacePlace& p) const;

  /// The triangle beyond the edge opposite to corner k of t; -1: a rim.
  int32_t beyond(const Snapshot& s, int32_t t, int k) const;

 private:
  struct Way;
  bool try_triangle(const Snapshot& s, const Vec3& at, int32_t t, const std::array<double, 3>& bary, const Vec3& d,
                    Way& best) const;
  bool cross_slivers(const Snapshot& s, const Vec3& at, int32_t& t, std::array<double, 3>& bary) const;
  bool sliver(const Snapshot& s, int32_t t) const;

  const GroundIndex& of(const Snapshot& s) const { return s.topology->index(ground_); }

  Ground ground_;
};

}  // namespace limberg
