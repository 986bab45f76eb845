#pragma once
// The steps of setting a room up: what a person is asked to do, in plain words, and what is made of the readings that
// came meanwhile. A step is judged by figures with limits; one that calibrates changes the calibration if it is good.
//
//   rest     hands off: rate, gaps and noise of every stream
//   tip      the stylus is turned in a dimple: where its tip is               (calibration/pivot.h)
//   table    corners of a sheet of A4 are touched: where the tracker stands   (calibration/registration.h)
//   hand     the glove's hand opens and closes: how far                       (calibration/glove_range.h)
//   stroke   a line along the sheet's edge with the tool pressed
//   grab     the hand closes three times: is each counted, and nothing else?
//   reach    where the hand can go and is seen
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "app/room/room_file.h"
#include "calibration/calibration.h"
#include "devices/sample.h"

namespace limberg {

/// What was heard of a device.
struct HeardDevices {
  bool stylus = false, glove = false;
  bool tracked = false;  // its places are those of a tracker: they mean little without a calibration
};
HeardDevices heard_in(std::span<const Sample> samples);

struct StepOutcome {
  std::vector<RoomCheck> checks;
  std::string advice;  // what is wrong and what to do; empty: nothing
  bool good() const;
};

struct RoomStep {
  const char *name, *title;
  const char* ask;  // what to do
  const char* why;
  double seconds = 5;
  bool calibrates = false;  // what follows hangs on it
  StepOutcome (*judge)(std::span<const Sample> samples, double seconds, Calibration& calibration) = nullptr;
  /// So many presses end it before its time; 0: it takes its time.
  int presses = 0;
};

/// Those that these streams need, in their order.
std::vector<RoomStep> room_steps(const HeardDevices& heard);

/// The points of the step "table", in the world: a sheet of A4 that lies before the person with its long side along x,
/// its middle the middle of the patient's skin. Corners from the left far one clockwise, then the middle.
std::vector<Vec3> sheet_points();

/// Presses of a stylus of a tenth of a second and more so far.
int presses_in(std::span<const Sample> samples);

}  // namespace limberg
