#include "devices/message_codec.h"

#include <zlib.h>

#include <cmath>

#include "devices/old_controls.h"
#include "sim/base/error.h"
#include "sim/commands/script.h"

namespace limberg {

uint32_t checksum(const uint8_t* data, size_t n) { return uint32_t(::crc32_z(0, data, n)); }

namespace {

constexpr int64_t kDayNs = int64_t(86'400) * 1'000'000'000;
constexpr double kFarMm = 10'000;

template <class M>
const char* check_prefix(const M& m, bool any_time) {
  if (m.seq < 0) return "negative sequence number";
  if (!any_time && (m.t_host_ns < 0 || m.t_host_ns > kDayNs)) return "time outside one day";
  return nullptr;
}

const char* check_pose(const double (&p)[3], const double (&q)[4]) {
  double qq = 0;
  for (double v : p)
    if (!std::isfinite(v) || std::abs(v) > kFarMm) return "tip is not a place";
  for (double v : q) {
    if (!std::isfinite(v) || std::abs(v) > 2) return "quaternion is not of unit length";
    qq += v * v;
  }
  return qq < 0.99 * 0.99 || qq > 1.01 * 1.01 ? "quaternion is not of unit length" : nullptr;
}

template <class M, class S>
void copy_prefix(const M& m, S& s) {
  s.device_id = m.device_id;
  s.seq = m.seq;
  s.t_ns = m.t_host_ns;
}

template <class M, class S>
void set_prefix(const S& s, M& m) {
  m.schema_version = kSchemaVersion;
  m.seq = s.seq;
  m.t_host_ns = s.t_ns;
  m.t_device_ns = -1;
  m.device_id = s.device_id;
  m.crc = 0;
}

}  // namespace

const char* to_sample(const limberg_msg::stylus_t& m, StylusSample& s, bool any_time) {
  if (const char* wrong = check_prefix(m, any_time)) return wrong;
  if (const char* wrong = check_pose(m.tip_mm, m.quat)) return wrong;
  copy_prefix(m, s);
  s.tip_mm = Vec3(m.tip_mm[0], m.tip_mm[1], m.tip_mm[2]);
  for (int i = 0; i < 4; ++i) s.quat[size_t(i)] = m.quat[i];
  s.buttons = uint32_t(m.buttons);
  return nullptr;
}

const char* to_sample(const limberg_msg::control_t& m, ControlSample& s, bool any_time) {
  if (const char* wrong = check_prefix(m, any_time)) return wrong;
  if (m.kind < ControlSample::select_tool || m.kind > ControlSample::kLastKind) return "unknown kind of control";
  if (m.tool < int32_t(Tool::none) || m.tool > int32_t(kLastTool)) return "unknown tool";
  for (double v : m.value)
    if (!std::isfinite(v) || std::abs(v) > 1e6) return "control value is not a number of this world";
  for (size_t i = 0; i < sizeof m.text; ++i)
    if ((m.text[i] > 0 && m.text[i] < 0x20) || m.text[i] == 0x7F) return "control character in a text";
  copy_prefix(m, s);
  s.kind = m.kind;
  s.tool = Tool(m.tool);
  for (int i = 0; i < 4; ++i) s.value[size_t(i)] = m.value[i];
  s.text = ShortText(get_text(m.text));
  return nullptr;
}

limberg_msg::stylus_t to_message(const StylusSample& s) {
  limberg_msg::stylus_t m{};
  set_prefix(s, m);
  for (int i = 0; i < 3; ++i) m.tip_mm[i] = s.tip_mm[i];
  for (int i = 0; i < 4; ++i) m.quat[i] = s.quat[size_t(i)];
  m.buttons = int32_t(s.buttons);
  return m;
}

limberg_msg::control_t to_message(const ControlSample& s) {
  limberg_msg::control_t m{};
  set_prefix(s, m);
  m.kind = s.kind;
  m.tool = int32_t(s.tool);
  for (int i = 0; i < 4; ++i) m.value[i] = s.value[size_t(i)];
  put_text(m.text, s.text.str());
  return m;
}

const char* to_sample(const limberg_msg::tracker_t& m, TrackerSample& s, bool any_time) {
  if (const char* wrong = check_prefix(m, any_time)) return wrong;
  if (const char* wrong = check_pose(m.pos_mm, m.quat)) return wrong;
  if (m.station < 1 || m.station > 4) return "unknown station";
  if (m.role < int32_t(StationRole::none) || m.role > int32_t(StationRole::other_thumb))
    return "unknown role of a station";
  if (m.status < 0x20 || m.status > 0x7E) return "status is not a character";
  if (!any_time && (m.t_device_ns > m.t_host_ns || m.t_device_ns < m.t_host_ns - kOldestReadingNs))
    return "reading not from the last second";
  copy_prefix(m, s);
  s.true_ns = m.t_device_ns;
  s.station = m.station;
  s.role = StationRole(m.role);
  s.status = char(m.status);
  s.pos_mm = Vec3(m.pos_mm[0], m.pos_mm[1], m.pos_mm[2]);
  for (int i = 0; i < 4; ++i) s.quat[size_t(i)] = m.quat[i];
  s.buttons = uint32_t(m.buttons);
  return nullptr;
}

const char* to_sample(const limberg_msg::raw_t& m, RawSample& s, bool any_time) {
  if (const char* wrong = check_prefix(m, any_time)) return wrong;
  if (m.n < 0 || m.n > int32_t(s.bytes.size())) return "number of bytes that cannot be";
  copy_prefix(m, s);
  s.n = m.n;
  std::memcpy(s.bytes.data(), m.raw, s.bytes.size());
  return nullptr;
}

limberg_msg::tracker_t to_message(const TrackerSample& s) {
  limberg_msg::tracker_t m{};
  set_prefix(s, m);
  m.t_device_ns = s.true_ns;
  m.station = s.station;
  m.role = int32_t(s.role);
  m.status = s.status;
  for (int i = 0; i < 3; ++i) m.pos_mm[i] = s.pos_mm[i];
  for (int i = 0; i < 4; ++i) m.quat[i] = s.quat[size_t(i)];
  m.buttons = int32_t(s.buttons);
  return m;
}

limberg_msg::raw_t to_message(const RawSample& s) {
  limberg_msg::raw_t m{};
  set_prefix(s, m);
  m.n = s.n;
  std::memcpy(m.raw, s.bytes.data(), s.bytes.size());
  return m;
}

const char* to_sample(const limberg_msg::command_t& m, CommandSample& s, bool any_time) {
  if (const char* wrong = check_prefix(m, any_time)) return wrong;
  if (m.n < 0 || size_t(m.n) != m.line.size()) return "a line of the wrong length";
  try {
    const std::string_view line(reinterpret_cast<const char*>(m.line.data()), m.line.size());
    s.command = std::make_shared<const Command>(parse_command(line, "command", 0));
  } catch (const InputError&) {
    return "no command of a script";
  }
  copy_prefix(m, s);
  return nullptr;
}

limberg_msg::command_t to_message(const CommandSample& s) {
  limberg_msg::command_t m{};
  set_prefix(s, m);
  const std::string line = s.command ? to_json_line(*s.command) : "";
  m.line.assign(line.begin(), line.end());
  m.n = int32_t(line.size());
  return m;
}

CommandSample command_sample(const Command& command) {
  const std::string line = to_json_line(command);
  if (line.size() > kMaxCommandLine)
    throw InputError("", 0,
                     std::string(action_name(command)) + " has a line of " + std::to_string(line.size()) +
                         " bytes; expected at most " + std::to_string(kMaxCommandLine));
  CommandSample s;
  s.command = std::make_shared<const Command>(parse_command(line, "", 0));
  return s;
}

std::string_view channel_of(const Sample& s) {
  constexpr std::array<std::string_view, std::variant_size_v<Sample>> channel{
      kStylusChannel, kControlChannel, kTrackerChannel, kRawChannel, kCommandChannel};
  return channel[s.index()];
}

}  // namespace limberg
