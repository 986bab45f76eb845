#pragma once
// What a script may hold; enough for any operation, and a bound on what a hostile file can cost.
#include <cstddef>

namespace limberg {

struct ScriptLimits {
  static constexpr size_t file_bytes = 64u << 20;
  static constexpr size_t line_bytes = 1u << 20;
  static constexpr size_t commands = 100'000;
  static constexpr size_t path_points = 2000;
  static constexpr size_t row_sutures = 1000;  // longer of the two paths / spacing_mm
  static constexpr size_t name_bytes = 200;
  static constexpr double coordinate_mm = 10'000;  // |x| of any point
  static constexpr double depth_mm = 200;          // 0 < depth <= this
  static constexpr double seconds = 3600;          // 0 <= seconds <= this
  static constexpr int max_id = 1'000'000;         // 1 <= id <= this
  static constexpr size_t landmarks = 50;
};

}  // namespace limberg
