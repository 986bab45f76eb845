#pragma once
// A line drawn on the skin, as a row of places of the skin's triangles.
#include <optional>
#include <vector>

#include "devices/skin_chart.h"
#include "sim/commands/command.h"

namespace limberg {

/// Where the pen or the swab passed: on the chart, or at places in space.
struct SkinLine {
  std::vector<ChartPoint> chart;
  std::optional<InSpace> placed;  // then `chart` says nothing
  bool wipes = false;
};

/// The line of an act of the pen or of the swab; nothing: it is another act.
std::optional<SkinLine> skin_line(const Command& command);

/// A place every .6 mm at most along the line, and every corner of it; triangle -1 where there is no skin (a hole, a
/// place off the body). `chart` is built for this topology, which has a body. Between two places in space the skin is
/// meant that looks the way theirs does, not the other side of a thin fold. O(triangles of skin + places times
/// triangles beside the line)
std::vector<SkinTouch> laid_on_skin(const Snapshot& s, const SkinChart& chart, const SkinLine& line);

}  // namespace limberg
