#pragma once
// A device that is held, says where it is and pushes back. Makers' libraries stand behind this door; here is one made
// of equations: a mass in a hand, for tests and for work without a device.
#include <cstdint>
#include <functional>

#include "devices/force/force_loop.h"

namespace limberg {

struct ForceReading {
  bool valid = false;
  Vec3 tip_mm = Vec3::Zero();
  std::array<double, 4> quat{1, 0, 0, 0};
  uint32_t buttons = 0;
};

/// Both calls are made on the device thread, once per tick, and return at once.
class ForceDevice {
 public:
  virtual ~ForceDevice() = default;
  virtual ForceReading read(int64_t now_ns) = 0;
  virtual void push(const Vec3& force_N) = 0;
  virtual ForceLimits limits() const { return {}; }
  virtual const char* name() const = 0;
};

/// m x'' = F + k_hand (target - x) + b_hand (target' - x'), semi-implicit steps of
/// 0.1 ms; places are read in steps of the encoder. The force holds between pushes,
/// as a device's does: through a stall too, unless its own watchdog ends it.
struct SimulatedHand {
  double mass_kg = 0.15;          // of the device's end and of the hand that moves with it
  double stiffness_N_mm = 0.3;    // of the hand that wants to be at its target
  double damping_N_s_mm = 0.005;  // a relaxed grip; 0.0134 would be critical
  double encoder_mm = 0.01;
  double force_N = 3.3;          // what its motors give
  Vec3 weight_N = Vec3::Zero();  // a steady force beside
  std::function<Vec3(double t_s)> target = [](double) { return Vec3(0, 0, 20); };
  std::function<bool(double t_s)> pressed = [](double) { return false; };
};

class SimulatedForceDevice final : public ForceDevice {
 public:
  explicit SimulatedForceDevice(SimulatedHand hand);
  ForceReading read(int64_t now_ns) override;
  void push(const Vec3& force_N) override;
  const char* name() const override { return "simulated force device"; }
  const Vec3& true_mm() const { return x_; }
  const Vec3& velocity_mm_s() const { return v_; }

 private:
  SimulatedHand hand_;
  int64_t t_ns_ = 0;
  bool started_ = false;
  Vec3 x_ = Vec3::Zero(), v_ = Vec3::Zero(), force_ = Vec3::Zero();
};

}  // namespace limberg
