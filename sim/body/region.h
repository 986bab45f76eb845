#pragma once
// Tissue of its own within a body, whatever layer it lies in: a muscle, a plate of cartilage, a scar, a tumour.
//
// Where it is, is said in one of four ways:
//   volume    the inside of a closed surface
//   path      a bundle: within a radius of a line of points; one point is a ball
//   outline   what lies beneath an outline on the chart, between two depths below the skin (as the layers count them,
//             where these are thicker by place: Skin::in_layers_mm)
//   paint     what lies beneath faces of the body's surface that are of one material, between two depths
//
// Fibres and prestretch run along `direction`, or along the path, else along the tension lines of the skin.
#include <algorithm>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sim/body/chart.h"
#include "sim/body/layers.h"
#include "sim/geometry/sided_patch.h"

namespace limberg {

struct Body;

inline constexpr const char* kActivation = "activation";  // the constant of a law that a muscle has

struct RegionSpec {
  std::string name;
  Material material;
  std::string volume;  // path of an OBJ file of a closed surface
  double scale_to_mm = 1;
  std::vector<Vec3> path_mm;
  double radius_mm = 0;
  std::vector<ChartPoint> outline_mm;
  std::string paint;                                                    // a material of the body's OBJ
  double from_mm = 0, to_mm = std::numeric_limits<double>::infinity();  // depths, of outline and paint
  std::optional<Vec3> direction;
  std::optional<Vec3f> colour;  // sRGB, 0 to 1; none: it looks like the layers that it lies in
};

class Region {
 public:
  /// `body`: with its surface, chart and paints. Throws InputError: a volume that cannot be read or is open, a paint
  /// that no face is of.
  Region(RegionSpec spec, const Body& body);
  Region(const Region&) = delete;  // its patch knows its mesh
  Region& operator=(const Region&) = delete;

  const std::string& name() const { return spec_.name; }
  const Material& material() const { return spec_.material; }
  const std::optional<Vec3f>& colour() const { return spec_.colour; }
  /// How active it is at first, 0 to 1; none: its law knows no activity.
  std::optional<double> activation() const;

  /// Where a place is below the skin: Skin::Place.
  struct Below {
    double depth_mm = 0;
    Vec3 down = -Vec3::UnitZ();
    double thicker_mm = 0;
    double in_layers_mm() const { return depth_mm - thicker_mm; }
  };
  /// How far X lies inside, mm, negative outside. Near the border it is a distance (beside a paint only its sign is
  /// right), and elsewhere no larger than twice one.
  double inside_mm(const Vec3& X_mm, const Below& below) const {
    return std::min(inside_beside_mm(X_mm, below),
                    std::min(below.in_layers_mm() - from_mm(), to_mm() - below.in_layers_mm()));
  }
  /// The same but for the depths between which it lies.
  double inside_beside_mm(const Vec3& X_mm, const Below& below) const;
  /// Those depths; without end for a volume and a path, and upwards where it begins at the skin.
  double from_mm() const { return spec_.from_mm; }
  double to_mm() const { return spec_.to_mm; }
  /// False: no place within reach_mm of X is inside.
  bool reaches(const Vec3& X_mm, const Below& below, double reach_mm) const {
    return inside_mm(X_mm, below) > -2 * reach_mm;
  }
  /// The way of its fibres at X, unit; none where they follow the skin's tension lines.
  std::optional<Vec3> direction(const Vec3& X_mm) const;

 private:
  RegionSpec spec_;
  Chart chart_;
  TriMesh mesh_;  // of the volume, or the faces that are painted
  SidedPatch patch_;
};

/// Which of the body's regions has a place: of several the last.
std::optional<size_t> region_at(const Body& body, const Vec3& X_mm, const Region::Below& below);

}  // namespace limberg
