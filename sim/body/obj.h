#pragma once
// A patient from a closed surface in a Wavefront OBJ, a PLY or an STL file (geometry/io/mesh_file.h).
//
// Polygons are cut into triangles in their own plane. Vertices are scaled to mm, snapped to the even rest grid (the
// finest unit that the size allows), equal ones are welded, triangles that collapse by that are dropped, and the result
// is validated exactly. Materials, and with them tags, are the OBJ's alone; OBJ and PLY may have colours of vertices.
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/body/body.h"
#include "sim/geometry/validate.h"

namespace limberg {

/// What the faces of one material of an OBJ are.
struct ObjTag {
  enum class What : uint8_t {
    skin,         // free; can be cut, undermined and sewn
    mucosa,       // the same, moist: of a lip, a lid, the nose
    held,         // to bone: does not move
    held_softly,  // where the body was cut out of a larger one: by springs (patient/soft_hold.h)
    cut           // free without skin: a bare bed, say
  };
  std::string material;  // as usemtl names it
  What what = What::skin;
  // held_softly: what it meets, of a displacement of 1 mm. Half a mm of tissue of 15 kPa is 30 kPa/mm, 20 mm of it .75.
  double stiffness_kPa_mm = 0.75;
};
inline constexpr const char* kObjTagNames[] = {"skin", "mucosa", "held", "held_softly", "cut"};

struct ObjSpec {
  std::string path;
  double scale_to_mm = 1;  // mm per unit of the file
  std::vector<Layer> layers;
  Vec3 tension_direction = Vec3::UnitX();

  // What is held in place. By its materials, where these are tagged: every one that a face has must be.
  std::vector<ObjTag> tags;
  // Else by its directions: triangles whose outward normal is within deep_angle_deg of deep_direction (or, when a
  // centre is given, of the direction to that centre: the inner side of a shell around the skull), and triangles with
  // all corners beyond the plane { X : X . deep_direction = deep_plane_mm }. Everything else is skin.
  Vec3 deep_direction = -Vec3::UnitZ();
  double deep_angle_deg = 60;
  std::optional<Vec3> deep_center_mm;
  double deep_plane_mm = std::numeric_limits<double>::infinity();

  Vec3 chart_origin_mm = Vec3::Zero(), chart_e1 = Vec3::UnitX(), chart_e2 = Vec3::UnitY();  // made orthonormal
};

struct ObjLimits {
  static constexpr size_t file_bytes = size_t(512) << 20;
  static constexpr size_t vertices = 2'000'000, triangles = 4'000'000;
  static constexpr size_t polygon_corners = 256;
  static constexpr double extent_mm = 1000;  // longest side after scaling
  static constexpr double min_extent_mm = 1;
};

/// A surface that is inside out is turned, and the report says so: programs that mirror a mesh leave it like that.
/// Throws InputError with the file and line of the trouble. `report` (may be null) receives what was found.
Body load_obj(const ObjSpec& spec, SurfaceReport* report = nullptr);
/// The same from text; spec.path is only the name in messages.
Body parse_obj(std::string_view text, const ObjSpec& spec, SurfaceReport* report = nullptr);

}  // namespace limberg
