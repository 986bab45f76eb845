#pragma once
// Forces for a hand that holds a force device, a thousand times a second.
//
// The solver is too slow for a hand: at 60 Hz a held force drives the device (it gives energy back
// that it never got). So it only says what changes slowly, in a ForceModel: the surface near the
// tool as it would be without the tool, how stiff the tissue is, where a hook's tissue would rest.
// Everything that decides whether there is a force, and how large, is done here on every tick:
//
//   contact    the tip against that surface; a place of the surface, the proxy,
//              follows the tip along it within the friction cone (Zilles and Salisbury
//              1995; Ruspini 1997), force = secant stiffness times (proxy - tip)
//   stiffness  goes from the model's last value to its new one over a period of the
//              solver: the force never steps; a secant and not a tangent, so that a
//              stiffening tissue does not push harder on the way out than on the way in
//   coupling   the device sees the tissue through a spring of the largest stiffness that it holds stably, and a damper
//              (Colgate 1995; Adams and Hannaford 1999)
//   cutting    the force rises to what punctures the skin, breaks, and drops to what going deeper takes; along the
//              surface the tool is held back by what parting the tissue takes (tool_feel.h)
//   thread     is drawn out of its hole against friction, and slack when the hand comes back
//   passivity  the energy that went into the hand is counted, each way by the force that was on the hand then, which is
//              an older one where the line is slow; when more than came out of it would go, a damper takes it
//              (Hannaford and Ryu 2002)
//   limits     of force and of change per tick; a ramp at the start; none when the model is old (decays) or the device
//              is not read
//   stalls     whoever stops this loop (a virtual machine's host does,
//              for tens of ms) leaves the last force on the hand
//              meanwhile, and the hand moves. Where it is then,
//              another force is due. Both a jump there and a new start
//              from nothing would throw it: what is due and what was
//              held differ by so much, and that fades. A hand that has
//              left the surface is let go of at once, as fast as the
//              force may change. After a stall in which the model
//              would have faded, the force begins anew from nothing
//
// Nothing allocates. No clock: times are handed in.
#include <array>
#include <cstdint>

#include "sim/geometry/vec.h"

