#pragma once
// Where the panels stand in a frame, in their units. From 800 x 600 upwards none lies over another, and something is
// left of the patient between them.
#include "app/window/hand_feed.h"

namespace limberg {

/// How many pixels a unit of the panels is: more on a larger screen, in quarters, and with larger letters, but never so
/// many that fewer than 760 x 560 units are left.
float desk_scale(int width, int height, int letters_percent = 100);

struct DeskLayout {
  FrameRect menu, tools, patient, lanes, history;  // history: empty while it is closed
  FrameRect stage;                                 // what is left to the patient
  bool narrow = false;                             // panels are as small as they get
};
DeskLayout desk_layout(float width, float height, bool history_open = false);

/// The stage as shares of the frame's width and height from the top left corner, and its shape in pixels.
struct DeskStage {
  float u0 = 0, v0 = 0, u1 = 1, v1 = 1;
  double aspect = 1;  // width over height
};
DeskStage desk_stage(int width, int height, float scale, bool history_open = false);

inline float wide(const FrameRect& r) { return r.x1 - r.x0; }
inline float high(const FrameRect& r) { return r.y1 - r.y0; }

}  // namespace limberg
