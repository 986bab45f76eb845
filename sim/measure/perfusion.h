#pragma once
// Where the blood may not reach: a risk map of undermined skin
// from one published measurement, and nothing more than that.
//
// Skin that is undermined lives from what reaches it within the skin, from where it is still attached below. In random
// flaps of pigs, 5 to 10 mm wide, perfusion at 20, 25 and 30 mm from the base was 40, 20 and about 0 % (Memarzadeh et
// al. 2016); it depended on length and thickness, not on the ratio of width to length. Those three lie on a line,
//
//   index = (30 mm - d) / 25 mm, between 0 and 1,
//
// d: the way within the remaining skin at rest to the nearest skin that is not undermined. The source has no
// spread for single flaps and none for people; facial skin is perfused better than a pig's flank. So the map
// orders places and designs; it foretells no necrosis. Tension lowers flow too (Larrabee, Holloway and Sutton
// 1984: necrosis rose above 2.45 N of closing tension): sutures above that are counted beside it, not mixed in.
#include <vector>

#include "sim/body/skin.h"
#include "sim/cutting/arrangement/surface_view.h"

namespace limberg {

struct Perfusion {
  std::vector<float> index;   // per triangle of the view: 0 to 1; 1 where not undermined, -1 on what is no skin
  double undermined_mm2 = 0;  // skin above a cut, at rest
  double farthest_mm = 0;     // largest d of a place that can be reached at all
  double least = 1;           // index
  double below_40_mm2 = 0;    // skin of index below 0.4: farther than 20 mm
  double severed_mm2 = 0;     // skin that no way leads to: a flap without a pedicle
};

/// Ways go from centre to centre of triangles that are neighbours or have a neighbour
/// in common: up to 10 % longer than the shortest, so the index is up to 0.1 too low. A
/// place is undermined when a wall that lies flatter than 60 degrees to it is on the way inwards from the middle of its
/// triangle, before that leaves the body.
Perfusion perfusion(const SurfaceView& view, const Skin& skin);

}  // namespace limberg
