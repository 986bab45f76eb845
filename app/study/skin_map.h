#pragma once
// Where places of the operated skin are now, and how the skin there is stretched: from chart points at rest.
//
// Banks of a cut share their rest places, so a place should lie inside tissue, not on a cut.
#include <memory>
#include <optional>
#include <vector>

#include "sim/commands/procedures/figure.h"
#include "sim/patient/snapshot.h"

namespace limberg::study {

class SkinMap {
 public:
  /// `skin`: the skin. `under`: what looks down at rest and is
  /// no support: the underside of what was freed from its bed.
  enum class Side : uint8_t { skin, under };
  explicit SkinMap(const Snapshot& shown, Side side = Side::skin);

  /// Where the skin of a chart point is now; nothing where it has been taken away.
  std::optional<Vec3> now_mm(const ChartPoint& p) const;

  /// How far one comes from a chart point in a direction (unit) before an edge of a cut, at rest.
  double free_mm(const ChartPoint& from, const Vec2& direction) const;

  /// The mean place now of what lies at rest within `radius_mm` of a
  /// chart point; nothing where less than half of that disc is left.
  std::optional<Vec3> mean_now_mm(const ChartPoint& p, double radius_mm) const;

  /// How far that place has risen along the chart's normal since rest.
  std::optional<double> mean_height_mm(const ChartPoint& p, double radius_mm) const;

  /// The skin's stretch, averaged over what lies at rest within `radius_mm` of a chart point; prestretch not included.
  struct Stretch {
    double most = 1, least = 1;      // principal, in the plane of the skin
    Vec3 direction = Vec3::UnitX();  // of the larger one, now
    double area_mm2 = 0;
  };
  Stretch stretch(const ChartPoint& p, double radius_mm) const;

  /// The larger principal stretch that a fraction q of the area within `radius_mm` of
  /// the chart's origin does not exceed, leaving out what lies within `keep_off_mm`
  /// of `tips`; prestretch not included. Slivers as in sim/measure are left out.
  double percentile(double q, double radius_mm, const std::vector<ChartPoint>& tips, double keep_off_mm) const;

  /// Share of the area within `radius_mm` of the chart's origin that a sheet cannot carry flat: its larger stretch l,
  /// prestretch included, leaves it a natural width of 1/sqrt(l) (no change of volume), and it is narrower.
  double slack_share(double radius_mm, double prestretch) const;

  /// Share of the area within `radius_mm` of the chart's origin whose outward normal is more than 60 degrees off the
  /// chart's: a flap that lies on its side or on its face. A cone of charge 90 is no steeper than 41 degrees.
  double turned_share(double radius_mm) const;

  /// The angle of the tissue at a corner as it has been cut: on a circle of `radius_mm`
  /// at rest around the corner's place, from the middle of its tissue both ways to the
  /// first edge between skin and cut wall. Not a number where no edge is met.
  double cut_angle_deg(const Figure& figure, const Corner& corner, double radius_mm) const;

  /// What the angles of some corners that are sewn together fall short of a full turn, as the skin lies now: the sum
  /// over the corners of the angles under which their arcs of radius `radius_mm` at rest are seen from their apexes. A
  /// sheet that is bent but not stretched keeps its rest angles and shows its charge; one that lies flat shows 0.
  double deficit_deg(const Figure& figure, const std::vector<Corner>& corners, double radius_mm) const;

  /// The Gaussian curvature of the skin that a loop of radius `radius_mm` at rest around some corners that are sewn
  /// together encloses, degrees: what the theorem of Gauss and Bonnet makes of its angles and its bending together,
  /// however blunt the tip of the cone
  /// inside. It is the signed area of the unit sphere that the skin's normals go round, walked from sector to sector in
  /// the order of the corners; they are means over cells of a ring of `width_mm`, of 12 degrees each. A ridge that the
  /// loop crosses, such as a seam's lip, leads there and back. Not a number where a corner has no skin at that radius.
  double curvature_deg(const Figure& figure, const std::vector<Corner>& corners, double radius_mm,
                       double width_mm) const;

 private:
  struct Patch {
    std::array<ChartPoint, 3> at;
    std::array<Vec3, 3> X, x;
    Vec2 centre() const { return (at[0] + at[1] + at[2]) / 3; }
  };
  struct Gradient {
    Eigen::Matrix<double, 3, 2> F;  // now over chart
    double area_mm2 = 0;
  };
  static Gradient gradient(const Patch& t);
  template <class Visit>
  void near(const ChartPoint& p, double radius_mm, Visit visit) const;

  std::vector<Patch> patches_;
  std::vector<std::pair<ChartPoint, ChartPoint>> rim_;  // at rest
  Vec3 up_ = Vec3::UnitZ();                             // the chart's normal
  Vec2 low_ = Vec2::Zero();
  int nx_ = 0, ny_ = 0;
  std::vector<std::vector<int32_t>> bin_;         // triangles that touch a bin
  std::vector<std::vector<int32_t>> centred_in_;  // whose middle lies in it
};

}  // namespace limberg::study
