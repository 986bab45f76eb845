#pragma once
// A plate with two free sides and a free margin, as a lip has: x across, y from where it is held (0) to the margin, z
// from its back (0) to its front.
#include <array>
#include <map>
#include <memory>
#include <string>

#include "sim/body/obj.h"
#include "sim/patient/world_spec.h"

namespace limberg::test {

struct Lip {
  double wide_mm = 44, high_mm = 22, thick_mm = 8, cell_mm = 4, skin_cell_mm = 2;
  double prestretch = 1.05;
};

/// Its surface as OBJ: a box whose six sides are divided evenly.
inline std::string lip_obj(const Lip& s = {}) {
  const std::array<double, 3> size{s.wide_mm, s.high_mm, s.thick_mm};
  std::array<int, 3> n{};
  for (size_t a = 0; a < 3; ++a) n[a] = int(size[a] / s.skin_cell_mm + 0.5);
  std::map<std::array<int, 3>, int> number;
  std::string vertices, faces;
  const auto vertex = [&](const std::array<int, 3>& i) {
    const auto [it, added] = number.emplace(i, int(number.size()) + 1);
    if (added)
      vertices += "v " + std::to_string(size[0] * (double(i[0]) / n[0] - 0.5)) + " " +
                  std::to_string(size[1] * i[1] / n[1]) + " " + std::to_string(size[2] * i[2] / n[2]) + "\n";
    return it->second;
  };
  for (size_t a = 0; a < 3; ++a)  // the sides across axis a
    for (const bool high : {false, true}) {
      const size_t b = (a + 1) % 3, c = (a + 2) % 3;
      for (int i = 0; i < n[b]; ++i)
        for (int j = 0; j < n[c]; ++j) {
          std::array<std::array<int, 3>, 4> q{};
          for (size_t k = 0; k < 4; ++k)
            q[k][a] = high ? n[a] : 0, q[k][b] = i + (k == 1 || k == 2), q[k][c] = j + (k > 1);
          faces += "f";
          for (size_t k = 0; k < 4; ++k) faces += " " + std::to_string(vertex(q[high ? k : 3 - k]));
          faces += "\n";
        }
    }
  return vertices + faces;
}

inline WorldSpec lip(const Lip& s = {}) {
  ObjSpec o;
  o.path = "lip.obj";
  o.deep_direction = -Vec3::UnitY(), o.deep_angle_deg = 10;  // the side at y = 0
  Material skin, muscle;
  skin.young_kPa = 60, skin.poisson = 0.45, skin.prestretch_along = s.prestretch, skin.prestretch_across = s.prestretch;
  muscle.young_kPa = 15, muscle.poisson = 0.45;
  o.layers = {{"skin", 1.5, skin}, {"muscle", 100, muscle}};
  WorldSpec spec;
  spec.body = std::make_shared<Body>(parse_obj(lip_obj(s), o));
  spec.cell_mm = s.cell_mm;
  return spec;
}

}  // namespace limberg::test
