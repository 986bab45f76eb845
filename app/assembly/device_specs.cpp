#include "app/assembly/device_specs.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <vector>

#include "app/headset/headset_source.h"
#include "devices/desktop_source.h"
#include "devices/fastrak/port.h"
#include "devices/fastrak/source.h"
#include "devices/force/force_source.h"
#include "devices/lcm_net_source.h"
#include "devices/lcm_publisher.h"
#include "sim/base/elementary.h"
#include "sim/base/error.h"

namespace limberg {

namespace {

constexpr int32_t kFirstFastrak = 200;

/// The emulator and whoever reads it, as one.
class EmulatedFastrak final : public Source {
 public:
  EmulatedFastrak(fastrak::SourceSettings settings, const SourceTime& time, uint64_t seed)
      : port_(fastrak::hand_at_work(seed)) {
    settings.path = port_.path();
    source_ = std::make_unique<fastrak::FastrakSource>(settings, time);
  }
  void poll(int64_t now_ns, SampleSink& sink) override { source_->poll(now_ns, sink); }
  bool done() const override { return false; }
  SourceCounts counts() const override { return source_->counts(); }
  std::string health() const override { return source_->health(); }

 private:
  fastrak::EmulatedPort port_;
  std::unique_ptr<fastrak::FastrakSource> source_;
};

LiveSource lcm(const DeviceSpec& spec, int) {
  LcmNetSettings net;
  if (!spec.rest.empty()) net.url = spec.rest;
  if (!stays_here(net.url))
    throw InputError(
        "", 0,
        "--device " + spec.kind + ":" + net.url +
            " may reach other machines; expected lcm:udpm://239.255.76.67:7667?ttl=0, or lcm-from-anywhere:URL");
  return [net](const LiveStart& start) { return std::make_unique<LcmNetSource>(net, start.time); };
}

LiveSource lcm_from_anywhere(const DeviceSpec& spec, int) {
  if (spec.rest.empty()) return {};
  LcmNetSettings net;
  net.url = spec.rest, net.allow_other_networks = true;
  return [net](const LiveStart& start) { return std::make_unique<LcmNetSource>(net, start.time); };
}

LiveSource fastrak_at(const DeviceSpec& spec, int number) {
  fastrak::SourceSettings s = fastrak::parse_source(spec.rest);
  s.link.device_id = kFirstFastrak + number;
  return [s](const LiveStart& start) { return std::make_unique<fastrak::FastrakSource>(s, start.time); };
}

LiveSource fastrak_emulator(const DeviceSpec& spec, int number) {
  fastrak::SourceSettings s;
  if (!spec.rest.empty()) s.link.role = fastrak::parse_roles(spec.rest);
  s.link.device_id = kFirstFastrak + number;
  return [s, number](const LiveStart& start) {
    return std::make_unique<EmulatedFastrak>(s, start.time, uint64_t(number + 1));
  };
}

template <DesktopSettings::Kind kind>
LiveSource desktop(const DeviceSpec& spec, int number) {
  DesktopSettings s;
  s.kind = kind, s.path = spec.rest;
  s.device_id += number;
  return [s](const LiveStart& start) { return std::make_unique<DesktopSource>(s, start.time); };
}

LiveSource force_simulated(const DeviceSpec& spec, int) {
  if (!spec.rest.empty()) return {};
  return [](const LiveStart& start) {
    SimulatedHand hand;
    // Comes down onto the middle of the skin, presses 3 mm deep and strokes to and fro.
    hand.target = [](double t) {
      return Vec3(15 * elementary::sin(1.5 * t), 10 * elementary::sin(0.9 * t), 20 - 23 * std::min(1.0, t / 2));
    };
    return std::make_unique<ForceSource>(std::make_unique<SimulatedForceDevice>(hand), ForceSourceSettings{},
                                         start.stiffness);
  };
}

LiveSource headset(const DeviceSpec& spec, int) {
  return [s = parse_headset(spec.rest)](const LiveStart& start) {
    return std::make_unique<HeadsetSource>(s, start.time, start.headset);
  };
}

// Roles of a FASTRAK: a letter a station, f forefinger, t thumb, F and T those of a second glove, s stylus.
constexpr DeviceKind kKinds[] = {
    {.name = "emulated",
     .form = "emulated:SCRIPT",
     .meaning = "the emulated surgeon, who needs the patient that it operates on",
     .from_file = true,
     .own_hand = false},
    {.name = "log", .form = "log:FILE", .meaning = "a recording", .from_file = true, .own_hand = false},
    {.name = "lcm",
     .form = "lcm[:URL]",
     .meaning = "LCM on this machine",
     .tracked = true,
     .over_lcm = true,
     .live = lcm},
    {.name = "lcm-from-anywhere",
     .form = "lcm-from-anywhere:URL",
     .meaning = "LCM, also from other machines",
     .tracked = true,
     .over_lcm = true,
     .live = lcm_from_anywhere},
    {.name = "fastrak",
     .form = "fastrak:PORT[,ROLES][,ascii][,RATE]",
     .meaning = "a FASTRAK on a serial port",
     .tracked = true,
     .live = fastrak_at},
    {.name = "fastrak-emulator",
     .form = "fastrak-emulator[:ROLES]",
     .meaning = "the same, emulated on a pseudo-terminal, with a hand at work",
     .tracked = true,
     .live = fastrak_emulator},
    {.name = "spacemouse",
     .form = "spacemouse[:SOCKET]",
     .meaning = "a SpaceMouse through spacenavd",
     .live = desktop<DesktopSettings::space_mouse>},
    {.name = "mouse",
     .form = "mouse[:FILE]",
     .meaning = "a mouse (/dev/input/mice), made for run --cursor",
     .own_hand = false,
     .live = desktop<DesktopSettings::mouse>},
    {.name = "force-simulated",
     .form = "force-simulated",
     .meaning = "a force device made of equations, in a hand that presses and strokes",
     .feels = true,
     .live = force_simulated},
    {.name = "headset",
     .form = "headset[:left][,scale=S][,table=M]",
     .meaning = "a headset with its controllers and hands, by OpenXR",
     .shows = true,
     .live = headset}};

}  // namespace

DeviceSpec::DeviceSpec(const std::string& text) {
  const size_t colon = text.find(':');
  kind = text.substr(0, colon);
  rest = colon == std::string::npos ? "" : text.substr(colon + 1);
}

std::span<const DeviceKind> device_kinds() { return kKinds; }

const DeviceKind* device_kind(const DeviceSpec& spec) {
  const auto* const k =
      std::find_if(std::begin(kKinds), std::end(kKinds), [&](const DeviceKind& d) { return spec.kind == d.name; });
  return k == std::end(kKinds) ? nullptr : k;
}

std::string device_forms(bool live_only) {
  std::vector<std::string> forms;
  for (const DeviceKind& k : kKinds)
    if (k.live || !live_only) forms.emplace_back(k.form);
  const std::string last = forms.back();
  forms.pop_back();
  return fmt::format("{} or {}", fmt::join(forms, ", "), last);
}

LiveSource live_source(const DeviceSpec& spec, int number) {
  const DeviceKind* k = device_kind(spec);
  return k && k->live ? k->live(spec, number) : LiveSource{};
}

}  // namespace limberg
