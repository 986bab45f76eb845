#pragma once
// Where a place of the tissue lies now that is named by where it lay at rest: on skin or on a cut face.
#include <optional>

#include "sim/commands/command.h"
#include "sim/patient/snapshot.h"

namespace limberg {

/// The nearest place of that kind within 4 mm at rest, as it lies now. Of two walls that lie in one place at rest the
/// one whose tissue X lies in. Nothing where there is none. O(triangles)
std::optional<Vec3> held_place(const Snapshot& s, const Vec3& X_mm, HeldSide side);

/// What a cut face is that looks this way, where the skin's outward normal is `up`; both at rest, unit.
HeldSide side_of_face(const Vec3& normal, const Vec3& up);

}  // namespace limberg
