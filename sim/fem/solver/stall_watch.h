#pragma once
// Whether iterations still gain anything: a minimiser that stalls says so, instead of going on to its last iteration.
#include <limits>

namespace limberg::fem {

class StallWatch {
 public:
  // So many iterations without a tenth off the least residual so far. Between two tenths the rhomboid and the Z-plasty
  // at 5, 3.5 and 2.5 mm and the rhomboid on the cheek take up to 900 and come to rest (2026-11-24): a flap swings.
  static constexpr int kIterations = 2000;
  static constexpr double kGain = 0.9;

  /// After so many more iterations. True from the look on at which it stalls, until a residual is a tenth less.
  bool look(double residual, int iterations) {
    since_ += iterations;
    if (residual < kGain * least_) least_ = residual, since_ = 0;
    return since_ >= kIterations;
  }
  double least() const { return least_; }

 private:
  double least_ = std::numeric_limits<double>::infinity();
  int since_ = 0;
};

}  // namespace limberg::fem
