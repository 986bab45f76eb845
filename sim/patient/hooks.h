#pragma once
// Skin hooks: set on a place of the skin, moved by a hand, released.
#include "sim/commands/command.h"
#include "sim/patient/tissue.h"

namespace limberg {

class Hooks {
 public:
  Hooks(const Tissue& tissue, Holding& holding) : tissue_(tissue), holding_(holding) {}

  Outcome act(const SetHook& c);
  Outcome act(const MoveHook& c);
  Outcome act(const ReleaseHook& c);
  /// To the present version of the topology; hooks whose tissue is gone go with it.
  void carry();

 private:
  const Tissue& tissue_;
  Holding& holding_;
};

}  // namespace limberg
