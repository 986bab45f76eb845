#include "tests/bench/force_latency.h"

#include <fmt/format.h>
#include <pthread.h>
#include <sched.h>

#include <algorithm>
#include <cmath>

#include "app/assembly/assembly.h"
#include "app/session/clock.h"
#include "app/session/realtime.h"
#include "app/session/thread.h"
#include "devices/force/lcm_force_port.h"
#include "devices/force/waited_source.h"
#include "devices/lcm_library.h"
#include "devices/lcm_local_link.h"
#include "devices/message_codec.h"
#include "sim/base/error.h"
#include "tests/bench/devices/hogs.h"
#include "tests/own_port.h"

namespace limberg::bench {
namespace {

struct Heard {
  std::vector<double> us;  // from the sending of a pose to the coming of its force, sorted
  std::vector<double> inside_us;
  int64_t poses = 0, touched = 0, late_sends = 0;
  double at(double p) const { return us.empty() ? 0 : us[size_t(p * double(us.size() - 1))]; }
  double longer_than(double t) const {
    return us.empty() ? 0 : double(us.end() - std::upper_bound(us.begin(), us.end(), t)) / double(us.size());
  }
};

/// A hand that comes down onto the skin and strokes it, at 1 kHz.
Heard client(const std::string& url, double seconds, bool fifo) {
  if (fifo) {
    sched_param p{};
    p.sched_priority = 70;
    pthread_setschedparam(pthread_self(), SCHED_FIFO, &p);
  }
  request_exact_timers();
  const std::unique_ptr<LcmLibrary> out = open_lcm(url);
  LcmLocalLink in(url);
  Heard h;
  std::vector<int64_t> sent_ns;
  int64_t answered = -1;
  const auto take = [&](std::string_view channel, const uint8_t* data, size_t n) {
    limberg_msg::force_t m;
    if (channel != kForceChannel || decode_message(data, n, m)) return;
    const int64_t now = RealClock::monotonic_ns();
    h.touched += m.state == 2;
    if (m.pose_seq <= answered || size_t(m.pose_seq) >= sent_ns.size()) return;
    answered = m.pose_seq;
    h.us.push_back(double(now - sent_ns[size_t(answered)]) * 1e-3);
    h.inside_us.push_back(double(m.after_ns) * 1e-3);
  };
  const RealClock clock(RealClock::monotonic_ns());
  MessageBytes bytes;
  for (int64_t tick = 1; double(tick) * 1e-3 < seconds; ++tick) {
    // Until the next pose is due: what comes meanwhile is taken as it comes.
    while (clock.now_ns() < tick * kNsPerMs && in.receive(1, take)) {
    }
    const int64_t late = clock.now_ns() / kNsPerMs - tick;
    if (late > 0) tick += late, ++h.late_sends;
    const double t = double(tick) * 1e-3;
    StylusSample s;
    s.device_id = 500, s.seq = h.poses++, s.t_ns = RealClock::monotonic_ns();
    s.tip_mm = Vec3(8 * std::sin(2 * t), 0, 6 - 8 * std::min(1.0, t));
    sent_ns.push_back(s.t_ns);
    out->publish(std::string(kStylusChannel), bytes.data(), encode_message(to_message(s), bytes));
  }
  for (const int64_t end = clock.now_ns() + 20 * kNsPerMs; clock.now_ns() < end && in.receive(1, take);) {
  }
  std::sort(h.us.begin(), h.us.end()), std::sort(h.inside_us.begin(), h.inside_us.end());
  return h;
}

/// A session with the device and a client beside it.
Heard beside(const Scene& scene, const std::string& url, double seconds, bool fifo) {
  AssemblyOptions o;
  o.real_time = true;
  Assembly a(scene, Calibration{}, o);
  a.channels.press = std::make_shared<PressLine>();
  SessionSettings set = a.session_settings();
  set.settle_steps = 1;
  set.end_tick = int64_t(seconds * 1000) + 700;
  RealTimeSettings rt;
  if (!fifo) rt.fifo_priority = 0;
  Heard heard;
  std::unique_ptr<ScheduledThread> hand;
  run_realtime(a.lanes(nullptr), set, rt, [&](int64_t start_ns) {
    a.front.add(std::make_unique<WaitedForceSource>(std::make_unique<LcmForcePort>(url, start_ns), start_ns,
                                                    ForceSourceSettings{}, a.channels.press, fifo));
    hand = std::make_unique<ScheduledThread>([&] { heard = client(url, seconds, fifo); });
  });
  hand.reset();
  return heard;
}

}  // namespace

void add_force_latency(SuiteOutcome& out, const Scene& scene, bool quick,
                       const std::function<void(const std::string&)>& progress) {
  LineChart chart;
  chart.description = "From hand to force over LCM: the share of answers that came later than a time";
  chart.x = {.title = "time from pose to force, us", .log = true, .min = 30, .max = 10'000};
  chart.y = {.title = "share that came later", .log = true, .min = 1e-4, .max = 1};
  chart.x_marks.push_back({1000, "1 ms"});
  for (const bool fifo : {true, false})
    for (const int hogs : {0, 2}) {
      if (quick && (!fifo || hogs == 2)) continue;
      const std::string method = std::string(fifo ? "SCHED_FIFO" : "SCHED_OTHER") + (hogs ? ", two hogs" : "");
      if (progress) progress("hand to force, " + method);
      const std::string url = udpm_here(free_udp_port());
      Heard h;
      try {
        const Hogs busy(hogs);
        h = beside(scene, url, quick ? 4 : 12, fifo);
      } catch (const InputError& e) {
        out.result.notes.push_back(std::string("hand to force: not measured, ") + e.what());
        return;
      }
      Row r;
      r.name = "hand to force over LCM", r.method = method;
      r.settings = fmt::format(
          "p50 {:.0f}, p99 {:.0f}, p99.9 {:.0f}, max {:.0f} us of {} answers to {} poses ({} sent late); of it inside "
          "the program p50 {:.0f}, p99.9 {:.0f} us",
          h.at(0.5), h.at(0.99), h.at(0.999), h.at(1), h.us.size(), h.poses, h.late_sends,
          h.inside_us.empty() ? 0 : h.inside_us[h.inside_us.size() / 2],
          h.inside_us.empty() ? 0 : h.inside_us[size_t(0.999 * double(h.inside_us.size() - 1))]);
      r.error = h.at(0.999), r.error_unit = "us", r.reference = "the client's clock, p99.9";
      out.result.rows.push_back(r);
      ChartSeries s;
      s.name = method;
      for (double t = 30; t < 10'001; t *= 1.08) s.x.push_back(t), s.y.push_back(h.longer_than(t));
      chart.series.push_back(s);
      if (fifo && hogs == 0)
        out.result.bars.push_back({"hand to force over LCM, FIFO: p99.9, us", h.at(0.999), false, 1000, false,
                                   !h.us.empty() && h.at(0.999) <= 1000,
                                   "1 ms on one machine; other work of a shared machine is in it"});
    }
  out.charts.emplace_back("From hand to force over LCM", chart);
}

}  // namespace limberg::bench
