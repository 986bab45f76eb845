#pragma once
// The bony external acoustic meatus in a CT, and the porion: the highest place of its outer rim.
//
// From the air beside the head the way inwards is sought that costs least, where a millimetre of air costs little, of
// soft tissue more and of bone far more (Dijkstra on an even grid about where the ear must be). Into the temporal bone
// that way leads along the canal, if there is one that the picture shows: it is one if bone lies above, beneath, before
// and behind the way over some millimetres. Going outwards on it, the last place with bone close above is at the rim;
// the porion is where that bone begins there.
#include <optional>

#include "sim/geometry/vec.h"
#include "sim/imaging/io/volume.h"

namespace limberg {

struct EarCanal {
  Vec3 porion_mm = Vec3::Zero();
  double deep_mm = 0;  // how far the canal was followed in bone
  double air_HU = 0;   // the mean along it
};

/// `head`: columns right, forwards and up in the frame of the volume, `near_mm` about where the porion is, `side` 1 on
/// the right and -1 on the left. Nothing where no canal is seen.
std::optional<EarCanal> find_ear_canal(const Volume& volume, double offset, double bone_HU, const Vec3& near_mm,
                                       const Mat3& head, double side);

}  // namespace limberg
