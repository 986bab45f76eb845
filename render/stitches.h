#pragma once
// Where a stitch's thread lies: out of the skin beside the wound,
// straight over it and over whatever stands up in between, and in again.
#include "render/render_scene.h"

namespace limberg {

struct NearestSkin {
  Vec3f x = Vec3f::Zero(), normal = Vec3f::UnitZ();
  bool found = false;
};

/// The vertex of skin, or of another part, nearest to p. Skin triangles are under a millimetre, so its height is the
/// skin's height there; those of bone are some millimetres wide.
NearestSkin nearest_skin(const RenderScene& scene, const Vec3f& p, Part part = Part::skin);

/// Adds thread, knot and bite marks of a stitch to the scene's props; nothing when it has no place.
void add_stitch(RenderScene& scene, const Snapshot& snapshot, const SutureState& suture);

}  // namespace limberg
