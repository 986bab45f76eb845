#pragma once
// Surfaces from files of three kinds, as one: OBJ (obj_text.h), PLY (ascii or binary, either byte order; polygons,
// colours of vertices) and STL (ascii or binary; equal corners are one). PLY is told by its first line, STL by its
// name, all else is OBJ.
//
// Only OBJ has texture coordinates and materials. What is not asked for is passed over: normals, edges, other
// properties of a PLY; normals and colours of an STL.
#include <string>
#include <string_view>

#include "sim/geometry/io/obj_text.h"

namespace limberg {

/// Throws InputError(file, line, ...): cut short, a number that is none or not finite, an index out of range, counts
/// that the file cannot hold, more than the limits. `line` of a face in a binary file is 0. A PLY may have no faces.
ObjText parse_mesh_file(std::string_view bytes, const std::string& file, const ObjTextLimits& limits);
/// The same, of a kind that is known.
ObjText parse_ply(std::string_view bytes, const std::string& file, const ObjTextLimits& limits);
ObjText parse_stl(std::string_view bytes, const std::string& file, const ObjTextLimits& limits);

/// The first three numbers of a row that any of blank, tab, comma and semicolon part.
Vec3 point_of_row(std::string_view row, const std::string& file, int line);

bool is_ply(std::string_view bytes);
bool is_stl_name(std::string_view file);

}  // namespace limberg
