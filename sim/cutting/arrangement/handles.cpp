#include "sim/cutting/arrangement/handles.h"

#include "sim/cutting/arrangement/surface_view_update.h"

namespace limberg {

int64_t euler_characteristic(const Arrangement& a) {
  const ArrangementStore& s = a.store();
  const ViewReader read(s, a);
  std::vector<uint8_t> seen(6 * s.face.size(), 0);
  int64_t vertices = 0, sided_faces = 0;
  for (int32_t f = 0; f < int32_t(s.face.size()); ++f)
    for (int side = 0; side < 2; ++side) {
      if (!s.face[f].has_side(side)) continue;
      ++sided_faces;
      for (int k = 0; k < 3; ++k) {
        const int32_t corner = 3 * sided_face(f, side) + k;
        if (seen[size_t(corner)]) continue;
        ++vertices;
        read.orbit(corner, [&](int32_t at) { seen[size_t(at)] = 1; });
      }
    }
  return vertices - sided_faces / 2;  // three half-edges per face, two per edge: F - E = F - 3 F / 2
}

}  // namespace limberg