namespace limberg {

/// What the solver says, at its own rate. Fixed size; passed by value.
struct ForceModel {
  static constexpr int kFacets = 64;
  int64_t seq = 0, t_ns = -1;  // counts models; when its positions were true
  int64_t period_ns = 16'000'000;
  int facets = 0;  // outward, of the surface near the tool
  std::array<std::array<Vec3, 3>, kFacets> facet;
  double stiffness_N_mm = 0;  // secant: force over depth, at the depth that the tool has
  double friction = 0.2;
  double puncture_N = 0;  // 0: the tool does not cut
  double cutting_N = 0;
  bool presses = false;              // what has cut in is engaged
  double draw_N = 0, draw_N_mm = 0;  // holds a tool that has cut in back along the surface; more by depth (tool_feel.h)
  bool drawn = false;                // whether it has cut in or not
  double thread_N = 0;               // the drag of a thread; 0: there is none
  double thread_friction = 0;
  Vec3 thread_from_mm = Vec3::Zero(), thread_normal = Vec3::UnitZ();  // the hole out of which it is drawn
  bool hooked = false;
  Vec3 hook_home_mm = Vec3::Zero();  // where the hooked tissue would pull the hook to, so that there was no force
  double hook_stiffness_N_mm = 0;    // secant
};

/// What a device can do.
struct ForceLimits {
  double force_N = 3.3;            // peak
  double slew_N = 0.2;             // per tick of 1 ms; less in a shorter one
  double stiffness_N_mm = 2.0;     // that it holds stably in a hand
  double damping_N_s_mm = 0.0015;  // of the coupling; on the speed below some 40 Hz
  double ramp_s = 0.5;
  double stale_periods = 2, decay_s = 0.05;
  double stall_s = 0.004;             // a longer tick is a stall
  double catch_up_s = 0.1;            // a force that was held over a stall fades so; slow beside a hand's swing, 20 ms
  double delay_s = 0;                 // from a force to the reading of what it did, beyond the next tick; to 30 ms
  double spare_mJ = 0.1;              // energy that may be missing before the damper acts
  double most_damping_N_s_mm = 0.02;  // of the passivity damper: below 2 m / T for the lightest device, 50 g
};

/// The stiffest wall that a device of that damping holds by itself, nobody's hand on it: K < (b + B) / (T / 2 + delay),
/// B the damping of the wall, T the time of a tick (Gil, Sanchez, Hulin, Preusche and Hirzinger, J. Dyn. Sys. Meas.
/// Control 131 (2009) 011005; without delay Colgate and Schenkel, J. Robotic Systems 14 (1997) 37). N/mm.
inline double stable_stiffness_N_mm(double device_N_s_mm, double wall_N_s_mm, double delay_s, double tick_s = 1e-3) {
  return (device_N_s_mm + wall_N_s_mm) / (tick_s / 2 + delay_s);
}

struct ForceState {
  Vec3 force_N = Vec3::Zero();
  Vec3 proxy_mm = Vec3::Zero();
  Vec3 plane_mm = Vec3::Zero(), normal = Vec3::Zero();  // of the surface nearest to the tip; no normal: none is near
  double stiffness_N_mm = 0;                            // of what is touched, in series with the coupling
  bool hooked = false;
  bool touching = false, cut = false;
  double depth_mm = 0;
  double energy_mJ = 0;  // that the hand has put in, net; never far below zero
};

struct ForceCounts {
  int64_t ticks = 0, saturated = 0, slewed = 0, stale = 0, stalls = 0, damped = 0;
  double least_energy_mJ = 0, largest_step_N = 0;
};

class ForceLoop {
 public:
  explicit ForceLoop(const ForceLimits& limits = {}) : limit_(limits) {}
  /// A newer model, if seq says so.
  void take(const ForceModel& model);
  /// One tick: the tip is here. `valid`: the device was read.
  const ForceState& tick(int64_t now_ns, const Vec3& tip_mm, bool valid);
  const ForceState& state() const { return state_; }
  const ForceCounts& counts() const { return counts_; }

 private:
  struct Touch {
    Vec3 point, normal;
    double depth;  // > 0: below the surface
    double apart;  // from the tip
  };
  bool closest(const Vec3& p, Touch& t) const;
  Vec3 contact_force(const Vec3& tip, double stiffness);
  Vec3 thread_force(const Vec3& tip);
  const Vec3& force_behind(int64_t t_ns) const;

  ForceLimits limit_;
  ForceModel model_;
  ForceState state_;
  ForceCounts counts_;
  bool had_model_ = false, inside_known_ = false;
  double from_N_mm_ = 0, from_hook_N_mm_ = 0;  // stiffness when the model came
  Vec3 from_home_ = Vec3::Zero();
  int64_t model_came_ns_ = 0, last_ns_ = -1;
  bool model_fresh_ = false;
  double ramp_ = 0, fade_ = 1;
  Vec3 held_over_ = Vec3::Zero();  // of the force that a stall left on the hand: what differs from the one that is due
  struct Past {
    int64_t t_ns = -1;  // when it was asked for
    Vec3 force_N = Vec3::Zero();
  };
  std::array<Past, 128> past_;  // a ring, by tick
  bool threaded_ = false;
  double thread_out_mm_ = 0;  // of the thread, from its hole
  double plastic_mm_ = 0;     // how deep the blade has cut
  Vec3 last_tip_ = Vec3::Zero(), slow_v_ = Vec3::Zero();
  double now_N_mm_ = 0, now_hook_N_mm_ = 0;
  Vec3 now_home_ = Vec3::Zero();
};

}  // namespace limberg
