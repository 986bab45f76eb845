#pragma once
// What the anatomical head is made after: distances between landmarks of young white men, with means and standard
// deviations as published. Angles and the distances of cephalometry have their norms beside their definitions
// (sim/measure/cephalometry.h); teeth have Wheeler's (teeth_shape.h).
//
//   Farkas 1994   Anthropometry of the head and face, 2nd ed., Raven Press: North American white men, 19 to 25 years
//   Farkas 2005   International anthropometric study of facial morphology, J Craniofac Surg 16:615: the same, some anew
//
// The figures are as remembered from these tables, to the tenth of a millimetre that they are printed with.
#include <span>

namespace limberg::anatomical {

struct Norm {
  const char* name;
  const char *a, *b;  // landmarks
  double mm, sd;
  const char* source;
};

std::span<const Norm> norms();

}  // namespace limberg::anatomical
