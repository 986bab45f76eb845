#pragma once
// Tissue of its own within the layers (sim/body/region.h): a muscle, a plate of cartilage, a scar, a tumour.
//
//   [[region]]  name                        what it is called
//               tissue, law, young_kPa ...  as in a layer (scene_layers.h), without thickness_mm
//               one of
//                 volume = "plate.obj"      a closed surface in the body's frame, beside the scene file; scale_to_mm
//                 path_mm = [[x, y, z], ..] a bundle of radius_mm about the line through them; one point: a ball
//                 outline = [[x, y], ..]    what lies beneath an outline on the chart
//                 paint = "material"        what lies beneath the faces of the body's OBJ that are of this material
//               depth_mm = [from, to]       of outline and paint, below the skin ([0, all of it])
//               colour = [r, g, b]          sRGB, 0 to 1, on skin and in cuts; without it that of the layers
//               direction = [x, y, z]       of fibres and prestretch (the path's, else that of the tension lines)
//
// At most 64; where two overlap the later one is there. Recordings hold their files, as they hold the body's.
#include <functional>

#include "app/scene/scene.h"
#include "app/scene/tissues.h"
#include "app/scene/toml_table.h"

namespace limberg {

/// [[region]], after [body]. `library` as in read_layers().
void read_regions(const toml::table& root, const std::string& file, Scene& scene,
                  const std::function<const TissueLibrary&(Table&)>& library);

/// Lays the scene's regions in its body. Throws InputError with the line of the region.
void add_regions(const Scene& scene, Body& body);

}  // namespace limberg
