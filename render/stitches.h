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

/// The way of a stitch's thread from its entry to its exit, and the outward unit normal of the skin there; an empty
/// path: it has no place. Of the scene: mesh, places and normals.
struct StitchWay {
  std::vector<Vec3f> path_mm;
  Vec3f up = Vec3f::UnitZ();
};
StitchWay stitch_way(const RenderScene& scene, const Snapshot& snapshot, const SutureState& suture);

/// The way of a thread's loose end on the skin, from where it comes out towards `aside` and in a bend, as it falls. It
/// ends where the skin does.
std::vector<Vec3f> lying_thread(const RenderScene& scene, const Vec3f& from_mm, const Vec3f& aside);

/// Adds thread, knot and bite marks of a stitch to the scene's props; nothing when it has no place.
void add_stitch(RenderScene& scene, const Snapshot& snapshot, const SutureState& suture);

}  // namespace limberg
