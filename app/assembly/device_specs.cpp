#include "app/assembly/device_specs.h"

#include <algorithm>
#include <cmath>

#include "devices/desktop_source.h"
#include "devices/fastrak/port.h"
#include "devices/fastrak/source.h"
#include "devices/force/force_source.h"
#include "devices/lcm_net_source.h"
#include "devices/lcm_publisher.h"
#include "sim/base/error.h"

namespace limberg {

namespace {

constexpr int32_t kFirstFastrak = 200;

/// The emulator and whoever reads it, as one.
class EmulatedFastrak final : public Source {
 public:
  EmulatedFastrak(fastrak::SourceSettings settings, int64_t start_ns, uint64_t seed)
      : port_(fastrak::hand_at_work(seed)) {
    settings.path = port_.path();
    source_ = std::make_unique<fastrak::FastrakSource>(settings, start_ns);
  }
  void poll(int64_t now_ns, SampleSink& sink) override { source_->poll(now_ns, sink); }
  bool done() const override { return false; }
  SourceCounts counts() const override { return source_->counts(); }
  std::string health() const override { return source_->health(); }

 private:
  fastrak::EmulatedPort port_;
  std::unique_ptr<fastrak::FastrakSource> source_;
};

}  // namespace

DeviceSpec::DeviceSpec(const std::string& text) {
  const size_t colon = text.find(':');
  kind = text.substr(0, colon);
  rest = colon == std::string::npos ? "" : text.substr(colon + 1);
}

LiveSource live_source(const DeviceSpec& spec, int number) {
  if (spec.kind == "lcm" || (spec.kind == "lcm-from-anywhere" && !spec.rest.empty())) {
    LcmNetSettings net;
    if (!spec.rest.empty()) net.url = spec.rest;
    net.allow_other_networks = spec.kind != "lcm";
    if (!net.allow_other_networks && !stays_here(net.url))
      throw InputError(
          "", 0,
          "--device " + spec.kind + ":" + net.url +
              " may reach other machines; expected lcm:udpm://239.255.76.67:7667?ttl=0, or lcm-from-anywhere:URL");
    return [net](const LiveStart& start) -> std::unique_ptr<Source> {
      return std::make_unique<LcmNetSource>(net, start.start_ns);
    };
  }
  if (spec.kind == "fastrak") {
    fastrak::SourceSettings s = fastrak::parse_source(spec.rest);
    s.link.device_id = kFirstFastrak + number;
    return [s](const LiveStart& start) -> std::unique_ptr<Source> {
      return std::make_unique<fastrak::FastrakSource>(s, start.start_ns);
    };
  }
  if (spec.kind == "fastrak-emulator") {
    fastrak::SourceSettings s;
    if (!spec.rest.empty()) s.link.role = fastrak::parse_roles(spec.rest);
    s.link.device_id = kFirstFastrak + number;
    return [s, number](const LiveStart& start) -> std::unique_ptr<Source> {
      return std::make_unique<EmulatedFastrak>(s, start.start_ns, uint64_t(number + 1));
    };
  }
  if (spec.kind == "spacemouse" || spec.kind == "mouse") {
    DesktopSettings s;
    s.kind = spec.kind == "mouse" ? DesktopSettings::mouse : DesktopSettings::space_mouse;
    s.path = spec.rest;
    s.device_id += number;
    return [s](const LiveStart& start) -> std::unique_ptr<Source> {
      return std::make_unique<DesktopSource>(s, start.start_ns);
    };
  }
  if (spec.kind == "force-simulated" && spec.rest.empty())
    return [](const LiveStart& start) -> std::unique_ptr<Source> {
      SimulatedHand hand;
      // Comes down onto the middle of the skin, presses 3 mm deep and strokes to and fro.
      hand.target = [](double t) {
        return Vec3(15 * std::sin(1.5 * t), 10 * std::sin(0.9 * t), 20 - 23 * std::min(1.0, t / 2));
      };
      return std::make_unique<ForceSource>(std::make_unique<SimulatedForceDevice>(hand), ForceSourceSettings{},
                                           start.stiffness);
    };
  return {};
}

}  // namespace limberg
