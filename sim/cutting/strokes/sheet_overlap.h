#pragma once
// A new undermining sheet over a pocket that is there already: it must run into the pocket, not beside it.
//
// Where the old pocket reaches at least kDeepReach further, the new sheet dips just below it; elsewhere it stays just
// above. So the two cross well inside the old pocket, and what lies beyond the crossing is no seed and is not cut.
#include <span>
#include <vector>

#include "sim/cutting/strokes/blade_build.h"

namespace limberg {

class PocketMap {
 public:
  explicit PocketMap(const Arrangement* arrangement) : arrangement_(arrangement) {}
  /// Height in mm above p (along the unit normal n) of the nearest live wall that runs across n within `reach`.
  std::optional<double> height(const Vec3& p_mm, const Vec3& n, double reach_mm) const {
    return at(p_mm, n, n, reach_mm);
  }
  /// The same of a wall along the skin, whose normal is `up`, for a line that may lean against it by 78 degrees: p lies
  /// within `reach` of the wall's plane.
  std::optional<double> at(const Vec3& p_mm, const Vec3& n, const Vec3& up, double reach_mm) const;

 private:
  const Arrangement* arrangement_;
};

inline constexpr double kDeepReach = 0.55;  // a quarter of a mesh width: there the two have crossed

struct SheetVertex {
  Vec3 X_mm, normal;     // on the sheet; outward
  bool covered = false;  // over or under an earlier pocket
  bool deep = false;     // and so is everything within kDeepReach
  double height = 0;     // of that pocket's wall above X
};

/// Moves the vertices as described above. True when there is an overlap.
bool run_into_pockets(std::span<SheetVertex> sheet);

}  // namespace limberg
