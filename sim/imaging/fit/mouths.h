#pragma once
// The mouths of cavities: orbits, nose, foramen magnum.
//
// What a narrow ball reaches from outside and a wide one does not are pockets. Most of them are shallow hollows of the
// surface (a temple, the space behind a cheek bone), and are surface. A pocket that goes on behind a throat for longer
// than the throat is wide is a cavity:
// it is closed at the throat, and the mesh will be opened there.
//
//   depth    length of the shortest way out to where the wide ball is, through the pocket (chamfer distance 3-4-5,
//   Borgefors 1986)
//   throat   connected nodes of one depth; its width: of the disc of their area; behind it lies what has its way out
//   through it
//
// Throats of all depths are a tree. From the outside inwards the first one is taken that is a mouth, unless one behind
// it is by far narrower for what lies behind (a hole at the ground of a hollow). When mouths are closed, a cavity may
// still be open elsewhere (the nose, to the throat): its ways out are longer now, and the search is made again, until
// there is no mouth left.
#include <vector>

#include "sim/geometry/vec.h"
#include "sim/imaging/fit/grid_reach.h"

namespace limberg::imaging {

struct MouthRule {
  double threshold = 4;      // steps: hollows less deep are surface
  int levels = 2;            // of throats, two steps each: what is narrow only far behind belongs to the surface
  double depth_width = 0.8;  // a cavity is deeper than so many widths of its throat
  double narrower = 1.5;     // a throat farther in is taken when it is better by so much
  double least_width = 9, most_width = 25;  // steps: throats that are narrower or wider are surface
};

struct GridMouth {
  Vec3 centre = Vec3::Zero();   // of the throat, in steps
  double width = 0, depth = 0;  // of the throat; behind it; in steps
};

/// `within`: nodes of the volume: there is no mouth beyond its borders. `fill` receives 1 in cavities that are closed,
/// 2 in their throats and in front of them up to `threshold` outwards. Mouths by width.
std::vector<GridMouth> find_mouths(const GridSize& size, const std::vector<uint8_t>& set,
                                   const std::vector<uint8_t>& within, const Reach& narrow, const Reach& wide,
                                   const MouthRule& rule, std::vector<uint8_t>& fill, Workers& workers);

}  // namespace limberg::imaging
