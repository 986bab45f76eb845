#pragma once
// `limberg bench devices --only felt`: a simulated force device against the patient
// of a scene, both on one virtual clock: what the hand feels with the stiffness that
// the solver gives and with that of a half space, and what asking costs the solver.
#include <functional>
#include <string>

#include "app/operating_point/bench.h"
#include "app/scene/scene.h"

namespace limberg::bench {

void add_felt_patient(Result& out, const Scene& scene, bool quick,
                      const std::function<void(const std::string&)>& progress);

}  // namespace limberg::bench
