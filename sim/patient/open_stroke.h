#pragma once
// An incision that is being drawn. Its pieces are one entry of the history, the last one.
#include "sim/cutting/strokes/drawn_stroke.h"

namespace limberg {

struct OpenStroke {
  int id = 0;
  DrawnStroke drawn;
  bool cut = false;  // it has its entry
};

}  // namespace limberg
