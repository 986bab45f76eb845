#pragma once
// Where the tracker stands in the world: points touched with the stylus against where they are known to be.
//
// The rigid motion of least squares (Umeyama 1991 without scale; Horn 1987), by the singular value decomposition of the
// points' covariance, reflections excluded. The residual at the fitted points says little: it falls when points are
// fewer while the error elsewhere rises. So the last touched point is not fitted; the error there is the gate.
#include <string>
#include <vector>

#include "sim/geometry/vec.h"

namespace limberg {

struct RegistrationLimits {
  int points = 4;  // fitted ones; the held-out one comes on top
  double held_out_mm = 2.0;
  double residual_mm = 2.0;  // RMS at the fitted points
  double spread_mm = 15.0;   // of the points along the second of their principal directions: RMS
};

struct WorldRegistration {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();  // world from tracker
  Vec3 translation_mm = Vec3::Zero();
  double residual_mm = 0, held_out_mm = 0, spread_mm = 0;
  double scale = 1;  // that would fit better: far from 1 means wrong units or a wrong list
  bool accepted = false;
  std::string advice;
};

/// `touched` in the tracker's frame, `known` in the world, in the same order; the last pair is held out.
WorldRegistration calibrate_world(const std::vector<Vec3>& touched, const std::vector<Vec3>& known,
                                  const RegistrationLimits& limits = {});

}  // namespace limberg
