#pragma once
// `limberg superpose A B C ... --average FILE`: the mean of several surfaces, to lay others upon.
#include <optional>
#include <string>
#include <vector>

#include "app/result/result.h"
#include "app/result/schema.h"
#include "sim/base/workers.h"
#include "sim/imaging/register/average_surface.h"

namespace limberg {

/// average/surfaces: how far the mean lies from each. scale: how many times as large it was made.
struct ResultAveraged {
  std::string file;
  double rms_mm, p95_mm, reached, scale;
};
void fields(ResultAveraged& x, auto&& f) {
  f("file", x.file), f("rms_mm", x.rms_mm), f("p95_mm", x.p95_mm), f("reached", x.reached), f("scale", x.scale);
}
/// average: spread is the standard deviation at vertices. still: the mean stood still. half: the share of its vertices
/// that half of the surfaces or more have.
struct ResultAverage {
  std::string file;
  MaybeCount vertices, rounds;
  MaybeFlag still;
  double spread_mean_mm, spread_p95_mm, spread_max_mm, half;
  std::vector<ResultAveraged> surfaces;
};
void fields(ResultAverage& x, auto&& f) {
  f("file", x.file), f("vertices", x.vertices), f("rounds", x.rounds), f("still", x.still);
  f("spread_mean_mm", x.spread_mean_mm), f("spread_p95_mm", x.spread_p95_mm), f("spread_max_mm", x.spread_max_mm);
  f("half", x.half), f("surfaces", x.surfaces);
}

/// Of the surfaces that these files hold. Writes `to` (.obj, .ply or .stl by its name), says what it is on standard
/// output and in a table of the page, and with `out_dir` spread.csv (x_mm, y_mm, z_mm, spread_mm) there. Nothing,
/// with `reason`: there is no mean. Throws InputError where `to` cannot be written.
std::optional<ResultAverage> average_files(const std::vector<std::string>& files, const std::vector<Surface>& surfaces,
                                           const std::string& to, const AverageSettings& settings,
                                           const std::string& out_dir, Result& result, Workers& workers,
                                           std::string& reason);

}  // namespace limberg
