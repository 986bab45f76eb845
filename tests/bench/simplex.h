#pragma once
// `limberg bench simplex`: what simplex meshes cost, and whether their operators keep what they promise.
//
//   - one iteration of the law of motion (geometry, simplex-angle
//     continuity, update), in ns per vertex on one core, from
//     1,280 to 1.3 million vertices, beside the same formulas as a
//     plain loop of scalars compiled like the rest of the program;
//   - the other constraints, and a face with a skull as a session would move them;
//   - random sequences of all operators on a sphere, a torus and a plane, with every invariant checked after each.
#include <functional>
#include <string>

#include "app/operating_point/bench.h"

namespace limberg::bench {

struct SimplexSettings {
  bool quick = false;                                // up to 20,480 vertices, 3,000 operators
  std::function<void(const std::string&)> progress;  // empty: silent
};

Result simplex_suite(const SimplexSettings& settings);

}  // namespace limberg::bench
