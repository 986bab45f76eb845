#pragma once
// What contact has cost so far, counted; for tests and reports. Nothing that is computed depends on it.
#include <cstdint>

namespace limberg {

struct ContactCounts {
  uint64_t surfaces = 0;     // made after cuts
  uint64_t checks = 0;       // of what has moved since contacts were found
  uint64_t searches = 0;     // of some places at least
  uint64_t queries = 0;      // places that were asked about, in all searches
  uint64_t reprojected = 0;  // pairs that were projected anew
  uint64_t iterations = 0;   // of the minimiser while there was a surface that can collide
  // Of the surface as it is now:
  uint64_t places = 0, triangles = 0, pairs = 0;
  uint64_t damped = 0;  // places whose pairs stand still (damping)
};

}  // namespace limberg
