#pragma once
// How far below the skin each vertex of the drawn surface lies at rest, for pictures of the layers. Remembered by point of
// the arrangement: points never move, and banks share them.
#include <vector>

#include "sim/cutting/surface_view.h"
#include "sim/geometry/skin.h"

namespace limberg {

class PointDepths {
 public:
  /// Depths in mm of the vertices that `change` names (all when it is `whole`), written to `depth_mm`, one per vertex of the
  /// view. Corners of skin lie at 0; others cost a search for the nearest skin, begun at what was nearest to the last one.
  void follow(const SurfaceView& view, const ViewChange& change, const Skin& skin, SharedArray<float>& depth_mm);

  /// Points from this one on are no more: their numbers will mean others.
  void forget_from(int32_t point) {
    if (size_t(point) < known_.size()) known_.resize(size_t(point));
  }

 private:
  std::vector<float> known_;  // per point; NaN: not asked for yet
};

}  // namespace limberg
