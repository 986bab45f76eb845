#include "sim/measure/patient.h"

#include "sim/commands/strokes.h"
#include "sim/patient/soft_tissue.h"

namespace limberg {

Metrics measure_world(const World& world, std::span<const Command> script, MeasureAlso also) {
  const SoftTissue& tissue = *world.skin();
  Snapshot s;
  tissue.fill(s);
  also.closure_energy_uJ = tissue.closure_energy_uJ();
  also.one_bank = tissue.stitches_in_one_bank();
  also.collider_force_mN = tissue.collider_force_mN();
  also.soft_hold_force_mN = tissue.soft_hold_force_mN();
  return measure(s, Skin(tissue.spec().body), tissue.solver(),
                 {tissue.pieces(), tissue.volume_mm3(), tissue.removed_volume_mm3(), tissue.initial_volume_mm3()},
                 join_strokes(script), also);
}

}  // namespace limberg
