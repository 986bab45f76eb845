#pragma once
// Some triangles of a closed mesh as a surface with two sides: how far away it is, and on which side a place lies.
#include <array>
#include <span>
#include <vector>

#include "sim/geometry/bvh.h"
#include "sim/geometry/tri_mesh.h"

namespace limberg {

/// Built once; const queries that allocate nothing.
class SidedPatch {
 public:
  SidedPatch() = default;
  /// Over the triangles listed in `of` (indices into mesh.tri; not empty), whose normals point outwards. The mesh must
  /// outlive the patch.
  SidedPatch(const TriMesh& mesh, std::span<const int32_t> of);
  /// Over all of them.
  explicit SidedPatch(const TriMesh& mesh);

  bool empty() const { return bvh_.empty(); }
  const Bvh& bvh() const { return bvh_; }

  /// Outward normal at a nearest point, not of unit length. The side on which a place lies is that of the
  /// angle-weighted normal of the face, edge or corner nearest to it (Baerentzen and Aanaes 2005).
  Vec3 side_normal(const Bvh::Closest& c) const;
  /// Per vertex, angle-weighted over the patch, unit; zero off the patch.
  const Vec3& corner_normal(int32_t vertex) const { return corner_normal_[size_t(vertex)]; }

  /// Distance (mm) to the patch, negative on its outer side. `near` is the answer for the last of many places, which
  /// bounds the search, and takes this one's.
  double depth_mm(const Vec3& X_mm, Bvh::Closest& near) const;
  /// Distance (mm) to the plane through the nearest point: the depth of a place beside the patch's rim, as though the
  /// patch went on there.
  double depth_of_plane_mm(const Vec3& X_mm, Bvh::Closest& near) const;

 private:
  void find(const Vec3& X_mm, Bvh::Closest& near) const;
  const TriMesh* mesh_ = nullptr;
  Bvh bvh_;
  std::vector<Vec3> corner_normal_;
  std::vector<std::array<Vec3, 3>> edge_normal_;  // per triangle: edge k from corner k to k + 1; sum of the faces there
};

/// Unit normal of triangle t.
Vec3 face_normal(const TriMesh& mesh, int32_t t);

}  // namespace limberg
