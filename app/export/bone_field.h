#pragma once
// The distance to bones as a field, for what is shaped to fit them: below 0 within any of them.
#include <vector>

#include "sim/imaging/io/surface_file.h"
#include "sim/skull/bone/bones.h"
#include "sim/skull/bone/surface.h"

namespace limberg {

class BoneField {
 public:
  /// Each is closed by itself: two fragments of one bone share a wall, and a place in one is outside of the other. What
  /// is inside is told by lines that leave it (bone/surface.h): normals do not tell it beside folds and thin edges.
  void add(const Surface& closed);
  bool empty() const { return part_.empty(); }
  double distance_mm(const Vec3& x_mm) const;
  /// True where a line from there meets bone within `reach_mm`.
  bool meets(const Vec3& from_mm, const Vec3& direction, double reach_mm) const;

 private:
  struct Part {
    bone::BoneSurface surface;
    Vec3 low_mm, high_mm;
  };
  std::vector<Part> part_;
};

/// A fragment's closed surface at rest.
Surface fragment_surface(const bone::Bones& bones, const bone::Fragment& fragment);

}  // namespace limberg
