#pragma once
// Raw tissue that stands out of the skin for all to see: a flap on its edge or on its back. Its edges may lie where its
// stitches want them, so that nothing gapes; its skin may be upright, so that none is turned; an eye sees fat.
#include <span>

#include "sim/body/skin.h"
#include "sim/cutting/arrangement/surface_view.h"

namespace limberg {

/// Cut faces of what the body holds that lie outside the original surface by more than half a millimetre, look outwards
/// (less than 60 degrees from the normal of that surface there; the wall of an edge that stands a little higher than
/// the other looks sideways), and have nothing over them along that normal.
struct RawTissue {
  double area_mm2 = 0;        // as it lies now
  double height_mm = 0;       // of the highest such face's middle above the original surface
  Vec3 at_mm = Vec3::Zero();  // their middle at rest
};
RawTissue raw_tissue(const SurfaceView& view, std::span<const Vec3f> x_mm, const Skin& skin);

}  // namespace limberg
