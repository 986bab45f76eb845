#pragma once
// Which sheet of skin is meant where several lie within the tremor of a hand.
//
// A flap that was laid over its bed, or two edges that wait for their stitch, put two skins at one place: the nearer
// one is chance. Along a whole stroke it is not: each skin near its beginning is followed by itself, and the one that
// stayed nearest to the hand is the one that was drawn on. Nothing is allocated after construction.
#include <array>
#include <span>
#include <vector>

#include "devices/surface_index.h"

namespace limberg {

class EdgeStroke {
 public:
  static constexpr size_t kSheets = 4, kPoints = 1024;
  static constexpr double kAmong_mm = 1.5;  // sheets that are this much further away than the nearest may be meant

  struct Point {
    ChartPoint chart{0, 0};
    Vec3 x_mm = Vec3::Zero();
    Vec3 X_mm = Vec3::Zero(), N = Vec3::UnitZ();  // at rest: the place, and out of the skin
  };

  EdgeStroke();
  /// Every sheet near the tip; at least the nearest, when there is skin.
  void begin(SurfaceIndex& index, const Snapshot& s, const Vec3& tip_mm);
  /// The same, and the exactly nearest skin too: round the end of a wound its two edges hang together, so that they
  /// are one sheet. With a place of the edge that this one is to be sewn to: not the skin on which that lies, unless
  /// there is no other. O(triangles)
  void begin_as_meant(SurfaceIndex& index, const Snapshot& s, const Vec3& tip_mm, const SkinTouch* first_edge);
  /// The hand is here now.
  void follow(const SurfaceIndex& index, const Snapshot& s, const Vec3& tip_mm);
  /// Notes a point when the hand has moved by step_mm since the last (always when step_mm is 0).
  void note(const Vec3& tip_mm, double step_mm);
  /// The topology is another: only the sheet that fits best so far is followed further.
  void found_again(const SurfaceIndex& index, const Snapshot& s);

  /// The points of the sheet that stayed nearest, first to last.
  size_t size() const { return points_; }
  const Point& point(size_t i) const { return point_[best() * kPoints + i]; }
  const SkinTouch& touched() const { return sheet_[best()].touch; }

 private:
  struct Sheet {
    SkinTouch touch;
    double sum2 = 0;  // of its distances at the noted points, mm^2
  };
  void take(std::span<const SkinTouch> near);
  size_t best() const;
  std::array<Sheet, kSheets> sheet_;
  std::vector<Point> point_;  // kPoints per sheet
  size_t sheets_ = 0, points_ = 0;
  double thinned_ = 1;  // steps are this much longer once the room was used up
  Vec3 last_tip_ = Vec3::Zero();
};

}  // namespace limberg
