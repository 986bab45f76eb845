#pragma once
// What the hand sends, as plain data. Lengths in mm, times in ns of the recording's clock.
#include <cstdint>
#include <variant>

#include "sim/geometry/vec.h"

namespace limberg {

enum class Tool : int32_t { none = 0, scalpel = 1, undermine = 2, excise = 3, hook = 4, suture = 5, suture_row = 6 };

/// One stylus reading (LCM stylus_t), as received: tracker noise and gaps included.
struct StylusSample {
  int32_t device_id = 0;
  int64_t seq = 0, t_ns = 0;
  Vec3 tip_mm = Vec3::Zero();
  std::array<double, 4> quat{1, 0, 0, 0};  // w, x, y, z; the stylus' shaft is its local +z, pointing from tip to hand
  uint32_t buttons = 0;                    // bit 0: the tool is engaged (pressed)
};

/// A choice made away from the hand: pedal, palette or keyboard (LCM control_t).
struct ControlSample {
  enum Kind : int32_t { select_tool = 1, undo = 2, stage = 3, release_hook = 4 };
  int32_t device_id = 0;
  int64_t seq = 0, t_ns = 0;
  int32_t kind = select_tool;
  Tool tool = Tool::none;
  std::array<double, 4> value{};  // select_tool: depth_mm, angle_deg, spacing_mm, hook id; stage: its number; release_hook: id
};

using Sample = std::variant<StylusSample, ControlSample>;

}  // namespace limberg
