#pragma once
// What is picked on a head by mouse, stylus or cursor: places, and what lies between two of them. Kinds of ControlSample beside its own,
// and the events that Gestures makes of them.
//
//   landmark control  text: the name; value: the place at rest x, y, z and what it lies on (Ground). Of the last, touched: no place is given,
//                     it is where the tool touches bone; above: the place of the face nearest to the tip
//   tissue control    text: "A/B", a landmark on the face and one on bone, the tissue is named A-B; value: radius on the face and on bone (mm, 0: all bone), layers,
//                     Young's modulus (kPa). The landmarks are those of the snapshot, where they are now. "A/B/springs": in that mode
//                     (kTissueKinds), else finite elements
//   beside control    value[0]: what the skull is laid upon (SkullBeside); text: the name of that moment
#include <cstdint>

namespace limberg::pick {

enum Control : int32_t { landmark = 7, tissue = 8, beside = 10 };
constexpr int32_t last_control = beside;
enum On : int32_t { touched = 0, bone = 1, face = 2, above = 3 };
/// ToolEvent::kind. place: rest_mm, text its name, id 1 on the face. between: rest_mm on the face, world_mm on bone, text the name, depth_mm
/// and spacing_mm the radii, id the layers and 100 times the mode, angle_deg the modulus. laid_upon: id the SkullBeside, text the name.
enum Event : int32_t { place = 100, between = 101, laid_upon = 102 };

}  // namespace limberg::pick
