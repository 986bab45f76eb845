#include "sim/contact/contact_friction.h"

#include <algorithm>
#include <cmath>

#include "sim/fem/forces/contact_law.h"

namespace limberg {
namespace {

// Of the stiffness along the normal. So a pair under the usual push (k times some .03 mm) gives by mu times .1 mm
// before it slides.
constexpr double kGrip = 0.25;
// A push is measured anew when it has changed by so much of itself, or of what presses a place by a thousandth of a
// millimetre: less is not felt, and would hand the solver new contacts for ever.
constexpr double kPushShare = 0.02, kPushLeast_mm = 1e-3;

Vec3 across(const Vec3& v, const Vec3& normal) { return v - normal.dot(v) * normal; }

}  // namespace

void take_grip(const Grip& grip, const Friction& friction, Contact& c) {
  c.stick_mm = grip.stick_mm.cast<float>();
  c.hold_mN = float(friction.coefficient * grip.push_mN);
  c.grip_N_per_mm = float(kGrip) * c.k_N_per_mm;
}

bool follow_grip(Grip& g, const Vec3& apart, const Friction& friction, Contact& c) {
  const Vec3 normal = c.normal.cast<double>();
  const double k = 1000 * double(c.k_N_per_mm), grip_k = kGrip * k;
  const double push = fem::contact_push(normal.dot(apart) - double(c.gap_mm), k, double(c.soft_mm)).force;
  if (g.push_mN == 0 && push == 0) return false;
  bool changed = false;
  if (g.push_mN == 0) {  // it meets
    g.stick_mm = apart;
    changed = true;
  } else if (friction.step_begins) {
    const Vec3 drawn = across(apart - g.stick_mm, normal);
    const double give = friction.coefficient * g.push_mN / grip_k;
    if (const double length = drawn.norm(); length > give) g.stick_mm = apart - give / length * drawn, changed = true;
  }
  const double least = kPushLeast_mm * k;
  if (changed || std::abs(push - g.push_mN) > std::max(kPushShare * std::max(push, g.push_mN), least) ||
      (push == 0) != (g.push_mN == 0))
    g.push_mN = push, changed = true;
  if (changed) take_grip(g, friction, c);
  return changed;
}

void carry_grip(const HeldContact& from, const Vec3& from_apart_mm, HeldContact& to, const Vec3& apart_mm) {
  to.grip.push_mN = from.grip.push_mN;
  to.grip.stick_mm = apart_mm - across(from_apart_mm - from.grip.stick_mm, from.normal);
}

}  // namespace limberg
