#include "app/assembly/device_specs.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <vector>

#include "app/headset/headset_source.h"
#include "devices/desktop_source.h"
#include "devices/driver/driver_port.h"
#include "devices/fastrak/port.h"
#include "devices/fastrak/source.h"
#include "devices/force/force_source.h"
#include "devices/force/lcm_force_port.h"
#include "devices/force/waited_source.h"
#include "devices/lcm_net_source.h"
#include "devices/lcm_publisher.h"
#include "sim/base/elementary.h"
#include "sim/base/error.h"

namespace limberg {

namespace {

constexpr int32_t kFirstFastrak = 200, kFirstDriver = 310;

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

/// "force=2.5": its number, within these; false: it is none of these words.
bool said(const std::string& word, const std::string& key, double least, double most, double& value) {
  if (!word.starts_with(key)) return false;
  const char* const end = word.data() + word.size();
  double v = 0;
  const auto r = std::from_chars(word.data() + key.size(), end, v);
  if (r.ec != std::errc() || r.ptr != end || !(v >= least && v <= most)) return false;
  return value = v, true;
}

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

/// "URL[,force=N][,stiffness=N/mm][,delay=MS]", each part of which may be missing.
LiveSource force_lcm(const DeviceSpec& spec, int) {
  std::string url = LcmNetSettings{}.url;
  ForceLimits limits = limits_over_lcm();
  for (size_t at = 0; at < spec.rest.size();) {
    const size_t comma = std::min(spec.rest.find(',', at), spec.rest.size());
    const std::string word = spec.rest.substr(at, comma - at);
    double delay_ms = 0;
    if (at == 0 && word.find("://") != std::string::npos)
      url = word;
    else if (said(word, "delay=", 0, 30, delay_ms))
      limits.delay_s = delay_ms * 1e-3;
    else if (!said(word, "force=", 0.01, 100, limits.force_N) &&
             !said(word, "stiffness=", 0.01, 1000, limits.stiffness_N_mm))
      throw InputError("", 0,
                       "--device force-lcm: \"" + word +
                           "\"; expected URL, force=N (to 100), stiffness=N/mm (to 1000) or delay=MS (to 30)");
    at = comma + 1;
  }
  return [url, limits](const LiveStart& start) {
    return std::make_unique<WaitedForceSource>(std::make_unique<LcmForcePort>(url, start.time, limits), start.time,
                                               ForceSourceSettings{}, start.stiffness);
  };
}

LiveSource driver(const DeviceSpec& spec, int number) {
  const size_t comma = spec.rest.find(',');
  const DriverFunctions functions = load_driver(spec.rest.substr(0, comma));
  const std::string options = comma == std::string::npos ? "" : spec.rest.substr(comma + 1);
  ForceSourceSettings s;
  s.device_id = kFirstDriver + number;
  return [functions, options, s](const LiveStart& start) {
    return std::make_unique<WaitedForceSource>(std::make_unique<DriverPort>(functions, options, s.device_id),
                                               start.time, s, start.stiffness);
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
    {.name = "force-lcm",
     .form = "force-lcm[:URL][,force=N][,stiffness=N/mm][,delay=MS]",
     .meaning = "a force device of another program: poses come over LCM, forces go back",
     .feels = true,
     .over_lcm = true,
     .live = force_lcm},
    {.name = "driver",
     .form = "driver:PATH[,OPTIONS]",
     .meaning = "a device by a driver of yours, a shared library (devices/driver/limberg_driver.h)",
     .feels = true,
     .live = driver},
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
