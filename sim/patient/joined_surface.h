#pragma once
// Soft tissue and head as one surface: the skin's vertices and triangles first, in their own order, then face and
// bones.
#include <memory>

#include "sim/patient/snapshot.h"

namespace limberg {

class JoinedSurface {
 public:
  /// The same one as long as both are the same.
  std::shared_ptr<const SurfaceTopology> of(const std::shared_ptr<const SurfaceTopology>& skin,
                                            const std::shared_ptr<const SurfaceTopology>& head);
  /// `shown` is of the skin, and of both afterwards.
  static void append(Snapshot& shown, const Snapshot& head, const std::shared_ptr<const SurfaceTopology>& both);

 private:
  std::shared_ptr<const SurfaceTopology> skin_, head_, both_;
  uint64_t version_ = 0;
};

}  // namespace limberg
