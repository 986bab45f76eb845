#pragma once
// A layer that is not as thick everywhere: how thick it is below each vertex of the body's surface.
//
// That is said in one of three ways:
//   points    places with the thickness there
//   file      the same, one place a line: x y z thickness, in mm
//   down_to   the surface that the layer ends on
//
// Between points the thickness is the mean of the nearest eight (between_places.h). Beneath skin that ends on a surface
// it is what is left, along the skin's normal, below the layers above; where that line meets nothing within reach, the
// distance to the nearest place of the surface counts.
#include <string>
#include <string_view>
#include <vector>

#include "sim/body/layers.h"
#include "sim/geometry/vec.h"

namespace limberg {

struct Body;

struct PlaceThickness {
  Vec3 at_mm = Vec3::Zero();
  double thickness_mm = 0;
};

struct ThicknessSpec {
  std::vector<PlaceThickness> points;
  std::string file;
  std::string down_to;     // path of an OBJ, PLY or STL file
  double scale_to_mm = 1;  // of that file
  bool given() const { return !points.empty() || !file.empty() || !down_to.empty(); }
};

struct ThicknessLimits {
  static constexpr size_t file_bytes = size_t(64) << 20, points = 1'000'000;
  static constexpr double least_mm = 0.1, most_mm = 100;
};

/// Throws InputError with file and line. `file` is the name in messages.
std::vector<PlaceThickness> parse_thickness(std::string_view text, const std::string& file);

/// Per vertex of the body's surface, mm: of layer `layer`, those above being as Body::thickness_mm and Body::layers
/// say. Below least_mm it is taken as that. Throws InputError: what cannot be read; a surface that does not lie beneath
/// half of the skin; a thickness beyond the limits.
std::vector<float> thickness_of(const ThicknessSpec& spec, const Body& body, size_t layer);

}  // namespace limberg
