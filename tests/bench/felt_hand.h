#pragma once
// A simulated hand with a force device on a patient, on a virtual clock, and what
// must be watched of it: the energy that it gets from the loop of device, solver
// and stiffness (none, of a passive loop), and the steps and sizes of the force.
//
//   FeltHand felt(hand, front, line);
//   for (int tick = 1; tick < end; ++tick) {
//     device.tick(tick), felt.watch();
//     if (tick % ticks_per_step == 0) solver.step(tick);
//   }
#include <algorithm>
#include <memory>

#include "devices/force/force_source.h"
#include "devices/front_end.h"

namespace limberg {

class FeltHand {
 public:
  /// Becomes a source of `front`, which must outlive it. `line`: to a patient that tells its stiffness; null: none.
  FeltHand(const SimulatedHand& hand, DeviceFrontEnd& front, std::shared_ptr<StiffnessLine> line) {
    auto made = std::make_unique<SimulatedForceDevice>(hand);
    tool_ = made.get();
    auto source = std::make_unique<ForceSource>(std::move(made), ForceSourceSettings{}, std::move(line));
    force_ = source.get();
    front.add(std::move(source));
    x_mm_ = tool_->true_mm();
  }

  /// After every tick of the device.
  void watch() {
    const Vec3 now = force_->loop().state().force_N;
    energy_mJ -= force_N_.dot(tool_->true_mm() - x_mm_);  // N mm = mJ; what the hand has put in
    least_mJ = std::min(least_mJ, energy_mJ);
    largest_step_N = std::max(largest_step_N, (now - force_N_).norm());
    largest_N = std::max(largest_N, now.norm());
    x_mm_ = tool_->true_mm(), force_N_ = now;
    if (!force_->loop().state().touching) return;
    softest_N_mm = std::min(softest_N_mm, force_->model().stiffness_N_mm);
    hardest_N_mm = std::max(hardest_N_mm, force_->model().stiffness_N_mm);
  }

  const SimulatedForceDevice& tool() const { return *tool_; }
  const ForceSource& force() const { return *force_; }

  double energy_mJ = 0, least_mJ = 0, largest_step_N = 0, largest_N = 0;
  double softest_N_mm = 1e9, hardest_N_mm = 0;  // while it touches

 private:
  const SimulatedForceDevice* tool_;
  const ForceSource* force_;
  Vec3 x_mm_ = Vec3::Zero(), force_N_ = Vec3::Zero();
};

}  // namespace limberg
