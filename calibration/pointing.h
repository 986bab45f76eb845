#pragma once
// Which way the forefinger points in the frame of its sensor: it points at one place of the room from several sides.
//
// With the tip p_i (pivot.h) and the turn R_i of each pose, the direction from the tip to the place c, seen from the
// sensor, is always the same: u_i = R_i^T (c - p_i) / |c - p_i| = d. Five unknowns (c, and d on the unit sphere), two
// equations a pose: Gauss-Newton on u_i - d, from the closest place to the lines (p_i, R_i d) with the d that is known
// so far; then once more over the nine tenths of the poses that agree best.
// What it may not accept: few poses, a hand that stayed on one side (c and d are then anyone's guess), a hand that did
// not point.
#include <string>
#include <vector>

#include "calibration/pivot.h"

namespace limberg {

/// From simulations with the noise of a FASTRAK and an aim that wanders by 0.7 degrees, 300 poses from 60 degrees
/// about: the direction is right to 0.3 degrees in 19 of 20 (2026-11-27); a cone of half that doubles it.
struct PointingLimits {
  int poses = 200;
  double cone_deg = 40;     // full opening of the directions from which it pointed, over 95 % of the poses
  double residual_deg = 3;  // RMS between the forefinger and the place, over the poses that agree
  double uncertainty_deg = 0.5;
};

struct PointingResult {
  Vec3 direction = Vec3::UnitX();  // in the sensor's frame, unit
  Vec3 place_mm = Vec3::Zero();    // in the tracker's
  int poses = 0;
  double cone_deg = 0, residual_deg = 0;
  double uncertainty_deg = 0;  // of the direction, one standard deviation, if errors were independent
  bool accepted = false;
  std::string advice;  // when refused: what is wrong and what to do
};

/// `tip_mm`: in the sensor's frame. `first`: the direction that is known so far, within some 60 degrees of the truth.
PointingResult calibrate_pointing(const std::vector<SensorPose>& poses, const Vec3& tip_mm,
                                  const Vec3& first = Vec3::UnitX(), const PointingLimits& limits = {});

}  // namespace limberg
