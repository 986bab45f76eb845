#pragma once
// What the hand sends, as plain data. Lengths in mm, times in ns of the recording's clock.
#include <array>
#include <cstdint>
#include <string>
#include <variant>

#include "sim/geometry/vec.h"

namespace limberg {

/// A short text that travels by value (a stage's name), zero-filled, always ended by a zero.
struct ShortText {
  std::array<char, 48> c{};
  ShortText() = default;
  explicit ShortText(const std::string& s) {
    for (size_t i = 0; i < s.size() && i + 1 < c.size(); ++i) c[i] = s[i];
  }
  std::string str() const { return std::string(c.data()); }
  bool operator==(const ShortText&) const = default;
};

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
  enum Kind : int32_t { select_tool = 1, undo = 2, stage = 3, release_hook = 4, redo = 5 };
  int32_t device_id = 0;
  int64_t seq = 0, t_ns = 0;
  int32_t kind = select_tool;
  Tool tool = Tool::none;
  ShortText text;                 // stage: its name
  std::array<double, 4> value{};  // select_tool: depth_mm, angle_deg, spacing_mm, hook id; stage: its number; release_hook: id
                                  // angle_deg 0: the blade's angle is read from the shaft during the stroke
};

enum ControlValue : int { kDepth = 0, kAngle = 1, kSpacing = 2, kHookId = 3 };  // select_tool's value[]

using Sample = std::variant<StylusSample, ControlSample>;

}  // namespace limberg
