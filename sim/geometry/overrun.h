#pragma once
// Where an outline that was drawn once round is closed.
//
// A hand seldom ends where it began: it runs on beyond its beginning, by half a mm or by five, and what it draws there
// is no part of what it means. One rule for every outline, whether a hand drew it or a script states it: where
// the end of the way passes its beginning within kPasses_mm, and runs on for kRunsOn_mm at most, it is closed there.
//
// Looked for in the last third of the way, so that a narrow outline is not closed at its waist. Where the end itself is
// nearest to the beginning nothing is cut off, however far it is: that outline is closed by a straight line.
#include <span>

#include "sim/geometry/vec.h"

namespace limberg {

/// Three times the tremor that a stroke may have (devices/stroke_path.h).
inline constexpr double kPasses_mm = 1.2;
inline constexpr double kRunsOn_mm = 10;

/// So many of the first points make the outline; all of them where nothing runs on. The last one kept may lie where the
/// first one does. O(points)
size_t points_to_closing(std::span<const Vec2> drawn);

}  // namespace limberg
