#pragma once
// The line on which a force device asks the solver how stiff what it touches is. Both calls are made on the device
// thread and return at once; an answer is some periods of the solver old, and its stiffness is faded in (force_loop.h).
#include "sim/patient/press.h"

namespace limberg {

class StiffnessLine {
 public:
  virtual ~StiffnessLine() = default;
  virtual void ask(const PressQuestion& question) noexcept = 0;
  /// The newest answer; one of stiffness 0 before there is any.
  virtual const PressAnswer& newest() noexcept = 0;
};

}  // namespace limberg
