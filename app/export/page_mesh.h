#pragma once
// A surface with fewer triangles away from what was operated: what a processor without a graphics card still draws many
// times a second.
#include "render/render_scene.h"

namespace limberg {

/// Vertices beyond 6 mm of the box (at rest) are drawn together, those within a cube of so many mm into one of them:
/// 2.5 mm, and 5 mm beyond 20 mm of the box. Only vertices of the same parts (skin, sides) that face the same way come
/// together, so that edges between parts and of a block stay where they are, and none that would turn a triangle over.
/// Wounds, bones and faces stay as they are; what is kept keeps its place and all that is told of it.
TissueMesh coarser_away(const TissueMesh& mesh, const Vec3f& low_mm, const Vec3f& high_mm);

}  // namespace limberg
