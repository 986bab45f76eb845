#pragma once
// A scene of a small block, skin on fat, as text: for tests and benches that need a patient and not this one.
#include <string>

namespace limberg::test {

struct SmallBlock {
  const char* name = "tiny";
  int side_mm = 40, skin_cell_mm = 2, cell_mm = 5;
  const char* prestretch_along = "";  // empty: none
};

inline std::string small_block(const SmallBlock& b) {
  const std::string side = std::to_string(b.side_mm), along = b.prestretch_along;
  return "name = \"" + std::string(b.name) + "\"\n[body]\nsource = \"block\"\nsize_mm = [" + side + ", " + side +
         ", 10]\nskin_cell_mm = " + std::to_string(b.skin_cell_mm) + R"(
[[layer]]
name = "skin"
thickness_mm = 2
young_kPa = 60
poisson = 0.45
)" + (along.empty() ? "" : "prestretch_along = " + along + "\n") +
         R"([[layer]]
name = "fat"
thickness_mm = 8
young_kPa = 15
poisson = 0.45
[lattice]
cell_mm = )" +
         std::to_string(b.cell_mm) + "\n";
}

}  // namespace limberg::test
