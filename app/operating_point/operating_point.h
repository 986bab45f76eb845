#pragma once
// The setting that `run --auto` and `replay --auto` work with:
// cell size and iterations of a step that fit the time of a frame.
//
// It is measured in a short calibration before the session begins (`bench accuracy --quick` on the scene,
// some seconds), because it belongs to the machine as much as to the scene; or taken from the result.json
// of a `bench accuracy` of the same scene (--operating-point). The session then runs a scene whose text
// says so, and that text goes into its recording: what was recorded replays without knowing of this.
#include <string>

#include "app/operating_point/accuracy.h"
#include "app/result/result.h"

namespace limberg {

/// The scene with other cells and iterations: its values changed in these two places, written out and read anew.
Scene at_operating_point(const Scene& scene, double cell_mm, int iterations);

void fill_operating_point(Result& result, const bench::OperatingPoint& point);
/// InputError when the file is no result of `bench accuracy`, or of another scene.
bench::OperatingPoint read_operating_point(const std::string& file, const Scene& scene);

}  // namespace limberg
