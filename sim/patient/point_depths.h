#pragma once
// How far below the skin each vertex of the drawn surface lies at rest, for pictures of the layers and buried stitches.
//
// A cut does not pay for it: the depths of a version are found when somebody first asks for them, on whatever thread,
// from those that were asked for last. Points never move, so only vertices that differ from those cost a search. The
// answer does not depend on what was asked for before.
#include <memory>
#include <mutex>

#include "sim/base/lazy.h"
#include "sim/body/skin.h"
#include "sim/cutting/arrangement/surface_view.h"

namespace limberg {

class PointDepths {
 public:
  /// in_layers: depths as the layers of the body count them (Skin::in_layers_mm), but for the first layer: as a share
  /// of its thickness there, from 0 at the skin to what Body::layers says.
  explicit PointDepths(bool in_layers = false) : in_layers_(in_layers) {}
  /// Depths in mm, one per vertex of the view. `change`: from the view before. Corners of skin lie at 0; others cost a
  /// search for the nearest skin. `on_skin`, per point: a triangle of skin has had it as a corner, in this version or
  /// one that it came from; it belongs to the version, so that it goes back with undo and forth with redo.
  Lazy<SharedArray<float>> follow(const SurfaceView& view, const ViewChange& change, std::shared_ptr<const Skin> skin,
                                  SharedArray<uint8_t>& on_skin);

 private:
  struct Last {  // what was asked for last
    std::mutex mutex;
    SharedArray<Vec3> X_mm;
    SharedArray<int32_t> point;
    SharedArray<float> depth_mm;
  };
  struct Asked;
  static SharedArray<float> find(const Asked& asked);

  bool in_layers_;
  std::shared_ptr<Last> last_ = std::make_shared<Last>();
};

}  // namespace limberg
