#pragma once
// Where the tip of a stylus is: the tip stands in a dimple, the stylus is turned about it, and the sensor's poses tell.
// The same for a finger of a glove, whose tip is held on a fixed place while the hand turns.
//
// Each pose (R_i, p_i) says R_i t + p_i = c with the same tip t, in the sensor's frame, and the same dimple c: 3 N
// linear equations for six unknowns, solved by least squares over the poses that agree (random sample consensus: sets
// of four poses, the solution with the most poses within kInlierMm wins, then least squares over those, twice).
// What it may not accept is as important as what it finds: few poses, a narrow cone, a stylus that was only spun or
// only tilted in one plane, a tip that slipped. Limits: see PivotLimits.
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "sim/geometry/vec.h"

namespace limberg {

struct SensorPose {
  Vec3 pos_mm = Vec3::Zero();
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
};

/// From simulations with the noise of a FASTRAK (0.44 mm an axis, 0.15 degrees), 200 poses in a cone of 45 degrees: tip
/// within 0.2 mm in 95 of 100, residual 0.8 mm RMS; with 20 degrees 0.31 mm (2026-11-21).
struct PivotLimits {
  int poses = 200;
  double cone_deg = 40;          // full opening
  double weakest = 0.10;         // smallest singular value of the equations, per square root of the poses
  double residual_mm = 1.0;      // RMS of |R t + p - c| over the poses that agree
  double inliers = 0.9;          // share of poses that agree
  double repeat_mm = 0.5;        // tips of the first and of the second half apart
  const char* what = "stylus";   // in words: what is turned ...
  const char* where = "dimple";  // ... and what about
};

struct PivotResult {
  Vec3 tip_mm = Vec3::Zero();     // in the sensor's frame
  Vec3 dimple_mm = Vec3::Zero();  // in the tracker's
  int poses = 0, agreeing = 0;
  double cone_deg = 0, weakest = 0, residual_mm = 0, repeat_mm = 0;
  double uncertainty_mm = 0;  // of the tip, one standard deviation, if errors were independent
  bool accepted = false;
  std::string advice;  // when refused: what is wrong and what to do
};

PivotResult calibrate_pivot(const std::vector<SensorPose>& poses, uint64_t seed = 1, const PivotLimits& limits = {});

}  // namespace limberg
