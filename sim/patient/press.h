#pragma once
// What a round tool that presses on the patient asks, and what it is told. Plain data: it passes between threads.
#include <array>
#include <cstdint>

#include "sim/geometry/vec.h"

namespace limberg {

struct PressQuestion {
  uint64_t topology_version = 0;  // of the surface that the place is on
  int32_t triangle = -1;          // of its view
  std::array<double, 3> bary{1, 0, 0};
  Vec3 normal = Vec3::UnitZ();  // of the skin there, deformed, unit, outward: the tool presses against it
  double radius_mm = 1;         // of the tool's flat end
  double depth_mm = 1;          // how deep it is, or would be
};

struct PressAnswer {
  uint64_t topology_version = 0;
  int32_t triangle = -1;
  double stiffness_N_mm = 0;  // secant: force over depth
  double depth_mm = 0;        // of the question
  float residual = 1;         // how far from rest that was found
  int32_t iterations = 0;
};

}  // namespace limberg
