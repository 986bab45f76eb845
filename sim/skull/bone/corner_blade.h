#pragma once
// A blade of several planes that meet in a corner: what a saw and an osteotome leave that change direction in the bone.
//
//   corner C, rays r0, r1, ... rn    the sectors between r0 and r1, r1 and r2, ...: places C + s r_i + t r_(i+1)
//
// Two rays are a plane that ends at its corner and sides. Three are a step: of a Le Fort I, say, a level cut through
// the maxilla and an upright one behind it, which meet along a line across. Four are a sagittal split: level through
// the inner half of the ramus, along its middle downwards, and across the outer half of the body.
//
// A sector is a parallelogram: s and t end where their rays do. The blade unrolls flat about its corner: there, curves
// on it have insides and outsides as in a plane, as long as the sectors take up less than a full turn together.
#include <string>
#include <vector>

#include "sim/geometry/vec.h"

namespace limberg::bone {

class CornerBlade {
 public:
  /// Rays are lengthened to `reach_mm`.
  CornerBlade(const Vec3& corner_mm, const std::vector<Vec3>& rays, double reach_mm);
  /// Why it is no blade: places that are not finite, fewer than two rays or more than eight, two that follow each other
  /// at less than 5 or more than 150 degrees, a full turn or more, a sector that crosses or touches an earlier one.
  /// Empty: it is one.
  const std::string& fault() const { return fault_; }

  const std::vector<Vec3>& places_mm() const { return X_mm_; }  // the corner, the ends of the rays, the far corners
  const std::vector<Tri>& triangles() const { return tri_; }    // normals to the left: r_i x r_(i+1)
  size_t sectors() const { return normal_.size(); }
  /// The sector that is nearest.
  size_t sector(const Vec3& x_mm) const;
  /// Its place in the unrolled blade, of the nearest place of the nearest sector's plane.
  Vec2 unrolled(const Vec3& x_mm) const;
  /// How far a place lies on the left of the plane that halves the angle at the fold between sector k - 1 and sector k,
  /// in the blade: > 0 in sector k, < 0 in the one before.
  double past_fold(size_t k, const Vec3& x_mm) const;
  /// Along the ray of that fold, from the corner.
  double along_fold(size_t k, const Vec3& x_mm) const;

 private:
  double apart2(size_t sector, const Vec3& x_mm) const;
  std::string fault_;
  std::vector<Vec3> X_mm_;
  std::vector<Tri> tri_;
  std::vector<Vec3> ray_, normal_;  // unit; of rays, of sectors
  std::vector<double> angle_;       // at which each ray lies in the unrolled blade
};

}  // namespace limberg::bone
