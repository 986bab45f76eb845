#pragma once
// The field of an electromagnetic tracker bends near metal. Where positions are known, what must be added to the
// readings can be fitted: values on a regular grid, trilinear between its nodes, least squares against the known points
// plus a price on bends between nodes (second differences), which carries the correction into cells without points.
// Every fifth point is held out: a correction that does not halve the error there is refused.
#include <string>
#include <vector>

#include "calibration/calibration.h"

namespace limberg {

struct DistortionSettings {
  int nodes = 5;            // along each side
  double smoothing = 0.02;  // price of a bend of 1 mm between nodes, in points that are 1 mm off
  int points = 40;          // needed
  double gain = 2;          // the error at held-out points must fall by this factor
};

struct DistortionResult {
  DistortionGrid grid;
  double before_mm = 0, after_mm = 0;  // RMS at the held-out points
  double fitted_mm = 0;                // RMS at the others, after
  bool accepted = false;
  std::string advice;
};

/// `measured` and `known` in the tracker's frame.
DistortionResult calibrate_distortion(const std::vector<Vec3>& measured, const std::vector<Vec3>& known,
                                      const DistortionSettings& settings = {});

}  // namespace limberg
