#pragma once
// What the parts of FaceModel share, and nobody else needs.
#include <set>

#include "sim/skull/face/face_model.h"
#include "sim/skull/simplex/motion.h"

namespace limberg::simplex {

/// Of a vertex of the face: follows tissue and its own shape; is where the finite elements put it; stays; moves as the
/// mean of its neighbours does.
enum FaceZone : uint16_t { kFree = 0, kCarried = 1, kFar = 2, kEvened = 3 };

struct FaceModel::Scratch {
  explicit Scratch(Workers& w) : motion(w) {}
  Motion motion;
  std::vector<Vec3> force;
};

inline int fragments_under(const std::vector<int32_t>& component, const std::vector<Foot>& feet) {
  std::set<int32_t> seen;
  for (const Foot& f : feet)
    if (f.at.skull[0] >= 0) seen.insert(component[size_t(f.at.skull[0])]);
  return int(seen.size());
}

}  // namespace limberg::simplex
