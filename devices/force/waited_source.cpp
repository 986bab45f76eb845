#include "devices/force/waited_source.h"

#include <fmt/format.h>
#include <pthread.h>
#include <sched.h>
#include <sys/prctl.h>
#include <time.h>

#include <algorithm>
#include <atomic>
#include <thread>

#include "devices/monotonic.h"
#include "devices/sample_queue.h"
#include "devices/spsc_ring.h"

namespace limberg {

namespace {

constexpr int64_t kSampleNs = 800'000;    // to everybody else goes one a millisecond, and what was pressed
constexpr int64_t kShortestNs = 200'000;  // between two answers: whoever floods the port does not take the processor

/// True: real-time priority was given.
bool be_prompt() {
  prctl(PR_SET_TIMERSLACK, 1000UL);  // ns; the default is 50 us
  sched_param p{};
  p.sched_priority = 79;  // one below the device thread's
  return pthread_setschedparam(pthread_self(), SCHED_FIFO, &p) == 0;
}

void wait_until(int64_t ns) {
  if (const int64_t wait = ns - monotonic_ns(); wait > 0) {
    const timespec pause{0, std::min<int64_t>(wait, 999'999'999)};
    nanosleep(&pause, nullptr);
  }
}

}  // namespace

struct WaitedForceSource::Impl {
  /// What the device thread must know of the loop.
  struct FeltThere {
    Vec3 tip_mm = Vec3::Zero();
    ForceState felt;
  };

  Impl(std::unique_ptr<ForcePort> p, const SourceTime& t, const ForceSourceSettings& settings,
       std::shared_ptr<StiffnessLine> line, bool prompt)
      : port(std::move(p)),
        time(t),
        maker(settings, std::move(line)),
        device_id(settings.device_id),
        wants_real_time(prompt),
        models(8),
        felts(64),
        queue(1024) {}

  // ---- the thread that waits ----

  void run() {
    real_time.store(wants_real_time && be_prompt(), std::memory_order_relaxed);
    ForceLoop loop(port->limits());
    PortReading reading;
    bool cuts = false, got = false;
    int64_t came_ns = -1, seq = 0, answered_ns = 0, passed_ns = 0;
    uint32_t last_buttons = 0;
    while (!stop.load(std::memory_order_acquire)) {
      // The next one of a device at 1 kHz is answered when it comes, and not just missed by an answer before it.
      got = port->read(got ? 2 : 1, reading);
      wait_until(answered_ns + kShortestNs);
      answered_ns = monotonic_ns();
      const int64_t now_ns = time.wall_ns(answered_ns);
      while (const ForceModel* model = models.front()) {
        loop.take(*model), cuts = model->presses;
        models.drop();
      }
      if (got) came_ns = now_ns;
      const bool valid = came_ns >= 0 && now_ns - came_ns < kSilentNs && reading.pose.valid;
      const ForceState& felt = loop.tick(now_ns, reading.pose.tip_mm, valid);
      port->answer(reading, valid, felt, now_ns);
      tell(loop);
      if (!valid) continue;
      felts.push({reading.pose.tip_mm, felt});
      const bool another = reading.pose.buttons != last_buttons;
      if (!got || (!another && now_ns - passed_ns < kSampleNs)) continue;
      passed_ns = now_ns, last_buttons = reading.pose.buttons;
      StylusSample s;
      s.device_id = device_id;
      s.seq = seq++;
      s.t_ns = time.stamp_ns(now_ns);
      s.tip_mm = felt.touching ? felt.proxy_mm : reading.pose.tip_mm;
      s.quat = reading.pose.quat;
      s.buttons = reading.pose.buttons | (cuts && felt.cut ? 1u : 0u);
      if (!queue.push(s)) lost.fetch_add(1, std::memory_order_relaxed);
    }
    port->answer(reading, false, ForceState{}, time.wall_ns(monotonic_ns()));
  }

  void tell(const ForceLoop& loop) {
    constexpr auto relaxed = std::memory_order_relaxed;
    const ForceCounts& c = loop.counts();
    ticks.store(c.ticks, relaxed), saturated.store(c.saturated, relaxed), stale.store(c.stale, relaxed);
    damped.store(c.damped, relaxed), force_N.store(loop.state().force_N.norm(), relaxed);
    least_mJ.store(c.least_energy_mJ, relaxed);
  }

  std::unique_ptr<ForcePort> port;
  const SourceTime time;
  ForceModelMaker maker;  // of the device thread
  const int32_t device_id;
  const bool wants_real_time;
  SpscRing<ForceModel> models;
  SpscRing<FeltThere> felts;
  FeltThere there;  // of the device thread
  bool any = false;
  SampleQueue queue;
  std::atomic<int64_t> lost{0}, ticks{0}, saturated{0}, stale{0}, damped{0};
  std::atomic<double> force_N{0}, least_mJ{0};
  std::atomic<bool> real_time{false}, stop{false};
  std::thread thread;
};

WaitedForceSource::WaitedForceSource(std::unique_ptr<ForcePort> port, const SourceTime& time,
                                     const ForceSourceSettings& settings, std::shared_ptr<StiffnessLine> line,
                                     bool real_time)
    : impl_(std::make_unique<Impl>(std::move(port), time, settings, std::move(line), real_time)) {
  impl_->thread = std::thread([this] { impl_->run(); });
}

WaitedForceSource::~WaitedForceSource() {
  impl_->stop.store(true, std::memory_order_release);
  impl_->thread.join();
}

void WaitedForceSource::look(const Snapshot& s) { impl_->maker.look(s); }
void WaitedForceSource::hold(const ToolState& state) { impl_->maker.hold(state); }

void WaitedForceSource::poll(int64_t now_ns, SampleSink& sink) {
  Impl& i = *impl_;
  while (const Impl::FeltThere* felt = i.felts.front()) i.there = *felt, i.any = true, i.felts.drop();
  if (i.any)
    if (const ForceModel* model = i.maker.make(now_ns, i.there.tip_mm, i.there.felt)) i.models.push(*model);
  i.queue.poll(now_ns, sink);
}

SourceCounts WaitedForceSource::counts() const {
  return {impl_->queue.handed_over(), impl_->port->malformed(), impl_->lost.load(std::memory_order_relaxed)};
}

std::string WaitedForceSource::health() const {
  const Impl& i = *impl_;
  return fmt::format(
      "{}, {}, force {:.2f} N, {} answers, {} saturated, {} with an old model, {} damped, least energy {:.2f} mJ",
      i.port->says(), i.real_time.load() ? "real-time priority" : "ordinary priority", i.force_N.load(), i.ticks.load(),
      i.saturated.load(), i.stale.load(), i.damped.load(), i.least_mJ.load());
}

}  // namespace limberg
