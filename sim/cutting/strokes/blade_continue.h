#pragma once
// Blades that go on where an earlier wall ends: its own points are shared by id, so there is no joint to get wrong.
#include "sim/cutting/arrangement/wall_map.h"
#include "sim/cutting/strokes/blade_parts.h"

namespace limberg {

/// Depths nearer than this are one: a wall is not deepened by less.
inline constexpr double kSameDepth = 0.25;

/// One border of a strip: vertices of the blade from above down, with their levels.
struct StripSide {
  std::vector<int32_t> vertex;
  std::vector<double> level;
  double arc = 0;
};

/// Vertices of the blade for a wall's column, from the known point at level `from` (or the topmost) down to `to`: known
/// points by id where there are some, new ones below. `known` names those that the blade has already.
StripSide side_of_wall(Blade& blade, const BladeContext& context, const WallColumn& column, double from, double to,
                       std::vector<std::pair<int32_t, int32_t>>& known);

/// Triangles between two sides, left before right along the stroke, oriented as the quads of a strip. Seeds 1 where
/// they cross the skin; `seed_top` for those at the upper ends of both sides.
void add_between(Blade& blade, const StripSide& left, const StripSide& right, uint8_t seed_other, uint8_t seed_top);

/// Where a stroke may go on from the open end of an earlier wall: the column, or -1. The path's first point is then
/// that of the column. `level` is how deep the stroke reaches; a column that has `not_point` does not count.
int32_t join_start(const WallMap& walls, std::vector<Vec2>& path, double level, int32_t not_point = -1);

/// Deepens the walls that a path runs along, from their fronts to `level_mm` (a stroke's depth and its wall_extra);
/// less deep where the blade would run through itself; then a reason stands beside the blade.
/// Empty blade: nothing there is shallower. It also keeps clear of the walls of operations from number `clear_of` on:
/// those that a stroke has cut already.
BladeResult build_deepening(const BladeContext& context, std::span<const Vec2> path, double level_mm,
                            int32_t clear_of = INT32_MAX);

}  // namespace limberg
