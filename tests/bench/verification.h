#pragma once
// `limberg bench verification`: the elasticity against closed forms, published values and itself.
//
//   even states    patch test, rigid rotation, homogeneous tension, shear
//                  and biaxial states of every law, fibre sets G1 and G2
//   Cook           the tapered panel in plane strain, for the energies that published values exist for
//   sphere         thick shell, B/A = 2, blown up: pressure against the incompressible closed form
//   elastica       a slender bar bent by a dead load at its tip
//   manufactured   a displacement made up beforehand and the body force that belongs to it: L2 and H1 orders
//   bending        a strip bent by 20 mm: strain energy of the scenes' element, the fully integrated one and the linear
//                  tetrahedron with two and more cells through its thickness, at three Poisson's ratios
//   CalculiX       the skin block by an independent program, where it is installed (Debian: calculix-ccx)
//   thickness      skin on a ball and in a slab whose borders fall anywhere in the cells; a patch of it that is pulled
//   live error     the distance to equilibrium that every frame states, against the true one (verification_live.cpp,
//                  verification_operations.cpp)
//
// A bar holds when the finest mesh is within 1 % and the observed order is what theory gives, less 0.25. Equilibria are
// found by full Newton in double on the same model
// (sim/testing/reference_newton.h); that the program's own minimiser
// finds the same is what its tests are for. Curved and tapered bodies are
// meshes of mapped cells (sim/fem/elements/shaped_cells.h) with the
// scenes' integration rule.
#include <functional>
#include <string>

#include "app/operating_point/bench.h"

namespace limberg::bench {

struct VerificationSettings {
  bool quick = false;                                // the coarsest meshes only, no bars on the finest: behaviour
  std::function<void(const std::string&)> progress;  // empty: silent
  std::string only;                                  // parts whose name contains this
};

Result verification(const VerificationSettings& settings);

}  // namespace limberg::bench
