#pragma once
// The lattice as it lies now, for a picture: plain data, made by the solver thread only while somebody wants to see it.
#include <cstdint>
#include <memory>
#include <vector>

#include "sim/geometry/vec.h"

namespace limberg {

struct LatticeShown {
  struct Edge {
    int32_t a = 0, b = 0;  // node copies
    bool copied = false;   // of a cell of which there are several copies
  };
  uint64_t version = 0;                            // of the topology
  std::shared_ptr<const std::vector<Edge>> edges;  // each once; shared by version
  std::vector<Vec3f> node_mm;
};

}  // namespace limberg
