#pragma once
// `operate --error 5%`: cells get smaller until the lattice's share of the error of each figure is below so much of it.
//
// The sizes are the scene's times sqrt 2, then the scene's own, then smaller ones by sqrt 2 each. From three sizes on
// the estimates of extrapolation.h are asked. It ends when all figures are there, when the next size would take longer
// than is allowed (as much longer than the last as that took longer than the one before), or after kMostSizes.
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "app/result/discretisation.h"

namespace limberg {

inline constexpr int kMostSizes = 7;
/// A length is also good enough within so many mm: less than a picture of a wound shows.
inline constexpr double kGoodLength_mm = 0.1;

struct GoalRow {
  std::string name;
  double value = 0, error = 0, allowed = 0;  // in the figure's unit
  bool met() const { return error <= allowed; }
};

class ErrorGoal {
 public:
  /// `share`: 0.05 for 5 %. `scene_cell_mm`: the scene's own size.
  ErrorGoal(double share, double scene_cell_mm, double limit_s)
      : share_(share), next_mm_(scene_cell_mm * 1.4142135623730951), limit_s_(limit_s) {}
  double next_mm() const { return next_mm_; }
  /// After a run at next_mm() that took `solve_s`, with the figures of all runs so far. False: it was the last.
  bool go_on(std::span<const SizedFigures> runs, double solve_s);
  /// Of the figures that matter and that every run has.
  const std::vector<GoalRow>& rows() const { return rows_; }
  bool met() const;
  const std::string& why() const { return why_; }  // it ended

 private:
  double share_, next_mm_, limit_s_;
  std::vector<double> took_s_;
  std::vector<GoalRow> rows_;
  std::string why_;
};

/// "5%", "5 %" or "0.05" as 0.05; nothing if it is none from 0.1 % to 100 %.
std::optional<double> parse_share(const std::string& text);

}  // namespace limberg
