#pragma once
// What is computed once of a fragment at rest and kept until the mesh changes: its closed surface, its cut surface, the
// convex pieces for contact.
#include <vector>

#include "sim/skull/bone/rigid_world.h"
#include "sim/skull/bone/surface.h"

namespace limberg::bone {

struct WallPoint {
  Vec3 x_mm, normal;
  double area_mm2;
};

struct FragmentShape {
  int32_t id = -1;
  BoneSurface surface;
  Bvh walls;                    // over surface.X_mm and surface.tri: the triangles of walls only
  std::vector<WallPoint> wall;  // the middle of each wall triangle
  Vec3 lo_mm = Vec3::Zero(), hi_mm = Vec3::Zero();
  std::vector<Prism> prisms;  // empty until they are asked for
};

FragmentShape fragment_shape(const simplex::Mesh& mesh, int32_t vertex);

/// Under every face of the fragment: see rigid_world.h. Places at rest.
std::vector<Prism> prisms_of(const simplex::Mesh& mesh, const FragmentShape& shape);

}  // namespace limberg::bone
