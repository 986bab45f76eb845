#pragma once
// `limberg bench accuracy SCENE`: error against run time on the scene itself.
//
// The trial (accuracy_probe.h): an incision of 40 mm through the scene's skin, where the scene can be cut; a hook on
// its lip pulled 6 mm up and 6 mm aside in 24 frames (21 mm/s at 60 Hz). What the surgeon sees in the last frame
// is compared, at the skin 5 to 40 mm from the hook, with the equilibrium of a finer lattice than any in the
// sweep: the error holds what the lattice does, and how far the minimiser is behind. Time is CPU time of a frame,
// median and 95th percentile.
//
// Swept: cell size, iterations of a frame, element (the scenes' selective reduced hexahedron; full integration; twelve
// linear tetrahedra in each cell), material (the scene's; Poisson's ratios of .49 and .499; Mooney-Rivlin), and step
// (quasi-static; backward Euler once or twice a frame). Not every combination: cell x iterations x step with the
// scene's material and element, the others beside the scene's cell size. Settings on the Pareto front are marked: no
// other is faster and closer at once. Among those with the scene's material, element and kind of step, the operating
// point is the one with the least error (within 5 %: with the most iterations) whose 95th percentile fits the budget.
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "app/operating_point/bench.h"
#include "app/scene/scene.h"

namespace limberg::bench {

struct AccuracySettings {
  bool quick = false;  // cells and iterations of the scene's own kind only: what `run --auto` measures before it begins
  double budget_ms = 0;  // of a frame; 0: half the scene's step interval, which leaves the rest to the other threads
  double limit_s = 150;  // CPU time after which no new trial begins
  // Not empty: finished trials are kept in this file, one line each, and those that it has of the same scene
  // are not run again. So a sweep that was stopped goes on.
  std::string keep_file;
  std::function<void(const std::string&)> progress;
  std::function<bool()> interrupted;
};

struct AccuracyTrial {
  double cell_mm = 0;  // as asked for
  size_t nodes = 0;
  std::string element = "hexahedra", material = "scene", step = "quasi-static";
  int iterations = 0;  // of a frame
  double frame_ms = 0, frame_p95_ms = 0;
  double error_mm = 0, error_max_mm = 0;  // root mean square and largest, against the fine equilibrium
  double lattice_mm = 0;                  // the part that stays at rest: own equilibrium against the fine one
  double behind_mm = 0;                   // the rest: this frame against its own equilibrium
  bool own_kind = true;                   // the scene's material, element and kind of step
  bool pareto = false, chosen = false;
};

struct OperatingPoint {
  double cell_mm = 0;
  int iterations = 0;
  double frame_ms = 0, error_mm = 0, budget_ms = 0;
  uint64_t scene_hash = 0;
  bool fits = false;  // false: nothing does; this is the fastest
};

struct AccuracyReport {
  std::string scene;
  double reference_cell_mm = 0, budget_ms = 0, cpu_s = 0;
  std::vector<AccuracyTrial> trials;
  size_t left_out = 0;  // the time was up
  size_t kept = 0;      // of the trials: from the file of an earlier run
  OperatingPoint point;
  Result result() const;
  std::string csv() const;
  std::string svg() const;
};

AccuracyReport accuracy(const Scene& scene, const AccuracySettings& settings);

}  // namespace limberg::bench
