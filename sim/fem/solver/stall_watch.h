#pragma once
// Whether iterations still gain anything: a minimiser that stalls says so, instead of going on to its last iteration.
//
// Two ways to see it. StallWatch: so many iterations have not made the residual a tenth less; this takes patience,
// because a flap that swings gains nothing for long. LevelWatch: for so many iterates in a row the energies before and
// after could not be told apart in single precision, and the residual has not become a tenth less either. Then it is
// worth one evaluation to ask whether the forces are down to what the last bits of the displacements make of them
// (LbfgsSolver::at_floor).
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

/// Outlives the step: sessions and operations take 10 to 20 iterations at a time. Anew whenever the solver is given
/// anything.
class LevelWatch {
 public:
  static constexpr int kLevel = 60;

  bool at_floor = false;  // a suspicion was right

  /// After each iterate. `level`: its energy and the one before were within each other's noise. True once for every
  /// kLevel of them in a row without a tenth off the least residual so far.
  bool suspects(double residual, bool level) {
    const bool gains = residual < StallWatch::kGain * least_;
    if (gains) least_ = residual;
    level_ = level && !gains ? level_ + 1 : 0;
    if (level_ < kLevel) return false;
    level_ = 0;
    return true;
  }

 private:
  double least_ = std::numeric_limits<double>::infinity();
  int level_ = 0;
};

}  // namespace limberg::fem
