#pragma once
// What studies measure of a wound: the banks of a straight incision, and the skin of one piece.
#include <optional>
#include <vector>

#include "sim/patient/snapshot.h"

namespace limberg::study {

/// The layers of the flaps' and gape studies, as in the shipped scenes: 1.5 mm of skin at 60 kPa, and fat at 15 kPa
/// down to thickness_mm that is stretched 0.8 times as much (septa tie it to the skin); alike in all directions.
std::vector<Layer> skin_on_fat(double thickness_mm, double prestretch_percent);

/// One bank of a wound at a station: where its skin edge lies at rest and now, mm.
struct Bank {
  Vec3 X_mm = Vec3::Zero(), x_mm = Vec3::Zero();
  Vec3 moved_mm() const { return x_mm - X_mm; }
};

/// The skin's edges along an incision that was drawn along y = 0, both ways: left is y > 0. Linear between the vertices
/// of the edge. Nothing where the wound does not reach.
class StraightWound {
 public:
  explicit StraightWound(const Snapshot& s);
  std::optional<Bank> left(double x_mm) const { return at(edge_[0], x_mm); }
  std::optional<Bank> right(double x_mm) const { return at(edge_[1], x_mm); }
  /// Distance of the banks at a station; 0 where there is no wound.
  double gape_mm(double x_mm) const;

 private:
  struct Edge {
    Bank a, b;  // a.X.x <= b.X.x
  };
  static std::optional<Bank> at(const std::vector<Edge>& edges, double x_mm);
  std::vector<Edge> edge_[2];
};

struct SkinArea {
  double rest_mm2 = 0, now_mm2 = 0;
};
/// Of the skin in the component of the surface that holds the skin nearest to the chart's origin.
SkinArea central_skin(const Snapshot& s);

/// The rim of the hole around the chart's origin in the largest component, at rest and now: enclosed area in the plane,
/// and its extent along x and y.
struct Hole {
  double rest_mm2 = 0, now_mm2 = 0;
  Vec2 extent_mm = Vec2::Zero();
};
Hole central_hole(const Snapshot& s);

}  // namespace limberg::study
