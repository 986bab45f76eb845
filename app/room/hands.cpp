#include "app/room/hands.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "app/assembly/device_specs.h"
#include "app/program/interrupt.h"
#include "app/scene/toml_table.h"
#include "app/session/clock.h"
#include "devices/fastrak/virtual_line.h"
#include "devices/motion.h"
#include "devices/rehearsal.h"
#include "sim/base/elementary.h"
#include "sim/geometry/rotation.h"

namespace limberg {
namespace {

struct Kept final : SampleSink {
  std::vector<Sample> samples;
  void on_sample(const Sample& s) override {
    constexpr size_t kMost = 2'000'000;
    if (samples.size() < kMost && !std::holds_alternative<RawSample>(s)) samples.push_back(s);
  }
};

class LiveHands final : public RoomHands {
 public:
  explicit LiveHands(const std::vector<std::string>& specs)
      : specs_(specs), start_ns_(RealClock::monotonic_ns()), clock_(start_ns_) {
    for (size_t i = 0; i < specs.size(); ++i) {
      const DeviceSpec spec(specs[i]);
      const LiveSource live = live_source(spec, int(i));
      if (!live)
        throw InputError(
            "", 0, "--device " + specs[i] + ": no live device; expected " + device_forms(true) + ", or emulated:FILE");
      tracked_ |= device_kind(spec)->tracked;
      sources_.push_back(live({start_ns_, nullptr, nullptr}));
    }
  }
  std::vector<Sample> during(const std::string&, double seconds,
                             const std::function<bool(const std::vector<Sample>&)>& enough,
                             const std::function<void(double)>& shown) override {
    Kept before;  // what came while nobody asked
    for (const auto& s : sources_) s->poll(clock_.now_ns(), before);
    Kept kept;
    const int64_t from = clock_.now_ns(), end = from + int64_t(seconds * 1e9);
    int64_t looked = from;
    for (int64_t now = from; now < end && !interrupted(); now = clock_.now_ns()) {
      for (const auto& s : sources_) s->poll(now, kept);
      if (now - looked > 100 * kNsPerMs) {
        looked = now;
        if (shown) shown(double(now - from) * 1e-9);
        if (enough && enough(kept.samples)) break;
      }
      clock_.sleep_until_ns(now + 4 * kNsPerMs);
    }
    return std::move(kept.samples);
  }
  std::vector<std::string> specs() const override { return specs_; }
  bool tracked() const override { return tracked_; }
  std::vector<std::string> health() const override {
    std::vector<std::string> out;
    for (size_t i = 0; i < sources_.size(); ++i) {
      const std::string says = sources_[i]->health();
      out.push_back(specs_[i] + (says.empty() ? "" : ": " + says));
    }
    return out;
  }

 private:
  std::vector<std::string> specs_;
  int64_t start_ns_;
  RealClock clock_;
  std::vector<std::unique_ptr<Source>> sources_;
  bool tracked_ = false;
};

/// A stylus of the emulated room whose tip goes where it is told: station 3 beside a glove.
struct EmulatedStylus {
  TouchRehearsal room;  // where the tracker stands, where the tip is
  fastrak::StationPose at(const Vec3& tip_mm, double t, bool pressed) const {
    const Eigen::Quaterniond to_tracker = room.world_from_tracker.conjugate();
    fastrak::StationPose p;
    p.orientation = to_tracker * turn_about(0.3 + 0.1 * elementary::sin(t), Vec3::UnitX()) *
                    turn_about(0.2 * elementary::sin(0.7 * t), Vec3::UnitZ());
    p.pos_mm = to_tracker * (tip_mm - room.world_from_tracker_mm) - p.orientation * room.tip_mm;
    p.pressed = pressed;
    return p;
  }
};

class EmulatedHands final : public RoomHands {
 public:
  EmulatedHands(const EmulatedHand& hand, const std::string& spec) : h_(hand), spec_(spec) {}

  std::vector<Sample> during(const std::string& asked, double seconds,
                             const std::function<bool(const std::vector<Sample>&)>& enough,
                             const std::function<void(double)>& shown) override {
    const size_t n = tries_[asked]++;
    const auto of = [n](const std::vector<double>& v) { return v[std::min(n, v.size() - 1)]; };
    fastrak::LinkSettings link;
    std::string roles;
    roles += h_.glove ? "ft" : "--", roles += h_.stylus ? "s" : "";
    link.role = fastrak::parse_roles(roles);
    for (Vec3& hemisphere : link.hemisphere) hemisphere = Vec3::Zero();
    fastrak::EmulatorSettings device;
    device.seed = h_.seed + 17 * n;
    device.noise_mm = of(h_.noise_mm);
    double takes = seconds;
    const fastrak::Motion motion = motion_of(asked, of, takes);
    std::vector<Sample> all = fastrak::readings_of(motion, takes, link, device), kept;
    RandomStream chance(h_.seed + 31 * n);
    for (Sample& s : all) {
      if (chance.uniform() < of(h_.lost)) continue;
      std::visit([&](auto& v) { v.t_ns += at_ns_; }, s);
      if (auto* t = std::get_if<TrackerSample>(&s)) t->true_ns += at_ns_;
      kept.push_back(std::move(s));
    }
    at_ns_ += int64_t(takes * 1e9) + 1'000'000'000;
    if (shown) shown(takes);
    if (enough) enough(kept);
    return kept;
  }
  std::vector<std::string> specs() const override { return {spec_}; }
  bool tracked() const override { return true; }
  std::vector<std::string> health() const override { return {spec_ + ": an emulated hand"}; }
  bool emulated() const override { return true; }

