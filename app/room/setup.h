#pragma once
// The set-up of a room as a talk: each step is explained, begun with Enter, judged, and done again where it was not
// good. Words go to a stream and answers come from one, so that a script can hold the talk as well as a person.
#include <iosfwd>
#include <map>
#include <string>
#include <vector>

#include "app/room/hands.h"
#include "app/words/words.h"

namespace limberg {

struct RoomTalk {
  std::istream& in;
  std::ostream& out;
  bool waits = true;  // for Enter; else each step begins after a countdown of 3 s (none with an emulated hand)
  Words w{};          // what it is held in
};

struct SetUpOutcome {
  Calibration calibration;
  bool calibrated = false;  // a step that calibrates was good
  std::vector<RoomCheck> checks;
  std::map<std::string, std::vector<Sample>> heard;  // of each step, its last try
  std::vector<std::string> not_good;                 // steps that ended so, or were left out
  bool usable = false;                               // every step that calibrates was good
  bool ended = false;                                // by the person, or the answers ended
};

/// `check_only`: the steps that do not calibrate, with the calibration `from`.
SetUpOutcome set_up(RoomHands& hands, const RoomTalk& talk, const Calibration& from, bool check_only);

/// "good  stylus: noise of a reading at rest   0.21 mm, at most 0.9"
std::string in_words(const RoomCheck& check, const Words& w = {});

}  // namespace limberg
