#pragma once
// A simplex mesh as a text file. One statement per line, numbers from 0, # begins a comment:
//
//   limberg-simplex 1            first line
//   axes lps|head                which way x, y and z point: left, posterior, superior as a scanner's pictures, or
//                                right, forwards, up as a head in a scene; before the first vertex, may be left out
//   v x y z a b c                a vertex (mm) and its neighbours, counter-clockwise from outside
//   b x y z                      of the vertex above: place one iteration ago, where it differs
//   z number                     its zone, where not 0
//   l                            it is locked
//   m e1 e2                      its wanted metric parameters, where not 1/3
//   s e1 e2 phi height branch    its reference shape, where it is not the present one; branch near, far or height
//   e a b hole|cut|wall          the face on the left of a -> b is a hole, the mouth of a cut, or the wall of a cut
//   c v1 v2 v3 ...               a kept contour
//
// Numbers are written so that they are read back to the same bits. Reading checks everything: find_fault, limits below.
#include <string>
#include <string_view>

#include "sim/skull/simplex/mesh.h"

namespace limberg::simplex {

struct FileLimits {
  static constexpr size_t file_bytes = size_t(1) << 30;
  static constexpr int32_t vertices = 5'000'000;
  static constexpr double extent_mm = 1e6;  // no coordinate is larger
};

/// Text of the mesh. Free slots are left out: vertices are numbered anew, in their order.
std::string to_text(const Mesh& mesh);
/// Throws InputError(name, line, ...).
Mesh parse_mesh(std::string_view text, const std::string& name);

/// Writes beside the file and renames, so that a file that is there is never lost. Throws InputError when it cannot.
void save_mesh(const Mesh& mesh, const std::string& path);
Mesh load_mesh(const std::string& path);

/// The fans as Wavefront OBJ, for other programs.
std::string to_obj(const Mesh& mesh);

}  // namespace limberg::simplex
