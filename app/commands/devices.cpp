// `limberg devices`: what is connected, live poses, rates, gaps, buttons.
#include <sys/stat.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>

#include "app/assembly/device_specs.h"
#include "app/assembly/streams.h"
#include "app/commands/commands.h"
#include "app/commands/numbers.h"
#include "app/program/interrupt.h"
#include "app/result/progress.h"
#include "app/room/connected.h"
#include "app/session/clock.h"
#include "devices/glove.h"
#include "devices/lcm_publisher.h"
#include "sim/base/error.h"

namespace limberg {

namespace {

struct DevicesOptions {
  std::vector<std::string> devices;
  bool watch = false;
  double seconds = 0;
  std::string calibration, record, publish;
  bool replace = false, publish_anywhere = false;
};

/// What came of one stream (a station, a stylus) lately.
struct Stream {
  std::string name;
  int64_t count = 0, gaps = 0, last_seq = -1, last_ns = -1, edges = 0;
  double longest_gap_ms = 0, rate_hz = 0;
  int64_t counted = 0;  // at the last line
  Vec3 pos_mm = Vec3::Zero();
  std::array<double, 4> quat{1, 0, 0, 0};
  uint32_t buttons = 0;
  char status = ' ';

  void add(int64_t seq, int64_t t_ns, uint32_t now) {
    if (last_seq >= 0 && seq > last_seq + 1) gaps += seq - last_seq - 1;
    if (last_ns >= 0) longest_gap_ms = std::max(longest_gap_ms, double(t_ns - last_ns) * 1e-6);
    edges += last_seq >= 0 && ((now ^ buttons) & 1);
    buttons = now, last_seq = seq, last_ns = t_ns, ++count;
  }
};

const char* role_name(StationRole r) {
  constexpr const char* name[] = {"station", "stylus", "forefinger", "thumb", "other forefinger", "other thumb"};
  return name[size_t(r)];
}

struct DesktopDevices final : SampleSink {
  explicit DesktopDevices(const Calibration& c) : glove(c) {}
  void on_sample(const Sample& sample) override {
    if (record) record->write(sample);
    if (publish) publish->publish(sample);
    if (const auto* t = std::get_if<TrackerSample>(&sample)) {
      Stream& s = streams[{t->device_id, t->station}];
      s.name = role_name(t->role);
      s.pos_mm = t->pos_mm, s.quat = t->quat, s.status = t->status;
      s.add(t->seq, t->true_ns, t->buttons);
      glove.add(*t);
      has_glove |= t->role == StationRole::forefinger;
    } else if (const auto* p = std::get_if<StylusSample>(&sample)) {
      Stream& s = streams[{p->device_id, 0}];
      s.name = "stylus";
      s.pos_mm = p->tip_mm, s.quat = p->quat;
      s.add(p->seq, p->t_ns, p->buttons);
    } else if (std::holds_alternative<ControlSample>(sample) || std::holds_alternative<CommandSample>(sample)) {
      ++controls;
    }
  }
  std::map<std::pair<int32_t, int32_t>, Stream> streams;
  GloveTracker glove;
  bool has_glove = false;
  int64_t controls = 0;
  StreamWriter* record = nullptr;
  LcmPublisher* publish = nullptr;
};

bool exists(const char* file) {
  struct stat st {};
  return stat(file, &st) == 0;
}

/// How many lines were printed.
int show(const std::vector<std::string>& names, const std::vector<std::unique_ptr<Source>>& sources,
         DesktopDevices& desk, int64_t now_ns, double since_s) {
  int lines = 0;
  for (size_t i = 0; i < sources.size(); ++i) {
    const SourceCounts c = sources[i]->counts();
    std::printf("%-34.34s %8lld taken %6lld damaged %6lld lost  %s\n", names[i].c_str(), (long long)c.samples,
                (long long)c.malformed, (long long)c.lost, sources[i]->health().c_str());
    ++lines;
  }
  for (auto& [key, s] : desk.streams) {
    s.rate_hz = double(s.count - s.counted) / std::max(1e-3, since_s);
    s.counted = s.count;
    const double age_ms = double(now_ns - s.last_ns) * 1e-6;
    std::printf(
        "  %-10s %d.%d %6.1f Hz  age %6.1f ms  longest gap %6.1f ms  %4lld missing  (%8.2f %8.2f %8.2f) mm  q (%6.3f "
        "%6.3f %6.3f %6.3f)  button %s, %lld changes%s\n",
        s.name.c_str(), key.first, key.second, s.rate_hz, age_ms, s.longest_gap_ms, (long long)s.gaps, s.pos_mm.x(),
        s.pos_mm.y(), s.pos_mm.z(), s.quat[0], s.quat[1], s.quat[2], s.quat[3], s.buttons & 1 ? "down" : "up",
        (long long)s.edges, s.status == ' ' ? "" : (std::string("  device says ") + s.status).c_str());
    ++lines;
  }
  if (desk.has_glove) {
    const HandPose h = desk.glove.at(now_ns);
    std::printf("  hand       %s, tips %.1f mm apart, centre (%.1f %.1f %.1f) mm, %lld grabs\n",
                !h.valid   ? "not tracked"
                : h.closed ? "closed"
                           : "open",
                h.aperture_mm, h.centre_mm.x(), h.centre_mm.y(), h.centre_mm.z(), (long long)desk.glove.counts().grabs);
    ++lines;
  }
  if (desk.controls > 0) std::printf("  controls   %lld\n", (long long)desk.controls), ++lines;
  std::fflush(stdout);
  return lines;
}

int devices(const DevicesOptions& o) {
  catch_interrupts();
  std::vector<std::string> names = o.devices;
  if (names.empty()) names.push_back("lcm");
  const Calibration calibration = o.calibration.empty() ? Calibration{} : load_calibration(o.calibration);
  const RealClock clock(RealClock::monotonic_ns());
  const int64_t start = RealClock::monotonic_ns();
  std::vector<std::unique_ptr<Source>> sources;
  for (size_t i = 0; i < names.size();) {
    const LiveSource live = live_source(DeviceSpec(names[i]), int(i));
    if (!live) throw InputError("", 0, "--device " + names[i] + ": no live device; expected " + device_forms(true));
    try {
      sources.push_back(live({start, nullptr, nullptr}));
      ++i;
    } catch (const InputError& e) {
      if (!o.devices.empty()) throw;
      std::printf("lcm         not to be had: %s\n", e.what());  // nobody asked for it by name
      names.erase(names.begin() + long(i));
    }
  }
  const std::vector<std::string> ports = serial_ports();
  std::printf("serial ports %s", ports.empty() ? "none" : "");
  for (const std::string& p : ports) std::printf("%s ", p.c_str());
  const char* socket = std::getenv("SPNAV_SOCKET");
  if (!socket) socket = "/var/run/spnav.sock";
  std::printf("\nSpaceMouse   %s\nmouse        %s\n",
              exists(socket) ? (std::string("its daemon at ") + socket).c_str() : "no daemon",
              exists("/dev/input/mice") ? "/dev/input/mice" : "none");
  DesktopDevices desk(calibration);
  std::unique_ptr<StreamWriter> record;
  if (!o.record.empty()) record = std::make_unique<StreamWriter>(o.record, o.replace), desk.record = record.get();
  std::unique_ptr<LcmPublisher> publish;
  if (!o.publish.empty()) {
    for (const std::string& n : names)
      if (device_kind(DeviceSpec(n))->over_lcm)
        throw InputError("", 0,
                         "--publish beside --device " + n + ": what is sent would come back; expected other devices");
    publish = std::make_unique<LcmPublisher>(o.publish, o.publish_anywhere), desk.publish = publish.get();
  }
  const double seconds = o.seconds > 0 ? o.seconds : o.watch ? 1e9 : 2;
  const bool terminal = isatty(STDOUT_FILENO);
  int64_t shown_ns = 0;
  int lines = 0;
  for (int64_t tick = 0; double(tick) * 1e-3 < seconds && !interrupted(); tick += 4) {
    clock.sleep_until_ns(tick * kNsPerMs);
    const int64_t now = clock.now_ns();
    tick = std::max(tick, now / kNsPerMs);
    for (const auto& s : sources) s->poll(now, desk);
    if (desk.has_glove) desk.glove.at(now);
    if (o.watch && now - shown_ns >= (terminal ? 100 : 1000) * kNsPerMs) {
      if (terminal && lines > 0) std::printf("\x1b[%dA\x1b[J", lines);
      lines = show(names, sources, desk, now, double(now - shown_ns) * 1e-9);
      shown_ns = now;
    }
  }
  if (publish) std::printf("published    %lld messages on %s\n", (long long)publish->sent(), o.publish.c_str());
  if (record)
    record->close(), std::printf("recording    %s, %lld samples\n", o.record.c_str(), (long long)record->samples());
  if (!o.watch) show(names, sources, desk, clock.now_ns(), double(clock.now_ns()) * 1e-9);
  return kDone;
}

}  // namespace

void add_devices(CLI::App& app, Chosen& chosen) {
  auto o = std::make_shared<DevicesOptions>();
  CLI::App* c = app.add_subcommand("devices", "What is connected: live poses, rates, gaps, buttons");
  c->add_option("--device", o->devices, device_forms(true) + " (default lcm); may be repeated")->type_name("SPEC");
  c->add_flag("--watch", o->watch, "Go on until Ctrl-C; devices may come and go");
  c->add_option("--seconds", o->seconds, "End after so long (default 2; --watch: never)")
      ->type_name("S")
      ->check(number_from(0.01, 86400.0));
  c->add_option("--calibration", o->calibration, "Of the glove, for its open and closed hand")->type_name("FILE");
  c->add_option("--record", o->record, "Keep what came as a stream: what limberg calibrate reads")->type_name("LOG");
  c->add_option("--publish", o->publish,
                "Send what comes over LCM, for limberg run --device lcm and other programs: "
                "udpm://239.255.76.67:7667?ttl=0 stays on this machine")
      ->type_name("URL");
  c->add_flag("--publish-anywhere", o->publish_anywhere, "Allow addresses that reach other machines");
  c->add_flag("--replace", o->replace, "Replace LOG if it exists");
  c->footer(
      "Example: limberg devices --seconds 20 --device fastrak:/dev/ttyUSB0,s --record pivot.lcm && limberg calibrate "
      "stylus pivot.lcm --out stylus.toml\n         limberg devices --watch --device fastrak:/dev/ttyUSB0,fts");
  c->callback([o, &chosen] { chosen = [o] { return devices(*o); }; });
}

}  // namespace limberg
