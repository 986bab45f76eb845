#pragma once
// Homogeneous states of an incompressible block that are known in closed form: what every law is verified against,
// alone (tests/sim/fem/materials/test_laws.cpp) and through scene, lattice and element (tests/app/test_layer_laws.cpp).
//
// The formulas are written out here by principal stretches, apart from the code of the laws:
//   isotropic    sigma_1 - sigma_3 = s_1 dW/ds_1 - s_3 dW/ds_3 with the stretches of uniaxial (l, l^-1/2, l^-1/2),
//                equibiaxial (l, l, l^-2) or planar tension (l, 1, 1/l)
//   skin G1      Gasser-Ogden-Holzapfel, excised human back (Ni Annaidh et al.
//                2012): mu 201.4 kPa, k1 24530 kPa, k2 0.1327, kappa 0.1404,
//                two families at 41 degrees; stresses and lateral stretches
//                from an independent solution of sigma_2 = sigma_3 = 0
//   skin G2      mu 10 kPa, k1 100 kPa, k2 1, kappa 0.1, one family: along
//                it by formula, across it slack, so the matrix alone
#include <string>
#include <vector>

#include "sim/body/body.h"

namespace limberg {

struct HomogeneousState {
  enum class Load { uniaxial_along, uniaxial_across, equibiaxial, planar };
  std::string name;  // for tables
  LawSpec law;       // empty name: stable neo-Hookean of young_kPa, mu = young_kPa / 3
  double young_kPa = 0;
  Load load = Load::uniaxial_along;
  double stretch = 1;
  double cauchy_kPa = 0;  // of the loaded direction (equibiaxial: of both); the thickness direction is free
  double lateral = 0;     // stretch across the load within the skin; 0: not given
  std::string source;
};

/// All of them.
std::vector<HomogeneousState> homogeneous_states();

}  // namespace limberg
