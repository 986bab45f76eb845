#pragma once
// `limberg bench head`: the face that follows the bones of the synthetic head.
//
//   - the mandible goes 8 mm forwards, the skull stays: each mode of the tissue against the finite elements at equilibrium, error of
//     the face over run time (warm start of one move, one core);
//   - what an update costs with a face of 5,000, tissue of about 20,000 and bones of 10,000 vertices.
#include <functional>
#include <string>

#include "app/bench/bench.h"

namespace limberg::bench {

struct HeadSettings {
  bool quick = false;  // fewer iterations
  std::function<void(const std::string&)> progress;  // empty: silent
};

Result head_suite(const HeadSettings& settings);

}  // namespace limberg::bench
