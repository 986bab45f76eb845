#include "app/commands/auto_option.h"

#include <CLI/CLI.hpp>
#include <cstdio>

#include "app/commands/numbers.h"
#include "app/result/progress.h"

namespace limberg {

void AutoOption::add(CLI::App& c) {
  CLI::Option* flag = c.add_flag(
      "--auto", on, "Measure first which cell size and iterations fit a frame on this machine, and work with them");
  c.add_option("--budget-ms", budget_ms, "With --auto: time of a frame (default: half the scene's step)")
      ->type_name("MS")
      ->check(number_from(0.001, 1e5))
      ->needs(flag);
  c.add_option("--operating-point", file, "Instead of measuring: the result.json of limberg bench accuracy")
      ->type_name("FILE");
}

std::optional<bench::OperatingPoint> AutoOption::apply(Scene& scene) const {
  if (!on && file.empty()) return {};
  bench::OperatingPoint p;
  if (!file.empty()) {
    p = read_operating_point(file, scene);
  } else {
    Progress progress("calibration");
    bench::AccuracySettings s;
    s.quick = true, s.budget_ms = budget_ms, s.limit_s = 20;
    s.progress = [&](const std::string& line) { progress.note(line); };
    p = bench::accuracy(scene, s).point;
  }
  if (p.iterations <= 0) return {};
  scene = at_operating_point(scene, p.cell_mm, p.iterations);
  std::printf("auto        cells of %.3g mm, %d iterations a step: %.2f ms of %.2f ms, error %.2f mm%s\n", p.cell_mm,
              p.iterations, p.frame_ms, p.budget_ms, p.error_mm,
              p.fits ? "" : "; nothing fits the budget, this is the fastest");
  return p;
}

}  // namespace limberg
