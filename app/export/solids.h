#pragma once
// Surfaces for printers and other programs: parts of a surface, whether it is closed, binary STL and PLY.
#include <string>
#include <vector>

#include "sim/imaging/io/surface_file.h"

namespace limberg {

/// A surface is closed where every edge is passed once each way. volume_mm3: of a closed one that lies outwards, > 0.
struct SolidFigures {
  int64_t open_edges = 0;  // directed edges without their one partner
  double volume_mm3 = 0;
  bool closed() const { return open_edges == 0; }
};
SolidFigures solid_figures(const Surface& surface);

/// Its connected parts, largest volume first, each with the vertices that it uses only; smaller ones than `least_mm3`
/// (and hollows, whose volume is below 0) are left out.
std::vector<Surface> parts_of(const Surface& surface, double least_mm3);

void move(Surface& surface, const Eigen::Isometry3d& by);

/// 80 bytes of header, the number of triangles, 50 bytes for each, in mm, little endian.
std::string stl_bytes(const Surface& surface, const std::string& title);
/// Text, vertices to 10 nm.
std::string obj_text(const Surface& surface);
/// Binary, little endian; vertices shared by triangles, floats.
std::string ply_bytes(const Surface& surface, const std::string& title);

}  // namespace limberg
