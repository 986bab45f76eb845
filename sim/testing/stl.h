#pragma once
// A fragment as binary STL (mm), for guides, splints and
// printing: all its triangles, walls included, holes closed flat.
#include <string>

#include "sim/skull/simplex/mesh.h"

namespace limberg::bone {

/// The component of `vertex`, taken by `pose`. 80 bytes of header, the number of triangles, 50 bytes for each: normal
/// and three corners in floats (little endian), counter-clockwise from outside. Throws InputError: no such vertex.
std::string to_stl(const simplex::Mesh& mesh, int32_t vertex, const Eigen::Isometry3d& pose);

/// Writes beside the file and renames. Throws InputError when it cannot.
void save_stl(const std::string& bytes, const std::string& path);

}  // namespace limberg::bone
