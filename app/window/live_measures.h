#pragma once
// What is measured on a head while it is operated: from the landmarks
// of each snapshot against where they were when they were first seen.
#include <vector>

#include "app/head/measures.h"
#include "sim/patient/snapshot.h"

namespace limberg {

class LiveMeasures {
 public:
  /// Costs nothing while no landmark moves.
  const std::vector<HeadMeasure>& read(const Snapshot& snapshot);

 private:
  NamedPlaces first_, now_;
  std::vector<Vec3f> last_;
  uint64_t version_ = 0;
  std::vector<HeadMeasure> rows_;
};

}  // namespace limberg
