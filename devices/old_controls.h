#pragma once
// Acts on a head as recordings before command_t have them: in the text and the four values of a control. Nothing writes
// them any more; recordings are replayed by this.
//
//   7  landmark  text: the name; value: the place at rest x, y, z and what it lies on (1 bone, 2 face). Where the tool
//                touches (0, 3) is said so today too: ControlSample::name_place
//   8  tissue    text: "A/B" or "A/B/MODE", a landmark on the face and one on bone, where they are now; value: radius
//                on the face and on bone (mm, 0: all bone), layers, Young's modulus (kPa)
//   10 beside    value[0]: what the skull is laid upon (SkullBeside); text: the name of that moment
//   11 shift     value: a place on the fragment; text: translation x, y, z in mm, rotation x, y, z in degrees
//   12 snap      value: a place on the fragment, which is let go where it lies, into its cut
//   13 corner    value: a place of a closed line, and 0 for the first, 1 for a further one, 2 for the last
//   14 plane     value: a place and the radius (0: all); text: the plane's normal
//   15 plate, 16 join   value: a place on one fragment; text: one on the other
// Numbers in a text stand between blanks.
#include <memory>
#include <vector>

#include "devices/sample.h"
#include "sim/commands/command.h"
#include "sim/patient/snapshot.h"

namespace limberg {

class OldControls {
 public:
  enum Kind : int32_t {
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
  static constexpr int32_t kFirst = landmark, kLast = join;

  /// One control makes as many events as it made when it was recorded: a recording counts them. An event without a
  /// command says nothing yet.
  struct Told {
    bool understood = false;
    bool stops_hand = false;  // what the hand is doing is broken off
    std::vector<std::shared_ptr<const Command>> events;
  };
  Told read(const ControlSample& control, const Snapshot& snapshot);

 private:
  std::vector<Vec3> corners_;
};

}  // namespace limberg
