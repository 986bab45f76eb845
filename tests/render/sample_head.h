#pragma once
// A made-up head for tests: half an egg of face over half an egg of bone, with a plate of the bone cut out and moved.
#include "sim/patient/snapshot.h"

namespace limberg::testing {

/// moved_mm: how far the plate has come forwards (towards -y); the face over it comes along, less and less to the
/// sides, and says so in Snapshot::moved_mm.
Snapshot sample_head(double moved_mm = 0);

}  // namespace limberg::testing
