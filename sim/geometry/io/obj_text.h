#pragma once
// The statements v, vt, f and usemtl of a Wavefront OBJ file: what every reader of such files begins with.
//
// Read: triangles and polygons, v, v/vt, v//vn and v/vt/vn, negative indices (from the end so far), \r\n line ends,
// # comments and line continuation by a backslash; colours of vertices, as scanners write them (v x y z r g b). Other
// statements (vn, s, g, o, mtllib ...) are skipped. A face may name points that follow it.
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "sim/geometry/vec.h"

namespace limberg {

struct ObjText {
  struct Corner {
    int32_t v = -1, vt = -1;  // vt: -1 without
  };
  struct Face {
    size_t first = 0;       // of `corner`
    size_t corners = 0;     // at least 3
    int32_t line = 0;       // of the file
    int32_t material = -1;  // of `material`; -1: before the first usemtl
  };
  std::vector<Vec3> v;
  std::vector<Vec3f> rgb;  // of each v, 0 to 1, where all have their colour behind their place; else empty
  std::vector<Eigen::Vector2f> vt;
  std::vector<Corner> corner;
  std::vector<Face> face;
  std::vector<std::string> material;  // what usemtl names, each once, in the order of the file
};

struct ObjTextLimits {
  size_t vertices = 0, triangles = 0;  // a polygon of n corners counts as n - 2 triangles
  size_t polygon_corners = std::numeric_limits<size_t>::max();
  size_t materials = 10'000;
  bool texture = true;  // false: texture coordinates are passed over, those of faces too
};

/// Throws InputError with the line of the trouble. A text without faces, or with no statement at all, is none.
ObjText parse_obj_text(std::string_view text, const std::string& file, const ObjTextLimits& limits);

}  // namespace limberg
