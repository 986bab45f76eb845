#pragma once
// The lattice's share of the error of every figure, from the same operation at several cell sizes.
//
// result.json: discretisation/NAME {value, error, order, extrapolated, asymptotic, says}; NAME as in `metrics`
// (sim/measure/extrapolation.h says how; what is unknown is absent).
#include <span>
#include <string>
#include <vector>

#include "app/result/result.h"
#include "sim/measure/extrapolation.h"
#include "sim/measure/metrics.h"

namespace limberg {

/// One run: the size of its cells (cube root of their volume: boxes are fitted) and what it came to.
struct SizedFigures {
  double cell_mm = 0;
  Metrics figures;
  double distance_mm = 0;  // estimated, to equilibrium: lengths cannot be trusted beyond it
};

struct FigureError {
  std::string name;
  Extrapolation estimate;
};

/// Figures that every run has; in the order of the report. Empty with fewer than two runs.
std::vector<FigureError> discretisation_errors(std::span<const SizedFigures> runs);
void fill_discretisation(Result& result, std::span<const FigureError> errors);

}  // namespace limberg
