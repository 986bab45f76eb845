#pragma once
// What a check of the lattice throws when the surface of the material contradicts itself: a coincidence that the cutter
// has not seen. Whoever made the cut takes it back and refuses it. Any other std::logic_error is a defect of the
// program and is never refused.
#include <stdexcept>

namespace limberg {

struct Contradiction : std::logic_error {
  using std::logic_error::logic_error;
};

}  // namespace limberg