 private:
  template <class Of>
  fastrak::Motion motion_of(const std::string& asked, const Of& of, double& seconds) {
    const uint64_t seed = h_.seed;
    const fastrak::Motion still = [](int station, double) {
      fastrak::StationPose p;
      p.pos_mm = Vec3(330 + 20 * station, 10 * station, -100);
      return p;
    };
    // Stations 1 and 2 are the glove's; whatever moves the stylus stands at station 3.
    const auto stylus = [still](const fastrak::Motion& m) -> fastrak::Motion {
      return [=](int station, double t) { return station == 3 ? m(1, t) : still(station, t); };
    };
    const auto glove = [still](const fastrak::Motion& m) -> fastrak::Motion {
      return [=](int station, double t) { return station == 3 ? still(3, t) : m(station, t); };
    };
    const EmulatedStylus tool{room_};
    if (asked == "tip") {
      PivotRehearsal r;
      r.seed = seed, r.tip_mm = room_.tip_mm, r.cone_deg = of(h_.cone_deg);
      return stylus(stylus_in_dimple(r));
    }
    if (asked == "table") {
      TouchRehearsal r = room_;
      r.seed = seed;
      const std::vector<Vec3> sheet = sheet_points();
      for (size_t i = 0; i < size_t(std::max(1.0, of(h_.touches))); ++i) r.points_mm.push_back(sheet[i % sheet.size()]);
      if (r.points_mm.size() > 1) r.points_mm[1] += Vec3(0, of(h_.touch_off_mm), 0);
      seconds = seconds_for(r);
      return stylus(stylus_touching(r));
    }
    if (asked == "hand" || asked == "grab") {
      const double closings = asked == "grab" ? of(h_.grabs) : 4, closed = of(h_.closed_mm), open = of(h_.open_mm);
      const fastrak::Motion opening = glove_opening(seed, closed, open);
      seconds = 2 * closings + 1.2;
      return glove([=](int station, double t) { return opening(station, t < 2 * closings ? t : 2 * closings); });
    }
    if (asked == "stroke") {
      const Vec3 from = sheet_points()[0] + Vec3(0, of(h_.line_off_mm), 0), way(297, 0, 0);
      const double lets_go = of(h_.lets_go);
      seconds = 6;
      return stylus([=](int, double t) {
        const double share = minimum_jerk((t - 1.5) / 3.5);
        const bool gap = lets_go > 0 && std::fmod(share * (lets_go + 1), 1.0) < 0.1 && share > 0.15;
        return tool.at(from + share * way, t, t > 1.3 && t < 5.3 && !gap);
      });
    }
    if (asked == "reach") {
      const double wide = of(h_.reach_mm) / 2;
      return stylus([=](int, double t) {
        const double turn = 2 * std::numbers::pi * t / 6;
        return tool.at(Vec3(wide * elementary::sin(turn), 0.75 * wide * elementary::cos(turn),
                            0.3 * wide * (1 - elementary::cos(2 * turn))),
                       t, false);
      });
    }
    return still;
  }

  EmulatedHand h_;
  std::string spec_;
  TouchRehearsal room_;
  std::map<std::string, size_t> tries_;
  int64_t at_ns_ = 1'000'000'000;
};

}  // namespace

std::unique_ptr<RoomHands> live_hands(const std::vector<std::string>& specs) {
  return std::make_unique<LiveHands>(specs);
}

EmulatedHand parse_emulated_hand(const std::string& text, const std::string& file) {
  const toml::table root = parse_toml(text, file, "an emulated hand for limberg rooms (docs/rooms.md)");
  EmulatedHand h;
  Table t(&root, "", file);
  t.first_format("limberg_hand");
  t.integer("seed", 0, int64_t(1) << 40, [&](int64_t v) { h.seed = uint64_t(v); });
  t.boolean("stylus", h.stylus), t.boolean("glove", h.glove);
  constexpr int kTries = 20;
  const auto each = [&](const char* key, std::vector<double>& v, double low, double high) {
    t.numbers(key, v, low, high, false, kTries);
  };
  each("noise_mm", h.noise_mm, 0, 50), each("lost", h.lost, 0, 1), each("cone_deg", h.cone_deg, 0, 120);
  each("touch_off_mm", h.touch_off_mm, -100, 100), each("touches", h.touches, 1, 30);
  each("closed_mm", h.closed_mm, 0, 200), each("open_mm", h.open_mm, 1, 300);
  each("line_off_mm", h.line_off_mm, -100, 100), each("lets_go", h.lets_go, 0, 10), each("grabs", h.grabs, 0, 20);
  each("reach_mm", h.reach_mm, 0, 2000);
  t.finish();
  if (!h.stylus && !h.glove) throw InputError(file, 0, "has neither stylus nor glove; expected one of them to be true");
  return h;
}

std::unique_ptr<RoomHands> emulated_hands(const EmulatedHand& hand, const std::string& spec) {
  return std::make_unique<EmulatedHands>(hand, spec);
}

}  // namespace limberg
