#include "devices/fastrak/link.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "sim/base/error.h"

namespace limberg::fastrak {

namespace {
constexpr int64_t kMs = 1'000'000;
constexpr char kReinitialise = 0x19;  // ^Y
constexpr int64_t kMostHush = 2000;   // ms: a line that never falls quiet is asked all the same
}  // namespace

std::array<StationRole, kStations> parse_roles(const std::string& letters) {
  std::array<StationRole, kStations> role{};
  bool any = letters.size() <= role.size();
  int seen[6] = {};
  for (size_t i = 0; i < letters.size() && i < role.size(); ++i) {
    switch (letters[i]) {
      case 'f':
        role[i] = StationRole::forefinger;
        break;
      case 't':
        role[i] = StationRole::thumb;
        break;
      case 'F':
        role[i] = StationRole::other_forefinger;
        break;
      case 'T':
        role[i] = StationRole::other_thumb;
        break;
      case 's':
        role[i] = StationRole::stylus;
        break;
      case '-':
        break;
      default:
        any = false;
    }
    if (role[i] != StationRole::none && ++seen[int(role[i])] > 1) any = false;
  }
  if (!any || seen[1] + seen[2] + seen[3] == 0 || seen[2] != seen[3] || seen[4] != seen[5])
    throw InputError("", 0,
                     "stations \"" + letters +
                         "\" are not usable; expected one letter a station: f forefinger and t thumb (both or "
                         "neither), F and T those of a second glove, s stylus, - none, as in ft, s, fts or ftFT");
  return role;
}

int64_t Stamps::stamp(int64_t arrival_ns) {
  constexpr double kLumpNs = 50e6;  // further off than this it is another stream
  constexpr double kDrift = 0.01;   // a device whose clock is slower than it says is followed at this rate
  const double arrival = double(arrival_ns);
  if (!started_ || period_ <= 0) return started_ = true, last_ = arrival, arrival_ns;
  // Readings may be missing: as many periods as fit. A reading may come late by most of a period, but hardly early.
  constexpr double kEarly = 0.15;
  const double periods = std::max(1.0, std::floor((arrival - last_) / period_ + kEarly));
  const double expected = last_ + periods * period_, late = arrival - expected;
  last_ = std::abs(arrival - last_) > kLumpNs || late < 0 ? arrival : expected + kDrift * late;
  return int64_t(last_);
}

bool MirrorGuard::straighten(Vec3& p, int64_t t_ns) {
  constexpr double kFastest = 3000;  // mm/s, as the tracking's gate
  constexpr int64_t kForget = 100 * kMs;
  bool turned = false;
  if (last_ns_ >= 0 && t_ns - last_ns_ < kForget) {
    const double reach = kFastest * double(std::max<int64_t>(t_ns - last_ns_, kMs)) * 1e-9;
    if ((p - last_).norm() > reach && (-p - last_).norm() <= reach) p = -p, turned = true;
  }
  last_ = p;
  last_ns_ = t_ns;
  return turned;
}

Link::Link(const LinkSettings& settings) : set_(settings) {
  layout_.binary = set_.binary;
  for (size_t i = 0; i < set_.role.size(); ++i) {
    layout_.active[i] = set_.role[i] != StationRole::none;
    layout_.has_switch[i] = set_.role[i] == StationRole::stylus;
  }
  parser_.reset(layout_);
}

const char* Link::phase_name() const {
  switch (phase_) {
    case Phase::closed:
      return "not connected";
    case Phase::hush:
      return "waiting for silence";
    case Phase::ask:
      return "asked for its status";
    case Phase::reinitialise:
      return "reinitialising";
    case Phase::configure:
      return "being configured";
    case Phase::confirm:
      return "confirming its stations";
    case Phase::run:
      return "running";
  }
  return "";
}

void Link::enter(Phase phase, int64_t now_ns) {
  phase_ = phase;
  since_ns_ = last_record_ns_ = now_ns;
  parser_.reset(layout_);
  switch (phase) {
    case Phase::hush:
      last_byte_ns_ = now_ns;
      say("\rc");  // ends whatever command was begun, then continuous output off
      break;
    case Phase::ask:
      say("S");
      break;
    case Phase::reinitialise:
      out_.push_back(uint8_t(kReinitialise));
      break;
    case Phase::configure:
      configure();
      break;
    case Phase::confirm:
      confirmed_ = 0;
      to_confirm_ = 1;
      say("l1\r");
      break;
    case Phase::run: {
      const double period = 1e9 / kStationsTogetherHz * layout_.active_count();
      for (size_t i = 0; i < stamps_.size(); ++i) stamps_[i] = Stamps(period), mirror_[i] = {};
      say("C");
      break;
    }
    case Phase::closed:
      break;
  }
}

void Link::configure() {
  say(set_.binary ? "f" : "F");
  say("u");
  for (int s = 1; s <= kStations; ++s) {
    const auto i = size_t(s - 1);
    say(fmt::format("l{},{}\r", s, layout_.active[i] ? 1 : 0));
    if (!layout_.active[i]) continue;
    say(fmt::format("O{},2,11,{}1\r", s, layout_.has_switch[i] ? "16," : ""));
    const Vec3& h = set_.hemisphere[i];
    say(fmt::format("H{},{:.4f},{:.4f},{:.4f}\r", s, h.x(), h.y(), h.z()));
    if (layout_.has_switch[i]) say(fmt::format("e{},0\r", s));  // the switch is only reported
  }
  say("x0,1,0,0\rv0,1,0,0\r");
}

void Link::opened(int64_t now_ns) {
  failures_ = 0;
  out_.clear();
  enter(Phase::hush, now_ns);
}

void Link::closed() {
  phase_ = Phase::closed;
  out_.clear();
  status_.clear();
}

void Link::receive(const uint8_t* bytes, size_t n, int64_t now_ns, Receiver& receiver) {
  if (n == 0 || phase_ == Phase::closed) return;
  last_byte_ns_ = now_ns;
  if (phase_ == Phase::hush || phase_ == Phase::reinitialise || phase_ == Phase::configure) return;
  receiver_ = &receiver;
  now_ns_ = now_ns;
  // The bytes were read at once but came one after the other; the last came just now.
  const double byte_ns = 1e10 / double(std::max(1, set_.baud));
  const Phase before = phase_;
  for (size_t i = 0; i < n && phase_ == before; ++i)
    parser_.feed(bytes[i], now_ns - int64_t(double(n - 1 - i) * byte_ns), *this);
  receiver_ = nullptr;
}

void Link::on_record(const Record& r) {
  last_record_ns_ = now_ns_;
  if (phase_ != Phase::run) return;
  const auto i = size_t(r.station - 1);
  TrackerSample s;
  s.device_id = set_.device_id;
  s.station = r.station;
  s.role = set_.role[i];
  s.seq = seq_[i]++;
  s.status = r.error;
  s.pos_mm = r.pos_mm;
  s.quat = r.quat;
  s.buttons = r.pressed ? 1 : 0;
  s.t_ns = now_ns_;
  // While a machine stands still its serial line fills, and no reading is older than a recording takes.
  s.true_ns = std::clamp(stamps_[i].stamp(r.t_ns) - kOutputDelayNs, now_ns_ - kOldestReadingNs, now_ns_);
  mirrored_ += mirror_[i].straighten(s.pos_mm, s.true_ns);
  ++readings_;
  receiver_->on_reading(s);
}

void Link::on_reply(std::span<const char> text) {
  const std::string line(text.data(), text.size());
  if (phase_ == Phase::ask && line.size() >= 40 && line[2] == 'S') {
    status_ = line;
    while (!status_.empty() && status_.back() == ' ') status_.pop_back();
    enter(Phase::configure, now_ns_);
  } else if (phase_ == Phase::confirm && line.size() >= 3 + size_t(kStations) && line[2] == 'l') {
    bool right = true;
    for (size_t i = 0; i < size_t(kStations); ++i) right &= (line[3 + i] == '1') == layout_.active[i];
    if (right) {
      failures_ = 0;
      enter(Phase::run, now_ns_);
    } else {  // a station that was asked for is not there; it may be plugged in later
      ++refused_;
      enter(Phase::hush, now_ns_);
    }
  }
}

void Link::tick(int64_t now_ns) {
  const int64_t in_ms = (now_ns - since_ns_) / kMs;
  switch (phase_) {
    case Phase::hush:
      if ((now_ns - last_byte_ns_) / kMs >= set_.quiet_ms || in_ms >= kMostHush) enter(Phase::ask, now_ns);
      break;
    case Phase::ask:
      if (in_ms >= set_.answer_ms) enter(++failures_ % 2 == 0 ? Phase::reinitialise : Phase::hush, now_ns);
      break;
    case Phase::reinitialise:
      if (in_ms >= set_.reinitialise_ms) enter(Phase::hush, now_ns);
      break;
    case Phase::configure:
      if (in_ms >= set_.tell_ms) enter(Phase::confirm, now_ns);
      break;
    case Phase::confirm:
      if (in_ms >= set_.answer_ms) ++failures_, enter(Phase::hush, now_ns);
      break;
    case Phase::run:
      if ((now_ns - last_record_ns_) / kMs >= set_.watchdog_ms) ++restarts_, enter(Phase::hush, now_ns);
      break;
    case Phase::closed:
      break;
  }
}

std::vector<uint8_t> Link::take_output() {
  std::vector<uint8_t> o;
  o.swap(out_);
  return o;
}

Link::Counts Link::counts() const { return {parser_.counts(), readings_, restarts_, mirrored_, refused_}; }

}  // namespace limberg::fastrak
