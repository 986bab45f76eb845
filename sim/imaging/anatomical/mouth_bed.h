#pragma once
// What lips lie against: teeth and gums of the anatomical head, as far as the vestibule reaches. They do not move.
#include <memory>

#include "sim/base/workers.h"
#include "sim/geometry/tri_mesh.h"
#include "sim/imaging/anatomical/bone_shape.h"

namespace limberg {

class MouthBed {
 public:
  /// Keeps a reference to the skin.
  explicit MouthBed(const anatomical::SkinShape& skin);
  /// mm, below 0 inside; they grow by no more than kLipschitz a mm.
  double teeth(const Vec3& p) const;
  double gums(const Vec3& p) const;
  double operator()(const Vec3& p) const;  // of both
  static constexpr double kLipschitz = anatomical::BoneShape::kLipschitz;

 private:
  const anatomical::SkinShape* skin_;
  std::shared_ptr<const anatomical::BoneShape> bone_;
};

/// Closed surfaces of teeth and gums, mm; without tags.
struct MouthBedMeshes {
  TriMesh teeth, gums;
};
MouthBedMeshes make_mouth_bed(const MouthBed& bed, Workers& workers);

}  // namespace limberg
