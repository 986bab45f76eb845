#pragma once
// The colours of regions on the drawn surface: of skin that a scar or a tumour reaches, and of cut faces.
#include <array>
#include <cstdint>
#include <vector>

#include "sim/body/skin.h"
#include "sim/patient/snapshot.h"

namespace limberg {

/// Per vertex of the view, as SurfaceTopology::rgba; empty where no region has a colour. `before`: an earlier version
/// of the same patient, whose colours are taken over where a vertex is the same; may be null.
std::vector<std::array<uint8_t, 4>> region_colours(const Skin& skin, const SurfaceView& view,
                                                   const SurfaceTopology* before);

}  // namespace limberg
