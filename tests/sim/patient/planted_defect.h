#pragma once
// A defect of the program on purpose, in the middle of a cut (FaultPlan::watch).
#include <stdexcept>

#include "sim/cutting/arrangement/fault.h"

namespace limberg::test {

/// Throws as a defect would, at one of the signs that decide a cut.
struct PlantedDefect : SignWatcher {
  int64_t at = -1, calls = 0;
  void pass() {
    if (calls++ == at) throw std::out_of_range("a planted defect");
  }
  void side(const Plane&, const PointRef&, int) override { pass(); }
  void turn(const Plane&, const PointRef&, const PointRef&, const PointRef&, int) override { pass(); }
  void order(int, const PointRef&, const PointRef&, int) override { pass(); }
};

}  // namespace limberg::test
