#pragma once
// What is picked on a head by mouse, stylus or cursor: places, and what lies between two of them. Kinds of
// ControlSample beside its own, and the events that Gestures makes of them.
//
//   landmark control  text: the name; value: the place at rest x, y, z and what it lies on (Ground). Of the last,
//   touched: no place is given,
//                     it is where the tool touches bone; above: the place of the face nearest to the tip
//   tissue control    text: "A/B", a landmark on the face and one on bone, the tissue is named A-B; value: radius on
//   the face and on bone (mm, 0: all bone), layers,
//                     Young's modulus (kPa). The landmarks are those of the snapshot, where they are now.
//                     "A/B/springs": in that mode
//                     (kTissueKinds), else finite elements
//   beside control    value[0]: what the skull is laid upon (SkullBeside); text: the name of that moment
//
// And by numbers and picked places, all at rest, what a panel has to say. Numbers in a text stand between blanks.
//
//   shift control     value: a place x, y, z on the fragment; text: translation x, y, z in mm and rotation x, y, z in
//   degrees (RigidMove)
//   snap control      value: a place x, y, z on the fragment, which is let go where it lies, into its cut
//   corner control    value: a place x, y, z of the closed line of an osteotomy, and 0 for the first, 1 for a further
//   one, 2 for the last
//   plane control     value: a place x, y, z and the radius (0: all); text: the plane's normal x, y, z
//   plate, join       value: a place x, y, z on one fragment; text: x, y, z on the other
#include <cstdint>

namespace limberg::pick {

enum Control : int32_t {
  landmark = 7,
  tissue = 8,
  beside = 10,
  shift = 11,
  snap = 12,
  corner = 13,
  plane = 14,
  plate = 15,
  join = 16
};
constexpr int32_t last_control = join;
enum On : int32_t { touched = 0, bone = 1, face = 2, above = 3 };
/// ToolEvent::kind. place: rest_mm, text its name, id 1 on the face. between: rest_mm on the face, world_mm on bone,
/// text the name, depth_mm and spacing_mm the radii, id the layers and 100 times the mode, angle_deg the modulus.
/// laid_upon: id the
/// SkullBeside, text the name.
/// shifted: rest_mm on the fragment, world_mm the translation, quat[1..3] the rotation in degrees. sawn: rest_mm on the
/// plane, world_mm its normal, depth_mm the radius. plated, joined: rest_mm and world_mm. Of a corner the events of a
/// stroke of the saw, text kPicked; of a
/// snap bone_grab and bone_release, text kSnap.
enum Event : int32_t {
  place = 100,
  between = 101,
  laid_upon = 102,
  shifted = 103,
  sawn = 104,
  plated = 105,
  joined = 106
};
inline constexpr const char *kPicked = "picked", *kSnap = "snap";

}  // namespace limberg::pick
