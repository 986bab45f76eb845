#pragma once
// Surfaces and point clouds from files: OBJ (geometry/io/obj_text.h), PLY (ascii or binary, either byte order), STL
// (ascii or binary, equal corners welded), simplex meshes as text (skull/simplex/file.h: their fans) and .xyz (three
// numbers a line, more are ignored).
// Polygons become fans. Lengths are taken for mm. Nothing is asked of the surface but that its numbers make sense: it
// may be open, in parts, not manifold, or only points.
#include <string>
#include <string_view>
#include <vector>

#include "sim/geometry/vec.h"
#include "sim/skull/simplex/mesh.h"

namespace limberg {

struct Surface {
  std::vector<Vec3> x_mm;
  std::vector<Tri> tri;   // empty: a cloud of points
  bool coloured = false;  // its file has colours of vertices or texture coordinates, which are not read here
};

/// All of `s` after what `to` has.
void append(Surface& to, const Surface& s);
/// Only the vertices that a triangle has, in the order in which triangles name them. `of_vertex`: a number per vertex,
/// which goes along; null: none.
Surface compacted(const Surface& s, std::vector<int32_t>* of_vertex = nullptr);

struct SurfaceFileLimits {
  static constexpr size_t file_bytes = size_t(1) << 30;
  static constexpr size_t points = 20'000'000, triangles = 40'000'000;
  static constexpr double extent_mm = 1e6;  // no coordinate is larger
};

/// The fans of a simplex mesh's faces, without its holes.
Surface triangles_of(const simplex::Mesh& mesh);

/// Whether its name is that of a surface or cloud (.obj, .ply, .stl, .xyz, .simplex).
bool is_surface_name(std::string_view path);
/// Throws InputError(file, line, ...): cut short, a number that is none or not finite, an index out of range, counts
/// that the file cannot hold.
Surface load_surface(const std::string& path);
Surface parse_surface(std::string_view bytes, const std::string& name);

}  // namespace limberg
