#pragma once
// A source that pushes back feels like the tool that it is:
// whoever drives the sources tells it what the stylus hand holds.
#include "devices/tool_event.h"

namespace limberg {

class ToolFollower {
 public:
  virtual ~ToolFollower() = default;
  /// Before each poll; as of the tick before.
  virtual void hold(const ToolState& state) = 0;
};

}  // namespace limberg
