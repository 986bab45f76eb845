#pragma once
// What is known about a device, a user and a room: plain numbers with a version, kept in a TOML file.
//
//   p_world = R_WT (D(p_sample) + R_TS tip_offset) + t_WT
//
// where p_sample and R_TS are the position and orientation that the device sends and D is the correction of a field
// that metal bends, if there is one. The identity calibration leaves a
// stream as it is; recordings of the emulated surgeon use it.
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "sim/geometry/vec.h"

namespace limberg {

/// How the stream of a tracker becomes one pose per device tick (devices/tracking.h).
struct FilterParameters {
  double process_noise_mm2_s3 = 3e4;   // white acceleration noise of the constant-velocity Kalman filter, per axis
  double measurement_noise_mm = 0.08;  // standard deviation of one reading, per axis
  double turn_process_noise_rad2_s3 = 30;
  double turn_measurement_noise_rad = 0.004;
  double euro_min_cutoff_hz = 5;  // One-Euro filter at the tick rate: cut-off at rest ...
  double euro_beta_per_mm = 0.5;  // ... and its growth per mm/s of speed
  double euro_derivative_cutoff_hz = 10;
  double max_prediction_ms = 25;  // a pose is never extrapolated further than this
  double stale_ms = 100;          // without a reading for this long the pose is invalid
  double max_speed_mm_s = 3000;   // a faster jump between two readings is not a hand
  double max_turn_deg = 30;       // nor is a larger turn between two readings 8.3 ms apart
  double latency_ms = 0;          // how long before its time stamp a reading was true
};

/// A hand in a glove (devices/glove.h).
struct GloveParameters {
  double closed_mm = 10, open_mm = 70;  // distance of the finger tips of this user's closed and open hand
  double grab_share = 0.25;             // closed below this share of the way from closed to open ...
  double release_share = 0.40;          // ... and open above this one
  double readings = 3;                  // in a row beyond the threshold, of both fingers
  double motion_scale = 1;              // what is held moves so much as the hand does
  Vec3 forefinger_tip_mm = Vec3::Zero(), thumb_tip_mm = Vec3::Zero();  // the tips in the frames of their sensors
  Vec3 pointing = Vec3::UnitX();  // the forefinger's direction in the frame of its sensor; unit
};

/// Correction of a distorted field: what is to be added to a position in the tracker's frame, on the nodes of a regular
/// grid, trilinear between them and constant outside.
struct DistortionGrid {
  std::array<int, 3> nodes{0, 0, 0};  // 0: no correction
  Vec3 low_mm = Vec3::Zero(), high_mm = Vec3::Zero();
  std::vector<Vec3> add_mm;  // x fastest
  bool empty() const { return add_mm.empty(); }
  Vec3 at(const Vec3& p_mm) const;
};

struct Calibration {
  static constexpr int kVersion = 1;
  std::string name = "identity";
  Vec3 tip_offset_mm = Vec3::Zero();                          // the tip in the sensor's frame
  Vec3 world_from_tracker_mm = Vec3::Zero();                  // t_WT
  std::array<double, 4> world_from_tracker_quat{1, 0, 0, 0};  // R_WT as w, x, y, z; unit length
  FilterParameters filter;
  GloveParameters glove;
  std::optional<GloveParameters> other_glove;  // of a second one; none: as the first
  DistortionGrid distortion;
  std::string device, date;  // what was calibrated and when (ISO 8601), as the user said; not part of the hash
};

/// Reads a calibration. `name` stands for the file in errors. Throws InputError: broken TOML, unknown key, unknown
/// version, a number that is not finite or out of range, a quaternion that is not of unit length to 1 %.
Calibration parse_calibration(const std::string& toml, const std::string& name);
/// The same from a file; InputError when it cannot be read.
Calibration load_calibration(const std::string& path);
/// As TOML text that parse_calibration reads back to the same bits.
std::string to_toml(const Calibration& calibration);
/// Writes beside the target and renames, so that an existing
/// file is replaced whole or not at all. InputError on failure.
void save_calibration(const Calibration& calibration, const std::string& path);
/// Over every number of the calibration; part of a recording's first event.
uint64_t calibration_hash(const Calibration& calibration);

}  // namespace limberg
