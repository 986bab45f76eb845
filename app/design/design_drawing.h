#pragma once
// The ranking of a design search as one picture: the best designs as they would lie on the skin, and what each costs.
#include <string>
#include <vector>

#include "app/design/design_search.h"

namespace limberg {

/// An SVG picture of the first `most` of `found` that were carried out: on one scale, y of the chart up, the defect's
/// outline dashed, excised skin filled, cuts drawn, landmarks named, tension lines (degrees on the chart) hatched;
/// under each its cost as a bar of three parts. Empty when none was carried out.
std::string ranking_svg(const std::vector<Design>& found, const DesignTask& task, double lines_deg, size_t most = 12);

}  // namespace limberg
