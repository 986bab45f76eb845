#pragma once
// A hand whose truth is known, through everything that stands between it and a gesture: the emulated FASTRAK, bytes on
// a line, the conversation, time stamps, filters, thresholds. Simulated time; a second of it costs some milliseconds.
#include <cstdint>
#include <functional>
#include <vector>

#include "calibration/calibration.h"
#include "devices/fastrak/virtual_line.h"
#include "devices/glove.h"

namespace limberg::bench {

/// Quick reaches of up to 150 mm in 0.4 s with rests of 0.2 s, minimum jerk, and a tremor of 0.1 mm at 9.5 Hz.
fastrak::Motion reaching_hand(uint64_t seed);

struct TrackingFigures {
  double rms_mm = 0;          // of the followed station against where it truly is at the tick
  double lag_ms = 0;          // the shift of the truth that fits best
  double rms_shifted_mm = 0;  // at that shift
  double jitter_mm = 0;       // standard deviation along an axis while the hand rests
  double max_step_mm = 0;     // from tick to tick
  double turn_rms_deg = 0;
  double rate_hz = 0;  // readings of one station
};

struct TrackingTrial {
  uint64_t seed = 1;
  double seconds = 40;
  double noise_mm = 0.05;
  bool two_stations = true;  // 60 Hz each, else one at 120
  FilterParameters filter;
};
TrackingFigures tracking_trial(const TrackingTrial& trial);

/// An hour, say, of a hand that rests, wanders and trembles, half
/// open, in a damaged line; and so many grabs that are meant.
struct GrabTrial {
  uint64_t seed = 1;
  double idle_s = 0;
  int grabs = 0;
  double noise_mm = 0.10;         // per axis of a reading
  double damage_per_byte = 1e-4;  // one record in 300
  double within_ms = 50;
};
struct GrabFigures {
  int64_t false_grabs = 0;                     // in the idle time
  double idle_s = 0, least_aperture_mm = 1e9;  // the hand's true one in that time
  int64_t meant = 0, in_time = 0, missed = 0, extra = 0;
  double median_ms = 0, worst_ms = 0;  // from the true crossing of the threshold to the grab
  int64_t readings = 0, damaged = 0;
};
GrabFigures grab_trial(const GrabTrial& trial);

}  // namespace limberg::bench
