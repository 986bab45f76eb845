#pragma once
// Own colours on the drawn surface: of regions, on skin that a scar or a tumour reaches and on cut faces; and of skin
// whose vertices a scan gave colours to.
#include <array>
#include <cstdint>
#include <vector>

#include "sim/body/skin.h"
#include "sim/patient/snapshot.h"

namespace limberg {

/// Per vertex of the view, as SurfaceTopology::rgba; empty where neither a region nor the skin has colours. `before`:
/// an earlier version of the same patient, whose colours are taken over where a vertex is the same; may be null.
std::vector<std::array<uint8_t, 4>> region_colours(const Skin& skin, const SurfaceView& view,
                                                   const SurfaceTopology* before);

}  // namespace limberg
