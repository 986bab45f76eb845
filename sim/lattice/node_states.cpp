#include <algorithm>

#include "sim/base/error.h"
#include "sim/lattice/contradiction.h"
#include "sim/lattice/topology_parts.h"

namespace limberg {

std::vector<uint8_t> classify_nodes(const LatticeGrid& grid, const MaterialSurface& surface) {
  struct Hit {
    int32_t line, face;
  };
  std::vector<Hit> hits;
  const int32_t lines_y = grid.count.y + 1;
  auto on_line = [&](int32_t line) {
    const int64_t y = int64_t(grid.origin.y) + int64_t(line % lines_y) * grid.pitch.y;
    const int64_t z = int64_t(grid.origin.z) + int64_t(line / lines_y) * grid.pitch.z;
    return SubPoint{int64_t(grid.origin.x) << kSubUnitBits, y << kSubUnitBits, z << kSubUnitBits};
  };
  for (size_t f = 0; f < surface.faces.size(); ++f) {
    const Face& face = surface.faces[f];
    if (!face.live()) continue;
    std::array<PointRef, 3> p;
    int32_t lo[3] = {INT32_MAX, INT32_MAX, INT32_MAX}, hi[3] = {INT32_MIN, INT32_MIN, INT32_MIN};
    for (size_t k = 0; k < 3; ++k) {
      p[k] = surface.points->ref(face.v[k]);
      for (int a = 0; a < 3; ++a) {
        const int32_t l = layer_of(p[k], a, grid.origin[a], grid.pitch[a]);
        if (l < 0 || l >= grid.count[a])
          throw InputError("", 0, "the surface reaches beyond the lattice; a lattice fitted to the body was expected");
        lo[a] = std::min(lo[a], l), hi[a] = std::max(hi[a], l);
      }
    }
    for (int32_t z = lo[2] + 1; z <= hi[2]; ++z)
      for (int32_t y = lo[1] + 1; y <= hi[1]; ++y) {
        const int32_t line = z * lines_y + y;
        if (CellBuilder::pierced(p, 0, on_line(line))) hits.push_back({line, int32_t(f)});
      }
  }
  std::sort(hits.begin(), hits.end(), [&](const Hit& a, const Hit& b) {
    if (a.line != b.line) return a.line < b.line;
    if (a.face == b.face) return false;
    const int o = order_on_line(surface.plane(a.face), surface.plane(b.face), 0, on_line(a.line));
    return o ? o < 0 : a.face < b.face;
  });

  std::vector<uint8_t> in(size_t(grid.count.x + 1) * size_t(grid.count.y + 1) * size_t(grid.count.z + 1), 0);
  size_t h = 0;
  while (h < hits.size()) {
    const int32_t line = hits[h].line;
    SubPoint node = on_line(line);
    const int32_t first = grid.node_index({0, line % lines_y, line / lines_y});
    bool state = false;
    for (int32_t x = 0; x <= grid.count.x; ++x) {
      node[0] = (int64_t(grid.origin.x) + int64_t(x) * grid.pitch.x) << kSubUnitBits;
      for (; h < hits.size() && hits[h].line == line; ++h) {
        const Plane& plane = surface.plane(hits[h].face);
        const int up = plane.n[0] > 0 ? 1 : -1;
        if (plane_at_corner(plane, node) != up) break;  // beyond this node
        const uint8_t mat = surface.faces[size_t(hits[h].face)].mat;
        const int before = up > 0 ? 1 : 0;
        if (bool(mat >> before & 1) != state)
          throw Contradiction("material along a lattice line contradicts a face's bits");
        state = mat >> (1 - before) & 1;
      }
      in[size_t(first + x)] = state;
    }
    if (h < hits.size() && hits[h].line == line) throw Contradiction("a lattice line ends inside the material");
  }
  return in;
}

}  // namespace limberg
