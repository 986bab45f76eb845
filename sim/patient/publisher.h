#pragma once
// The soft tissue as a snapshot: places of the surface, hooks, sutures, the field of tension.
#include <memory>

#include "sim/patient/tension_field.h"
#include "sim/patient/tissue.h"

namespace limberg {

class Publisher {
 public:
  /// Reuses the snapshot's memory. The tension field costs a few ms.
  void fill(const Tissue& tissue, const Holding& holding, const LastStep& last, Snapshot& snapshot, bool with_field);

 private:
  std::unique_ptr<TensionField> tension_;
  uint64_t tension_version_ = 0;
};

}  // namespace limberg
