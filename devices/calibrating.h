#pragma once
// What the procedures of calibration/ ask for, from the readings of a device: a stylus' readings as its sensor's, the
// places that it rested on, the way between the finger tips of a glove.
#include <span>
#include <vector>

#include "calibration/calibration.h"
#include "devices/sample.h"

namespace limberg {

/// Readings of a stylus, as a sensor's, in order; those of a tracker's station and those of a stylus by itself.
std::vector<StylusSample> stylus_readings(std::span<const Sample> samples);
Eigen::Quaterniond rotation_of(const StylusSample& sample);

/// A place that the stylus rested on with its switch pressed.
struct Touch {
  Vec3 sensor_mm = Vec3::Zero(), tip_mm = Vec3::Zero();  // in the tracker's frame, as measured
  double spread_mm = 0;                                  // of the tip, RMS
  int readings = 0;
};
/// Presses of a tenth of a second and more. The switch moves the hand when it is pressed and let go: the middle three
/// fifths of each count.
std::vector<Touch> touches(std::span<const StylusSample> readings, const Vec3& tip_offset_mm);
inline constexpr double kStillTouch_mm = 1.5;  // RMS: twice the static accuracy of a FASTRAK

/// Distances between the finger tips, each 16 ms while both are tracked, by the tips of `calibration.glove`. `other`:
/// of the glove on the other hand. `readings`: how many there were of its fingers.
inline constexpr double kAperturesHz = 62.5;
std::vector<double> apertures(std::span<const Sample> samples, const Calibration& calibration, bool other,
                              int64_t* readings = nullptr);

}  // namespace limberg
