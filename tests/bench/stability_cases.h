#pragma once
// The cases of `bench stability`: plain data, made anew on every call.
#include <memory>
#include <string>
#include <vector>

#include "sim/fem/solver/elastic_solver.h"

namespace limberg::bench {

struct StabilityCase {
  std::string family, name;
  std::shared_ptr<const FemModel> model;
  std::vector<Vec3f> start;      // displacements to begin with; empty: at rest
  std::vector<Spring> load;      // while disturbed; released afterwards
  std::vector<Spring> teleport;  // when not empty: takes the place of `load` after one step
  int hold_steps = 0;            // steps under load
  int ramp_steps = 0;            // of these, over which the first spring's target moves from where the spring begins
  bool must_reach = false;       // under load the residual must fall below 1e-3 and sutures must close to 0.05 mm
  double dt_s = 0;               // 0: quasi-static
  double damping_per_s = 0;
  bool floating = false;                  // nothing holds it: rest up to a rigid motion
  bool one_material = true;               // what Bullet's body can be: cells of one tissue, none of them a sliver
  double young_kPa = 60, poisson = 0.45;  // of it
  bool has_laws = false;                  // carries material points (a peer's linear corotated law would replace them)
  Vec3 throw_mm_per_s = Vec3::Zero();     // dynamic: initial velocity, by a first displaced step
  double length_mm = 60;
};

std::vector<StabilityCase> stability_cases(bool one_per_family);

/// Thin skin over fat that share a row of cells, the skin so many times as stiff; sides held.
FemModel shared_cell_block(double contrast);

/// The same model with every stencil replaced by the linear corotated law of the same constants.
std::shared_ptr<const FemModel> corotated_twin(const FemModel& model);

}  // namespace limberg::bench
