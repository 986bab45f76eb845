#pragma once
// One bone as a closed surface of triangles, for picking, rays and volumes: the fans of its faces; holes and open
// mouths are closed by flat fans, which are marked.
#include <span>
#include <vector>

#include "sim/geometry/bvh.h"
#include "sim/skull/simplex/mesh.h"

namespace limberg::bone {

struct BoneSurface {
  std::vector<Vec3> X_mm;  // the vertex slots of the mesh, then the face centres
  std::vector<Tri> tri;
  std::vector<int32_t> face;  // per triangle
  Bvh bvh;

  Vec3 normal(int32_t triangle) const;  // unit, outwards
  /// Inside the closed surface: a line in a fixed direction leaves it once more than it
  /// enters it, beyond the place. Small folds of the surface do not matter; where the
  /// numbers make no sense (a line along an edge) other directions are asked, up to five.
  bool contains(const Vec3& x_mm) const;
};

/// The vertices that `in` marks are whole components.
BoneSurface bone_surface(const simplex::Mesh& mesh, std::span<const uint8_t> in);

/// Marks the component of v.
std::vector<uint8_t> component_of(const simplex::Mesh& mesh, int32_t v);

/// Of every component (simplex::components): volume mm^3 of the closed surface, and the centre of it.
struct Bulk {
  double volume_mm3 = 0;
  Vec3 centre_mm = Vec3::Zero();
};
std::vector<Bulk> bulks(const simplex::Mesh& mesh, std::span<const int32_t> component, int32_t count);

/// Centre of a face's fan: flat for holes and open mouths.
Vec3 fan_centre(const simplex::Mesh& mesh, int32_t face);

}  // namespace limberg::bone
