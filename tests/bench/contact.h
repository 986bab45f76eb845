#pragma once
// `limberg bench contact`: what it costs that wound surfaces keep each other out, and how well they do.
//
//   operations  carried out to rest with contact and without: overlap that
//               is left (measure/penetration.h), CPU time and iterations,
//               each against the same operation without. The two shipped
//               operations in their scenes, and all procedures with their
//               own settings on a patch of skin, at 3.5 mm.
//   live        the shipped rhomboid's flap carried to its place, 60 steps a
//               second of 10 iterations each: CPU time of a step, and of finding
//               contacts in it (the median and the 95th percentile of the steps)
#include <functional>
#include <string>

#include "app/operating_point/bench.h"

namespace limberg::bench {

struct ContactBench {
  bool quick = false;  // the shipped operations only
  std::string only;    // operations whose name contains this; "live": the live steps
  std::function<void(const std::string&)> progress;
};

Result contact(const ContactBench& settings);

}  // namespace limberg::bench
