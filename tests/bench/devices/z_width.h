#pragma once
// Which stiffness a force device holds: the force loop against a device whose line delays, rounds and loses, without a
// hand that would calm it. A mass falls onto a wall of stated stiffness and stays there, or trembles, or is thrown off.
//
// Beside it stand two bounds of the literature, for a wall K with damping B, sampled at T, on a device of damping b:
//   passive, whatever hand holds it    b > K T / 2 + |B|                 Colgate and Schenkel, J. Robotic Systems 14
//                                                                        (1997) 37
//   stable, with nobody holding it     K < (b + B) / (T / 2 + delay)     stable_stiffness_N_mm(), force_loop.h
#include <cstdint>
#include <vector>

#include "devices/force/force_device.h"

namespace limberg::bench {

/// What lies between a loop and its device.
struct LinkFaults {
  int reading_late = 0, force_late = 0;  // ticks
  double encoder_mm = 0;
  double lost = 0;   // share of the ticks at which a loss of readings begins; the last reading is repeated meanwhile
  int lost_for = 5;  // ticks
  uint64_t seed = 1;
};

/// A device behind such a line.
class FaultyDevice final : public ForceDevice {
 public:
  FaultyDevice(const SimulatedHand& hand, const LinkFaults& faults);
  ForceReading read(int64_t now_ns) override;
  void push(const Vec3& force_N) override;
  const char* name() const override { return "simulated force device behind a bad line"; }
  const SimulatedForceDevice& device() const { return device_; }
  /// What its motors give since the last push.
  const Vec3& applied_N() const { return applied_; }

 private:
  static SimulatedHand exact(SimulatedHand hand) { return hand.encoder_mm = 0, hand; }
  LinkFaults faults_;
  SimulatedForceDevice device_;
  std::vector<ForceReading> readings_;
  std::vector<Vec3> forces_;
  size_t tick_ = 0;
  int losing_ = 0;
  uint64_t dice_;
  ForceReading last_;
  Vec3 applied_ = Vec3::Zero();
};

struct WallTrial {
  LinkFaults faults;
  double wall_N_mm = 1, damping_N_s_mm = 0;  // K and B
  double device_damping_N_s_mm = 0.001;      // b
  double mass_kg = 0.15, press_N = 0.5;
  bool passivity = true;   // observer and damper on
  bool told_delay = true;  // the loop knows how late what it sees is
  double seconds = 6;
};

struct WallFigures {
  double least_energy_mJ = 0;              // that the hand has put in, net, by the true place and the applied force
  double tremble_mm_s = 0;                 // RMS of the speed in the last third
  double first_mm_s = 0, before_mm_s = 0;  // the same in the thirds before
  bool stable = false;                     // it calms down, or trembles by less than an encoder's step in two ticks
  int64_t damped = 0;
};
WallFigures wall_trial(const WallTrial& trial);

/// The stiffness up to which all are held, from soft to hard in steps of 8 %, N/mm.
double stiffness_held(WallTrial trial, double most_N_mm = 20);

inline double passive_bound_N_mm(double b, double B, double tick_s = 1e-3) { return b > B ? 2 * (b - B) / tick_s : 0; }

}  // namespace limberg::bench
