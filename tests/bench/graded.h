#pragma once
// `limberg bench graded`: lattices that are fine where it matters, against uniform ones.
//
//   patch      1.5 mm of skin on fat, a patch of 6 x 6 mm of it pulled along and upwards (sheet_lattice.h; the cases of
//              `bench verification`). Error against CalculiX, and against the uniform lattice of the same small cells;
//              time: full Newton to equilibrium. Beside it what the program's own solver takes: ms of a step
//              of 10 iterations, and iterations until a hook that has pulled the patch by 4 mm is at rest
//   rhomboid   the shipped scene and script, whole: closure force, largest stitch, dog-ear and stress of skin against
//              uniform cells of 1.75 mm; time: CPU of the whole operation. Beside it the median and the longest live
//              step of 10 iterations after each action
//
// The rhomboid's reference is no limit: its closure force goes on falling with the cells at the wound. What is
// shown is whether a graded lattice gives what the uniform one of its small cells gives, and for how much.
//
// A row says its nodes. Notes name, for each graded lattice, the uniform ones that it is ahead of (a smaller error at
// no more nodes, or in no more time) and those that it is behind.
#include <functional>
#include <string>

#include "app/operating_point/bench.h"

namespace limberg::bench {

struct GradedSettings {
  bool quick = false;  // coarse lattices only
  std::string only;    // a part
  std::function<void(const std::string&)> progress;
};

Result graded(const GradedSettings& settings);

}  // namespace limberg::bench
