#pragma once
// `limberg bench graded`: lattices that are fine where it matters, against uniform ones.
//
//   patch      1.5 mm of skin on fat, a patch of 6 x 6 mm of it pulled along and upwards (sheet_lattice.h; the cases of
//              `bench verification`). Error against CalculiX; time: full Newton to equilibrium. Beside it what the
//              program's own solver takes: milliseconds of a step of 10 iterations, and iterations until a hook that
//              has pulled the patch by 4 mm is at rest
//   rhomboid   the shipped scene and script, whole: closure force, largest stitch, dog-ear and the skin's stress against
//              the finest lattice; time: CPU of the whole operation. Beside it the median and the longest live step of
//              10 iterations after each action
//
// A row says its nodes. Notes name, for each graded lattice, the uniform ones that are not better at no less time or no
// fewer nodes, and where uniform wins.
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
