#pragma once
// Coulomb friction of a pair that presses, without inertia: it depends on the way that was gone, not on speed.
//
// A pair that presses holds on where it met: a spring across its normal, a quarter as stiff as the one along it, bears
// mu times the push, and what is drawn farther slides. For one step of the solver the point that it holds on to and
// the push both stand still, so that there is an energy and one minimum; pushes are measured again as contacts follow,
// and when the next step begins, what has slid has a new hold at the spring's end. (Lagged pushes: Li et al. 2020,
// Incremental Potential Contact. Slip by return to the cone: Simo and Hughes, Computational Inelasticity, ch. 1.)
//
// How much, in the literature: fat on bone of cattle some .01, with what wets it (abstract of "Lubrication regime of
// the contact between fat and bone in bovine tissue", 2007); steel on wet small bowel .007 to .054 (Tribol. Lett. 51,
// 2013, 377); muscle on bone of pigs, without a fluid between them, .29 to .36 (Shacham, Castel and Gefen, J. Biomech.
// Eng. 132(8), 2010). So tissue on tissue in a wet wound lies at .05 to .2, dry at .3.
#include "sim/contact/contact_memory.h"
#include "sim/fem/model/fem_model.h"

namespace limberg {

struct Friction {
  double coefficient = 0;    // mu; 0: there is none
  bool step_begins = false;  // what has slid holds on anew
};

/// Lets the grip of a pair follow and writes it into its contact, whose spring along the normal is given. `apart_mm`:
/// x_a - x_b now, as the cells carry them. True when the contact is not what it was.
bool follow_grip(Grip& grip, const Vec3& apart_mm, const Friction& friction, Contact& contact);

/// A pair's place has another foot now, or another plane: it is drawn as before, from `apart_mm` on.
void carry_grip(const HeldContact& from, const Vec3& from_apart_mm, HeldContact& to, const Vec3& apart_mm);

/// Writes a grip into its contact as it is.
void take_grip(const Grip& grip, const Friction& friction, Contact& contact);

}  // namespace limberg
