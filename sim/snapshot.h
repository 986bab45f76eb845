#pragma once
// What the solver thread shows to the others: plain data, copied or shared by version, never written after publishing.
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "sim/cutting/surface_view.h"
#include "sim/fem/fem_model.h"
#include "sim/geometry/body.h"

namespace limberg {

/// Changes only when a cut, an excision or an undo does. Immutable, shared by version.
struct SurfaceTopology {
  uint64_t version = 0;
  uint64_t hash = 0;
  SurfaceView view;
  SharedArray<EmbeddedPoint> embedding;  // per view vertex
  SharedArray<float> depth_mm;           // per view vertex: distance below the skin at rest
  std::shared_ptr<const Body> body;
};

struct HookState {
  int32_t id = 0;
  Vec3f at_mm, handle_mm;  // on the tissue; where it is pulled to
  Vec3f force_N;
};

struct SutureState {
  int32_t id = 0;
  Vec3f a_mm, b_mm;
  float force_N = 0, gap_mm = 0;
  int32_t thread = 0;      // stitches of one thread have one number; 0: a thread of its own
  // Of states at rest (relative residual at most 1e-3, every thread drawn tight): the force in the first of them, less than 0
  // as long as there is none, and the largest.
  float tied_N = -1, peak_N = 0;
};

struct Snapshot {
  uint64_t step = 0;               // solver steps done
  int64_t device_tick = 0;         // the newest device tick it has seen
  uint64_t topology_version = 0;
  std::shared_ptr<const SurfaceTopology> topology;  // kept alive by the solver's epoch list; readers only borrow it
  std::vector<Vec3f> x_mm;         // per view vertex
  std::vector<float> field;        // per view vertex: skin tension shown (largest principal stretch - 1), may be empty
  std::vector<HookState> hooks;
  std::vector<SutureState> sutures;
  float residual = 0, distance_mm = 0;
  int32_t stage = -1;              // number of stages passed
};

}  // namespace limberg
