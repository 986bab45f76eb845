#include "devices/lcm_net_source.h"

#include <time.h>

#include <algorithm>
#include <atomic>
#include <thread>

#include "devices/heard_streams.h"
#include "devices/lcm_library.h"
#include "devices/lcm_local_link.h"
#include "devices/lcm_publisher.h"
#include "devices/message_codec.h"
#include "devices/monotonic.h"
#include "devices/sample_queue.h"
#include "sim/base/error.h"

namespace limberg {

namespace {

constexpr size_t kMostCommands = 10'000;  // of a session

}  // namespace

struct LcmNetSource::Impl {
  Impl(const LcmNetSettings& settings, const SourceTime& t) : time(t), queue(settings.ring) {
    if (!settings.allow_other_networks && settings.url.starts_with("udpm://")) {
      local = std::make_unique<LcmLocalLink>(settings.url);
      return;
    }
    library = open_lcm(settings.url);
    for (const std::string_view c : {kStylusChannel, kControlChannel, kCommandChannel, kTrackerChannel})
      library->listen_to(std::string(c));
  }

  // ---- the receiving thread ----

  void on_packet(std::string_view channel, const uint8_t* data, size_t n) {
    if (channel == kStylusChannel)
      take<limberg_msg::stylus_t, StylusSample>(data, n);
    else if (channel == kControlChannel)
      take<limberg_msg::control_t, ControlSample>(data, n);
    else if (channel == kCommandChannel)
      take<limberg_msg::command_t, CommandSample>(data, n);
    else if (channel == kTrackerChannel)
      take<limberg_msg::tracker_t, TrackerSample>(data, n);
  }

  template <class M, class S>
  void take(const uint8_t* data, size_t n) {
    M m;
    S s;
    bool has_checksum = false;
    if (decode_message(data, n, m, &has_checksum) || to_sample(m, s, true)) {
      malformed.fetch_add(1, std::memory_order_relaxed);
      return;
    }
    [[maybe_unused]] const int64_t sent_ns = s.t_ns;
    const int64_t wall_ns = time.wall_ns(monotonic_ns());
    s.t_ns = time.stamp_ns(wall_ns);
    // The sender's clock is not ours, but how old the reading was when it was sent is known by it alone.
    if constexpr (std::is_same_v<S, TrackerSample>)
      s.true_ns = time.stamp_ns(wall_ns - std::clamp<int64_t>(sent_ns - s.true_ns, 0, kOldestReadingNs));
    const std::pair<int, int32_t> stream{stream_of(s), s.device_id};
    int64_t gap = 0;
    if (!heard.take(stream, s.seq, wall_ns, has_checksum, gap)) {
      malformed.fetch_add(1, std::memory_order_relaxed);
      return;
    }
    lost.fetch_add(gap, std::memory_order_relaxed);
    if constexpr (std::is_same_v<S, CommandSample>) {  // kept, so that the device thread frees none
      if (commands.size() >= kMostCommands) {
        lost.fetch_add(1, std::memory_order_relaxed);
        return;
      }
      commands.push_back(s.command);
    }
    if (!queue.push(s)) lost.fetch_add(1, std::memory_order_relaxed);
  }

  void listen() {
    const auto take_packet = [this](std::string_view c, const uint8_t* d, size_t n) { on_packet(c, d, n); };
    while (!stop.load(std::memory_order_acquire)) {
      const bool whole = local ? local->receive(50, take_packet) : library->receive(50, take_packet);
      if (local) foreign.store(local->foreign(), std::memory_order_relaxed);
      if (!whole) {
        // The socket is broken. Say so through the counts and do not spin.
        malformed.fetch_add(1, std::memory_order_relaxed);
        const timespec pause{0, 50'000'000};
        nanosleep(&pause, nullptr);
      }
    }
  }

  std::unique_ptr<LcmLocalLink> local;  // one of the two
  std::unique_ptr<LcmLibrary> library;
  const SourceTime time;
  HeardStreams heard;  // of the receiving thread alone, as are the commands
  std::vector<std::shared_ptr<const Command>> commands;
  SampleQueue queue;
  std::atomic<int64_t> malformed{0}, lost{0}, foreign{0};
  std::atomic<bool> stop{false};
  std::thread thread;
};

LcmNetSource::LcmNetSource(const LcmNetSettings& settings, const SourceTime& time) {
  if (!settings.allow_other_networks && !stays_here(settings.url))
    throw InputError(
        "", 0,
        "LCM address \"" + settings.url +
            "\" may reach other machines; expected udpm://239.255.76.67:7667?ttl=0 or explicit leave to listen there");
  impl_ = std::make_unique<Impl>(settings, time);
  impl_->thread = std::thread([this] { impl_->listen(); });
}

LcmNetSource::~LcmNetSource() {
  if (!impl_ || !impl_->thread.joinable()) return;
  impl_->stop.store(true, std::memory_order_release);
  impl_->thread.join();
}

void LcmNetSource::poll(int64_t now_ns, SampleSink& sink) { impl_->queue.poll(now_ns, sink); }

std::string LcmNetSource::health() const {
  const int64_t n = impl_->foreign.load(std::memory_order_relaxed);
  if (!impl_->local) return impl_->library ? "also from other machines, if its address lets them" : "";
  return "this machine only" +
         (n > 0 ? ", " + std::to_string(n) + " packets of other machines refused" : std::string());
}

SourceCounts LcmNetSource::counts() const {
  return {impl_->queue.handed_over(), impl_->malformed.load(std::memory_order_relaxed),
          impl_->lost.load(std::memory_order_relaxed)};
}

}  // namespace limberg
