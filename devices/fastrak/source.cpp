#include "devices/fastrak/source.h"

#include <time.h>

#include <algorithm>
#include <atomic>
#include <charconv>
#include <mutex>
#include <thread>

#include "devices/fastrak/port.h"
#include "devices/monotonic.h"
#include "devices/sample_queue.h"
#include "sim/base/error.h"

namespace limberg::fastrak {

SourceSettings parse_source(const std::string& text) {
  SourceSettings s;
  size_t at = 0;
  for (int part = 0; at <= text.size(); ++part) {
    const size_t comma = std::min(text.find(',', at), text.size());
    const std::string word = text.substr(at, comma - at);
    at = comma + 1;
    int baud = 0;
    if (part == 0) {
      if (word.empty()) throw InputError("", 0, "a fastrak without a port; expected fastrak:/dev/ttyS0 or the like");
      s.path = word;
    } else if (word == "ascii" || word == "binary") {
      s.link.binary = word == "binary";
    } else if (!word.empty() && word[0] >= '0' && word[0] <= '9') {
      const auto end = std::from_chars(word.data(), word.data() + word.size(), baud);
      if (end.ptr != word.data() + word.size() || !known_baud(baud))
        throw InputError(
            "", 0,
            "\"" + word + "\" is no rate of a fastrak; expected 2400, 4800, 9600, 19200, 38400, 57600 or 115200");
      s.link.baud = baud;
    } else {
      s.link.role = parse_roles(word);
    }
  }
  return s;
}

struct FastrakSource::Impl final : Link::Receiver {
  Impl(const SourceSettings& s, const SourceTime& t)
      : settings(s), time(t), link(s.link), queue(s.queue), path(s.path) {}

  int64_t now() const { return time.wall_ns(monotonic_ns()); }  // the line's own times are the wall's

  void on_reading(const TrackerSample& read) override {
    TrackerSample sample = read;
    sample.t_ns = time.stamp_ns(read.t_ns), sample.true_ns = time.stamp_ns(read.true_ns);
    if (!queue.push(sample)) lost.fetch_add(1, std::memory_order_relaxed);
  }

  void keep_raw(const uint8_t* bytes, size_t n, int64_t now_ns) {
    for (size_t at = 0; settings.raw && at < n; at += 64) {
      RawSample r;
      r.device_id = settings.link.device_id;
      r.seq = raw_seq++;
      r.t_ns = time.stamp_ns(now_ns);
      r.n = int32_t(std::min<size_t>(64, n - at));
      std::copy_n(bytes + at, r.n, r.bytes.begin());
      if (!queue.push(r)) lost.fetch_add(1, std::memory_order_relaxed);
    }
  }

  void tell(const std::string& words) {
    const std::lock_guard lock(mutex);
    said = words;
  }

  void run() {
    SerialPort port;
    int64_t next_try_ns = 0, next_words_ns = 0;
    while (!stop.load(std::memory_order_acquire)) {
      const int64_t t = now();
      if (!port.is_open()) {
        std::string where;
        {
          const std::lock_guard lock(mutex);
          where = path;
        }
        if (t >= next_try_ns && port.open(where, settings.link.baud)) {
          link.opened(now());
        } else {
          if (t >= next_try_ns) next_try_ns = t + 250'000'000, tell(where + ": " + port.why());
          const timespec pause{0, 20'000'000};
          nanosleep(&pause, nullptr);
          continue;
        }
      }
      uint8_t bytes[256];
      const int n = port.read(bytes, sizeof bytes, 5);
      const int64_t read_ns = now();
      if (n > 0) keep_raw(bytes, size_t(n), read_ns), link.receive(bytes, size_t(n), read_ns, *this);
      if (n >= 0) link.tick(read_ns);
      const std::vector<uint8_t> out = link.take_output();
      if (n < 0 || (!out.empty() && !port.write(out.data(), out.size()))) {
        unplugged.fetch_add(1, std::memory_order_relaxed);
        tell("unplugged");
        port.close();
        link.closed();
        next_words_ns = 0;
        continue;
      }
      malformed.store(link.counts().parser.damaged, std::memory_order_relaxed);
      if (read_ns >= next_words_ns) {
        next_words_ns = read_ns + 200'000'000;
        const Link::Counts c = link.counts();
        tell(std::string(link.phase_name()) + (link.status().empty() ? "" : ", \"" + link.status() + "\"") + ", " +
             std::to_string(c.readings) + " readings, " + std::to_string(c.parser.damaged) + " damaged, " +
             std::to_string(c.restarts) + " restarts, " + std::to_string(unplugged.load()) + " times unplugged");
      }
    }
  }

  const SourceSettings settings;
  const SourceTime time;
  Link link;  // of the reading thread alone
  SampleQueue queue;
  int64_t raw_seq = 0;
  std::atomic<int64_t> lost{0}, malformed{0}, unplugged{0};
  mutable std::mutex mutex;  // for the words below: never taken by the polling thread
  std::string path, said = "not looked for yet";
  std::atomic<bool> stop{false};
  std::thread thread;
};

FastrakSource::FastrakSource(const SourceSettings& settings, const SourceTime& time)
    : impl_(std::make_unique<Impl>(settings, time)) {
  impl_->thread = std::thread([this] { impl_->run(); });
}

FastrakSource::~FastrakSource() {
  impl_->stop.store(true, std::memory_order_release);
  impl_->thread.join();
}

void FastrakSource::poll(int64_t now_ns, SampleSink& sink) { impl_->queue.poll(now_ns, sink); }

SourceCounts FastrakSource::counts() const {
  return {impl_->queue.handed_over(), impl_->malformed.load(std::memory_order_relaxed),
          impl_->lost.load(std::memory_order_relaxed)};
}

std::string FastrakSource::health() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->said;
}

void FastrakSource::look_at(const std::string& path) {
  const std::lock_guard lock(impl_->mutex);
  impl_->path = path;
}

}  // namespace limberg::fastrak
