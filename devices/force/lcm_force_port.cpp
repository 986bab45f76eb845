#include "devices/force/lcm_force_port.h"

#include "devices/lcm_library.h"
#include "devices/lcm_publisher.h"
#include "devices/message_codec.h"
#include "devices/monotonic.h"
#include "sim/base/error.h"

namespace limberg {

namespace {

constexpr int64_t kGivesUpNs = 1'000'000'000;
constexpr double kMilli = 1000;  // mN of a N

const std::string& staying_here(const std::string& url) {
  if (!stays_here(url) || !url.starts_with("udpm://"))
    throw InputError("", 0,
                     "LCM address \"" + url +
                         "\" may reach other machines, which are too far for forces; expected "
                         "udpm://239.255.76.67:7667?ttl=0");
  return url;
}

int32_t state_of(const ForceState& felt) { return felt.hooked ? 4 : felt.cut ? 3 : felt.touching ? 2 : 1; }

}  // namespace

ForceLimits limits_over_lcm() {
  ForceLimits l;
  l.delay_s = 0.001;
  l.stiffness_N_mm = stable_stiffness_N_mm(0.0005, l.damping_N_s_mm, l.delay_s);
  return l;
}

LcmForcePort::LcmForcePort(const std::string& url, const SourceTime& time, const ForceLimits& limits)
    : link_(staying_here(url)), out_(open_lcm(url)), time_(time), limits_(limits), channel_(kForceChannel) {}

LcmForcePort::~LcmForcePort() = default;

void LcmForcePort::take(const uint8_t* data, size_t n) {
  limberg_msg::stylus_t m;
  StylusSample s;
  bool has_checksum = false;
  const int64_t now_ns = monotonic_ns();
  if (decode_message(data, n, m, &has_checksum) || to_sample(m, s, true)) return void(++malformed_);
  const bool another = newest_.seq >= 0 && s.device_id != newest_.device_id;
  if (another && now_ns - newest_.came_ns < kGivesUpNs) return void(++others_);
  int64_t seq = s.seq, gap = 0;
  if (!heard_.take({stream_of(s), s.device_id}, seq, now_ns, has_checksum, gap)) return void(++malformed_);
  newest_.pose.valid = true;
  newest_.pose.tip_mm = s.tip_mm, newest_.pose.quat = s.quat, newest_.pose.buttons = s.buttons;
  newest_.device_id = s.device_id, newest_.seq = m.seq, newest_.sent_ns = m.t_host_ns, newest_.came_ns = now_ns;
  fresh_ = true;
}

bool LcmForcePort::read(int wait_ms, PortReading& reading) {
  const auto taker = [this](std::string_view channel, const uint8_t* data, size_t n) {
    if (channel == kStylusChannel) take(data, n);
  };
  fresh_ = false;
  // Our own forces come back on the same address: they are no reason to answer before the time is over.
  const int64_t end_ns = monotonic_ns() + int64_t(wait_ms) * 1'000'000;
  do {
    if (!link_.receive(wait_ms, taker)) break;
  } while (!fresh_ && monotonic_ns() < end_ns);
  if (fresh_) reading = newest_;
  return fresh_;
}

void LcmForcePort::answer(const PortReading& reading, bool valid, const ForceState& felt, int64_t now_ns) {
  limberg_msg::force_t m{};
  m.seq = seq_;
  m.t_host_ns = now_ns;
  m.device_id = reading.device_id;
  m.t_device_ns = valid ? reading.sent_ns : -1;
  m.pose_seq = valid ? reading.seq : -1;
  m.after_ns = valid ? monotonic_ns() - reading.came_ns : 0;
  m.state = valid ? state_of(felt) : 0;
  for (int i = 0; i < 3 && valid; ++i)
    m.force_mN[i] = kMilli * felt.force_N[i], m.plane_mm[i] = felt.plane_mm[i], m.normal[i] = felt.normal[i];
  if (valid) {
    m.stiffness_mN_mm = kMilli * felt.stiffness_N_mm;
    m.damping_mN_s_mm = kMilli * limits_.damping_N_s_mm;
    m.depth_mm = felt.depth_mm;
  }
  MessageBytes bytes;
  const size_t n = encode_message(m, bytes);
  if (n == 0 || !out_->publish(channel_, bytes.data(), n)) ++unsent_;
  ++seq_;
}

std::string LcmForcePort::says() const {
  return "forces over LCM, this machine only" +
         (others_ > 0 ? ", " + std::to_string(others_) + " poses of further styluses unanswered" : std::string()) +
         (unsent_ > 0 ? ", " + std::to_string(unsent_) + " forces not sent" : std::string());
}

}  // namespace limberg
