#pragma once
// What is kept of an operation while it goes on: the patient at its stages, and figures of its solver steps.
#include <string>
#include <vector>

#include "sim/commands/command.h"
#include "sim/patient/snapshot.h"

namespace limberg {

/// A row of the report: the patient when a stage was passed.
struct StageRow {
  int32_t number = 0;  // from 1
  std::string name;
  double t_s = 0;
  Snapshot shown;            // for its picture; made and freed by the solver lane's owner
  std::vector<Command> pen;  // what the pen and the swab had done by then
};

struct SolverSeries {
  std::vector<float> t_s, residual, distance_mm;
  std::vector<float> closure_N, suture_max_N;  // all stitches together, and the largest
  void reserve(size_t n) {
    t_s.reserve(n), residual.reserve(n), distance_mm.reserve(n), closure_N.reserve(n), suture_max_N.reserve(n);
  }
};

}  // namespace limberg
