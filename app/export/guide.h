#pragma once
// What is printed for an operation: a guide for the saw, and a splint between the teeth.
//
// A cutting guide lies on the bone on both sides of a cut, where the bone can be reached from outside: a shell, with a
// slot along the cut through which the saw goes. Bridges over the slot hold it together. It is made at rest, where the
// bone is before it is cut.
//
// A splint fills the space between upper and lower teeth as they are planned to lie, around their edges, and has the
// teeth's shape subtracted. Whether Is and Ii lie on teeth or on gums nobody has told the program.
//
// Both are the zero of a field (level_set.h: march), so that they are closed.
#include <string>
#include <vector>

#include "app/export/bone_field.h"
#include "sim/base/workers.h"
#include "sim/skull/head/head.h"

namespace limberg {

struct GuideSettings {
  double off_bone_mm = 0.2;  // between bone and guide
  double thick_mm = 3;
  double half_width_mm = 8;  // to either side of the cut
  double slot_mm = 1.2;      // a saw's blade is 0.4 to 1 mm thick
  double bridge_mm = 7, between_bridges_mm = 40;
  double grid_mm = 0.6;
  double least_mm3 = 300;  // smaller parts are left out
};

struct Made {
  std::vector<Surface> parts;  // closed, the largest first
  std::string why;             // why there is none; empty: there is one
};

/// For the cuts of this fragment. `bones_at_rest`: all bones.
Made cutting_guide(const bone::Bones& bones, const bone::Fragment& fragment, const BoneField& bones_at_rest,
                   const GuideSettings& settings, Workers& workers);

struct SplintSettings {
  double off_teeth_mm = 0.15;
  double over_edges_mm = 3;  // so far it goes over the edges of the teeth, above and below
  double around_mm = 3.5;    // so thick it is around them
  double deep_mm = 45;       // so far back from the front teeth
  double grid_mm = 0.6;
};

/// Upper teeth are on bones whose names do not begin with "mandible".
Made splint(const Head& head, const SplintSettings& settings, Workers& workers);

}  // namespace limberg
