#pragma once
// The bones of the anatomical head: skull with two tables, sinuses and upper teeth; mandible with lower teeth.
#include <memory>

#include "sim/imaging/anatomical/skin_shape.h"

namespace limberg::anatomical {

class BoneShape {
 public:
  explicit BoneShape(const SkinShape& skin);
  ~BoneShape();
  /// mm, below 0 inside; they grow by no more than kLipschitz a mm.
  double skull(const Vec3& p) const;
  double mandible(const Vec3& p) const;
  double upper_teeth(const Vec3& p) const;
  double lower_teeth(const Vec3& p) const;
  static constexpr double kLipschitz = 2.2;

 private:
  struct Parts;
  std::unique_ptr<const Parts> parts_;
};

}  // namespace limberg::anatomical
