#pragma once
// How the hand moved, from its place at every solver step: the same figures live, in lockstep and in a replay.
//
// Path: the sum of the distances from step to step while the hand is tracked. A movement begins when its speed,
// averaged over 0.1 s, rises above 30 mm/s and ends when it falls below 10 mm/s: counting movements and path is what
// motion analysis of surgical skill does (Datta et al. 2001); the two speeds are ours, chosen between tremor (about 2
// mm/s) and a carried tool (80 mm/s
// and more).
#include <cstdint>
#include <deque>

#include "devices/tool_event.h"

namespace limberg {

struct HandFigures {
  double tracked_s = 0, path_mm = 0;
  int movements = 0;
  int gaps = 0;  // times that tracking was lost after it had been there
  double lost_s = 0;
  double pressed_s = 0;  // with the tool engaged
};

class HandMotion {
 public:
  /// At time t, which never goes back.
  void add(double t_s, const ToolState& tool);
  const HandFigures& figures() const { return figures_; }

 private:
  struct At {
    double t_s = 0, path_mm = 0;
  };
  HandFigures figures_;
  std::deque<At> recent_;  // of the last 0.1 s
  double last_s_ = -1;
  double tip_[3]{};
  bool tracked_ = false, was_tracked_ = false, moving_ = false;
};

}  // namespace limberg
