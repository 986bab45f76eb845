#pragma once
// A press of the hand that came to nothing: what the device thread knows of it, as plain numbers. Words are found by
// whoever shows them (app/teaching/why_missed.h).
#include <cstdint>

namespace limberg {

struct MissedPress {
  enum Kind : int32_t {
    press,        // there is nothing under the tip that the tool acts on
    hook_stands,  // the hook asked for stands elsewhere, out of reach
    second_bite,  // a stitch was let go where there is no skin: it is given up
    same_edge,    // a stitch was tied, and there was no skin of another edge under its second bite
    place,        // no bone is touched where a place was to be named
    control,      // a control that this patient does not understand
    no_hook,      // no hook stands here that could be taken out
    no_edge,      // scissors, and neither a stitch nor an edge of a wound to begin at
    no_thread     // a knot, and no thread that is sewn on, or its last bite lies elsewhere
  };
  int64_t tick = 0;
  int32_t kind = press;
  int32_t tool = 0;  // Tool
  double tip_mm[3]{};
  double distance_mm = 0;  // to the nearest ground of the tool, as far as it is known
};

}  // namespace limberg
