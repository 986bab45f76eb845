#pragma once
// What the hand sends, as plain data. Lengths in mm, times in ns of the recording's clock.
#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <variant>

#include "sim/commands/command.h"
#include "sim/geometry/vec.h"

namespace limberg {

/// A short text that travels by value (a stage's name), zero-filled, always ended by a zero.
struct ShortText {
  std::array<char, 48> c{};
  ShortText() = default;
  explicit ShortText(std::string_view s) {
    for (size_t i = 0; i < s.size() && i + 1 < c.size(); ++i) c[i] = s[i];
  }
  std::string_view view() const { return c.data(); }
  std::string str() const { return std::string(c.data()); }
  bool operator==(const ShortText&) const = default;
};

enum class Tool : int32_t {
  none = 0,
  scalpel = 1,
  undermine = 2,
  excise = 3,
  hook = 4,
  suture = 5,
  suture_row = 6,
  scissors = 7,
  saw = 8,
  grab = 9,
  suture_buried = 10,
  suture_corner = 11,
  suture_running = 12,
  hook_out = 13,
  marker = 14,
  swab = 15,
  suture_bites = 16,       // a running stitch, bite after bite
  suture_knot = 17,        // its knot
  suture_row_buried = 18,  // along both edges, in the wound's walls
  suture_deep = 19,        // a stitch into skin or cut faces, whichever is touched
  scalpel_through = 20     // a cut from one side of the body through to the other
};
inline constexpr Tool kLastTool = Tool::scalpel_through;
/// Those that act on bone instead of skin: the saw draws a closed line on it, grab carries a fragment.
/// Drawn along both edges of a wound, one after the other.
inline bool sews_along(Tool t) {
  return t == Tool::suture_row || t == Tool::suture_running || t == Tool::suture_row_buried;
}
/// A needle that goes from bite to bite.
inline bool sews_bites(Tool t) {
  return t == Tool::suture || t == Tool::suture_buried || t == Tool::suture_corner || t == Tool::suture_bites ||
         t == Tool::suture_deep;
}
inline bool acts_on_bone(Tool t) { return t == Tool::saw || t == Tool::grab; }

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
  enum Kind : int32_t {
    select_tool = 1,
    undo = 2,
    stage = 3,
    release_hook = 4,
    redo = 5,
    cursor = 6,
    name_place = 7,  // of a head: what the tool touches has a name from now on
    clutch = 9,
    glove = 17,  // what a glove does
    hand_gain = 18,
    stylus = 19  // whose stylus is followed
  };             // 8, 10 to 16, and 7 with a place: in recordings before command_t (old_controls.h)
  static constexpr int32_t kLastKind = stylus;
  int32_t device_id = 0;
  int64_t seq = 0, t_ns = 0;
  int32_t kind = select_tool;
  Tool tool = Tool::none;
  ShortText text;  // stage: its name
  std::array<double, 4>
      value{};  // select_tool: depth_mm, angle_deg, spacing_mm, hook id; stage: its number; release_hook: id
                // cursor: gain (0: off), 1 to walk on walls and bed too; clutch: 1 down, 0 up
                // name_place: value[3] says what the name is for (Touched)
                // glove: kGloveMode, kCursorGain (0: as it was), kWhichGlove; hand_gain: the gain (0: the hand is
                // where it is in the room again), kWhichGlove
                // stylus: its device id; 0: of the device that sends first from now on
                // angle_deg 0: the blade's angle is read from the shaft during the stroke
};

enum ControlValue : int { kDepth = 0, kAngle = 1, kSpacing = 2, kHookId = 3 };  // select_tool's value[]

enum GloveValue : int { kGloveMode = 0, kCursorGain = 1, kWhichGlove = 2 };  // value[] of glove and hand_gain
enum GloveMode : int { kGlovePoints = 0, kGlovePushesCursor = 1 };           // glove's value[kGloveMode]

enum Touched : int { kTouchedBone = 0, kFaceNearTip = 3 };  // name_place's value[3]

/// A command made away from the hand, by a panel or a program (LCM command_t). Whoever makes one keeps it until the
/// session has ended: the device thread only hands it on, and never frees it.
struct CommandSample {
  int32_t device_id = 0;
  int64_t seq = 0, t_ns = 0;
  std::shared_ptr<const Command> command;
};
/// A sample of a command, as it will be read from a recording. InputError: no script can hold it, or its line is too
/// long.
CommandSample command_sample(const Command& command);

/// What a station of a tracker is fixed to.
enum class StationRole : int32_t {
  none = 0,
  stylus = 1,
  forefinger = 2,
  thumb = 3,
  other_forefinger = 4,  // of a second glove, on the other hand
  other_thumb = 5
};

/// A reading of a tracker was made at most so long before it came.
inline constexpr int64_t kOldestReadingNs = 1'000'000'000;

/// One reading of one station of a tracker (LCM tracker_t), in the tracker's own frame: the sensor, not the tip.
struct TrackerSample {
  int32_t device_id = 0;
  int64_t seq = 0, t_ns = 0;  // seq counts the readings of this station; t_ns: when it was consumed
  int64_t true_ns = 0;        // when the station was where it says, as well as is known
  int32_t station = 1;        // 1 to 4
  StationRole role = StationRole::none;
  Vec3 pos_mm = Vec3::Zero();
  std::array<double, 4> quat{1, 0, 0, 0};  // w, x, y, z
  uint32_t buttons = 0;                    // bit 0: the stylus' switch
  char status = ' ';                       // what the device says of itself; a blank: well
};

/// Bytes of a serial line as they came (LCM raw_t): a record in which a parser erred can be read again.
struct RawSample {
  int32_t device_id = 0;
  int64_t seq = 0, t_ns = 0;  // when the first byte was read
  int32_t n = 0;              // bytes used
  std::array<uint8_t, 64> bytes{};
};

using Sample = std::variant<StylusSample, ControlSample, TrackerSample, RawSample, CommandSample>;

/// When it was taken, on the clock of its source (ns).
inline int64_t time_of(const Sample& s) {
  return std::visit([](const auto& v) { return v.t_ns; }, s);
}

}  // namespace limberg
