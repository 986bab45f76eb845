#pragma once
// Whether the metric is far softer than the material has become, everywhere.
//
// The metric is the stiffness at rest. Collagen that is drawn out is a hundred times stiffer, in every cell at once, so
// that no short list of directions (stretched_cells.h) holds what is lacking. Along all directions that no pair of the
// history tells of, steps are then far too long: the line search cuts every one of them to a tenth or a hundredth, and
// the few iterates between two updates of the multipliers solve nothing for those that are given, so that updates and
// iterates chase each other in a circle (a cube of 12 mm of one fibre family, nu .499, sides pulled to 1.5 by springs:
// residual .1 after 3,000 iterations, where the plain energy takes 277; 2026-11-25).
//
// When the full step has been refused so many times in a row, the metric's inverse is scaled by the newest pair
// (LbfgsHistory::direction): the same cube rests after some 200 iterations. It ends when the pairs say that the metric
// is about right, as many times in a row.
//
// Only for cells with material points. What K and lambda give is quadratic, or nearly, and where it is not,
// stretched_cells.h mends the few directions in question; a scale of everything would take the rest with them.

namespace limberg::fem {

class MetricScale {
 public:
  static constexpr int kInARow = 8;
  static constexpr double kAboutRight = 0.5;

  bool on() const { return on_; }
  /// An iterate was accepted: `cut`: not at the full step; `gamma`: what its direction was scaled by.
  void accepted(bool cut, double gamma) {
    const bool speaks = on_ ? gamma >= kAboutRight : cut;
    row_ = speaks ? row_ + 1 : 0;
    if (row_ >= kInARow) on_ = !on_, row_ = 0;
  }
  void forget() { on_ = false, row_ = 0; }

 private:
  bool on_ = false;
  int row_ = 0;
};

}  // namespace limberg::fem
