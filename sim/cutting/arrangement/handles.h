#pragma once
// Handles of the sided surface, counted as one number.
#include <cstdint>

#include "sim/cutting/arrangement/arrangement.h"

namespace limberg {

/// V - E + F of all closed components together: 2 per piece of tissue without holes, less 2 per handle. A wall that is
/// only deepened keeps it; one that leaves a bridge of tissue beside it lowers it by 2. O(faces)
int64_t euler_characteristic(const Arrangement& a);

}  // namespace limberg
