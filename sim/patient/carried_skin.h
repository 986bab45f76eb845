#pragma once
// Skin over bone that moves: the fixed nodes of the soft tissue that lie at most so far from a bone at rest go where
// their bone goes, as Dirichlet values of the finite elements. So a fragment that is moved pulls the skin attached to
// it.
#include <cstdint>
#include <utility>
#include <vector>

#include "sim/patient/soft_tissue.h"
#include "sim/skull/head/head.h"

namespace limberg {

class CarriedSkin {
 public:
  explicit CarriedSkin(double reach_mm) : reach_mm_(reach_mm) {}

  /// Costs nothing while neither bone nor skin has changed.
  void carry(SoftTissue& skin, const Head& head);
  void skin_changed() { stale_ = true; }  // by an act, undo or redo

 private:
  double reach_mm_;
  uint64_t skin_version_ = 0, bones_version_ = 0;
  std::vector<std::pair<Vec3, int32_t>> carrier_;  // place at rest, fragment (-1 none); in the order of hold_at
  std::vector<Eigen::Isometry3d> poses_;
  bool stale_ = true;
};

}  // namespace limberg
