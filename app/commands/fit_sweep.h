#pragma once
// `limberg fit --sweep`: the same surface fitted with faces of several sizes, uniform and adapted to curvature, to see
// what vertices and run time buy.
#include <functional>
#include <string>
#include <vector>

#include "app/report/svg_chart.h"
#include "sim/imaging/fit/fit.h"

namespace limberg {

struct FitTrial {
  bool adapted = false;
  double edge_mm = 0, chord_mm = 0;  // chord_mm 0: uniform
  double cpu_s = 0;                  // of the fit, without the preparation
  FitReport report;
};

struct FitSweep {
  static constexpr int kTrials = 10;
  std::vector<FitTrial> trial;
  std::string csv() const;
  /// Distance of the surface to the mesh against run time, or against vertices: both kinds of faces.
  LineChart chart(bool time) const;
};

/// Ends early, with what was finished, when `stopped`. `like`: everything but edges, chord and progress.
FitSweep fit_sweep(const Prepared& target, const FitSettings& like, Workers& workers,
                   const std::function<void(const std::string&)>& progress, const std::function<bool()>& stopped);

}  // namespace limberg
