#pragma once
// The skin of a body at rest: where a chart point lies on it, how deep a point is below it, and which way the tension
// lines run there. Built once per body; const queries that allocate nothing.
//
//   Skin skin(body);
//   if (auto hit = skin.at({12, -3})) ...        // script point -> point of the rest surface
//   int layer = skin.layer_at(skin.depth_mm(X)); // which tissue is at X
//   Skin::Frame f = skin.frame(X);               // axes of the prestretch there
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "sim/body/body.h"
#include "sim/body/skin_view.h"
#include "sim/geometry/sided_patch.h"

namespace limberg {

class Skin {
 public:
  /// Keeps the body alive. A body without skin triangles has no points and infinite depth.
  explicit Skin(std::shared_ptr<const Body> body);

  /// The outermost point of the whole surface on the chart line through p, if it is skin that faces outwards.
  std::optional<SkinHit> at(const ChartPoint& p) const;

  /// Where the line through p along a view's normal meets skin that faces the viewer, nearest to the view's height.
  std::optional<SkinHit> at(const ChartPoint& p, const SkinView& view) const;

  /// The point of the skin nearest to X.
  SkinHit nearest(const Vec3& X_mm) const;

  /// Distance in mm to the nearest point of the skin; negative on its outer side. The side is that of the
  /// angle-weighted normal of the nearest face, edge or corner (Baerentzen and Aanaes 2005).
  double depth_mm(const Vec3& X_mm) const;
  /// The same for one of many places, `near` being the answer for
  /// the last one (at first: empty): neighbours are found faster.
  double depth_mm(const Vec3& X_mm, Bvh::Closest& near) const;

  /// Where a place near the body lies in it: its distance to the whole surface (negative outside) and its depth below
  /// the skin. Inside the body that is the distance to the nearest skin; outside it goes on linearly, so that both can
  /// be interpolated across the surface. Without skin the depth is infinite. `near`: the answers for the last place.
  struct Near {
    Bvh::Closest surface, skin;
  };
  struct Place {
    double inside_mm = 0, depth_mm = 0;
    Vec3 down = Vec3::Zero();  // unit: the way into the body from the skin that the depth is measured from
    double thicker_mm = 0;     // by so much the layers above are thicker than Body::layers says
    double in_layers_mm() const { return depth_mm - thicker_mm; }
  };
  Place place(const Vec3& X_mm, Near& near) const;

  /// Depths below are as the layers count them, which begin and end where Body::layers says. Where a layer is thicker
  /// or thinner by place (Body::thickness_mm) so is what lies beneath it deeper or less deep, mm for mm; of a layer
  /// between two others the middle third is drawn out or pressed together, of the last and the first the far end.
  /// `near`: the skin's nearest place.
  double in_layers_mm(double depth_mm, const Bvh::Closest& near) const;
  /// Index into Body::layers: 0 from the surface to its thickness (and outside), and so on; the last one has no end.
  int layer_at(double in_layers_mm) const;
  /// The first and the last layer that may be within reach of a place that lies so deep (not as the layers count).
  std::pair<int, int> layers_within(double depth_mm, double reach_mm) const;
  /// True: no layer is thicker in one place than in another.
  bool even() const { return least_end_mm_.empty(); }

  /// Orthonormal, right-handed: along x across = normal. `normal` is the skin's (outward, interpolated between corners)
  /// at the point nearest to X; `along` is what Body::tension or tension_direction says, in the skin's plane.
  struct Frame {
    Vec3 normal = Vec3::UnitZ(), along = Vec3::UnitX(), across = Vec3::UnitY();
  };
  Frame frame(const Vec3& X_mm) const;

  const Body& body() const { return *body_; }
  const Bvh& surface() const { return surface_.bvh(); }  // of all triangles of the body
  double area_mm2() const { return area_mm2_; }

 private:
  std::shared_ptr<const Body> body_;
  SidedPatch surface_, skin_;
  bool any_ = false;
  double area_mm2_ = 0, reach_mm_ = 0;
  std::vector<double> least_end_mm_, most_end_mm_;  // of layers that are not as thick everywhere
};

}  // namespace limberg
