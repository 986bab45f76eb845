#pragma once
// The skin of a body at rest: where a chart point lies on it, how deep a point is below it, and which way the tension
// lines run there. Built once per body; const queries that allocate nothing.
//
//   Skin skin(body);
//   if (auto hit = skin.at({12, -3})) ...        // script point -> point of the rest surface
//   int layer = skin.layer_at(skin.depth_mm(X)); // which tissue is at X
//   Skin::Frame f = skin.frame(X);               // axes of the prestretch there
#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "sim/body/body.h"
#include "sim/geometry/bvh.h"

namespace limberg {

class Skin {
 public:
  /// Keeps the body alive. A body without skin triangles has no points and infinite depth.
  explicit Skin(std::shared_ptr<const Body> body);

  /// The outermost point of the whole surface on the chart line through p, if it is skin that faces outwards.
  std::optional<SkinHit> at(const ChartPoint& p) const;

  /// The point of the skin nearest to X.
  SkinHit nearest(const Vec3& X_mm) const;

  /// Distance in mm to the nearest point of the skin; negative on its outer side. The side is that of the
  /// angle-weighted normal of the nearest face, edge or corner (Baerentzen and Aanaes 2005).
  double depth_mm(const Vec3& X_mm) const;
  /// The same for one of many places, `near` being the answer for
  /// the last one (at first: empty): neighbours are found faster.
  double depth_mm(const Vec3& X_mm, Bvh::Closest& near) const;

  /// Index into Body::layers: 0 from the surface to its thickness (and outside), and so on; the last one has no end.
  int layer_at(double depth_mm) const;

  /// Orthonormal, right-handed: along x across = normal. `normal` is the skin's (outward, interpolated between corners)
  /// at the point nearest to X; `along` is Body::tension_direction laid into the skin plane.
  struct Frame {
    Vec3 normal = Vec3::UnitZ(), along = Vec3::UnitX(), across = Vec3::UnitY();
  };
  Frame frame(const Vec3& X_mm) const;

  const Body& body() const { return *body_; }
  const Bvh& surface() const { return surface_; }  // of all triangles of the body
  double area_mm2() const { return area_mm2_; }

 private:
  Vec3 side_normal(const Bvh::Closest& c) const;
  std::shared_ptr<const Body> body_;
  Bvh surface_, skin_;
  bool any_ = false;
  double area_mm2_ = 0, reach_mm_ = 0;
  std::vector<Vec3> corner_normal_;  // per vertex, from its skin triangles, angle-weighted, unit
  std::vector<std::array<Vec3, 3>>
      edge_normal_;  // per triangle: edge k from corner k to k + 1; sum of the skin faces there
};

}  // namespace limberg
