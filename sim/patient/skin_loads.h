#pragma once
// Forces of given size and direction on patches of skin, as a scene asks for them (WorldSpec::loads).
//
// A load lies on its patch of tissue, as a hook's tip does, and goes with it: the patch is found again after every cut,
// and does not reach over a wound. A load whose middle is cut out is gone; undo brings it back.
#include <vector>

#include "sim/patient/tissue.h"

namespace limberg {

class SkinLoads {
 public:
  SkinLoads(const Tissue& tissue, Holding& holding) : tissue_(tissue), holding_(holding) {}
  /// All that the scene asks for. InputError: off the skin.
  void place();
  /// To the present version of the topology.
  void carry();

 private:
  const Tissue& tissue_;
  Holding& holding_;
};

/// As the solver gets them.
std::vector<DeadLoad> loads(const Holding& holding);

}  // namespace limberg
