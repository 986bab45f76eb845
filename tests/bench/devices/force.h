#pragma once
// A hand that presses a simulated force device into a tissue whose law is known,
// with a solver that sees it at its own rate and answers a period later: energy
// and steps of the force, for the loop that is used here and for the naive ones.
#include <cstdint>

namespace limberg::bench {

enum class ForceMethod {
  local,    // devices/force: contact on every tick, secant stiffness cross-faded, limits
  hold,     // the solver's last force is held
  tangent,  // force and tangent of the last step, contact as it was then
};

struct ForceTrial {
  ForceMethod method = ForceMethod::local;
  double stiffness_N_mm = 0.5;  // of the tissue at no depth
  double stiffening = 0;        // per mm of depth: f = k d (1 + s d)
  double solver_hz = 60;
  double seconds = 10;
  double stall_s = 0;      // the loop stops once, so long, in the middle of contact
  double stall_at_s = -1;  // -1: half way
  bool stalls = true;      // false: the same time is watched, and the loop goes on
  bool limits = true;      // local: slew limit and passivity damper on
};

struct ForceFigures {
  double least_energy_mJ = 0;   // of what the hand put in, net: below zero is energy made by the loop
  double largest_step_N = 0;    // from tick to tick
  double after_stall_mm_s = 0;  // the fastest that the hand moved in the 100 ms after the stall
  double before_stall_mm_s = 0;
  double force_N = 0;  // the largest
  int64_t damped = 0, slewed = 0, stalls = 0;
  double ns_per_tick = 0;
};

ForceFigures force_trial(const ForceTrial& trial);

/// What a stall does to the hand, over one period of its tapping: the worst moment. A
/// force that is held lets the hand go the way that it would without tissue; so it may
/// be as fast afterwards as the same hand in free air, and a kick is what is more.
struct StallFigures {
  double stalled_mm_s = 0,
         calm_mm_s = 0;  // the fastest in the 100 ms after it; the same hand at that moment without a stall
  double free_mm_s = 0;  // in free air, whatever the moment
  double energy_mJ = 0, largest_step_N = 0;
};
StallFigures stall_trials(double stiffness_N_mm, double stall_s, int moments = 12);

}  // namespace limberg::bench
