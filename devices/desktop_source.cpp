#include "devices/desktop_source.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <thread>

#include "devices/monotonic.h"
#include "devices/sample_queue.h"
#include "sim/geometry/rotation.h"

namespace limberg {

namespace {

constexpr double kFullPush = 350;  // counts
constexpr int32_t kMostCounts = 100'000;

/// A light push is precise.
double curve(double counts) {
  const double s = std::clamp(counts / kFullPush, -1.0, 1.0);
  return s * std::abs(s);
}

}  // namespace

void DesktopDecoder::feed(const uint8_t* bytes, size_t n) {
  const size_t size = set_.kind == DesktopSettings::mouse ? 3 : 32;
  for (size_t i = 0; i < n; ++i) {
    // The first byte of a mouse's packet has bit 3 set: what has not is no beginning.
    if (set_.kind == DesktopSettings::mouse && n_ == 0 && !(bytes[i] & 8)) {
      ++malformed_;
      continue;
    }
    byte_[n_++] = bytes[i];
    if (n_ == size) packet(), n_ = 0;
  }
}

void DesktopDecoder::packet() {
  const auto set_button = [&](uint32_t bit, bool down) {
    pose_.buttons = down ? pose_.buttons | bit : pose_.buttons & ~bit;
  };
  if (set_.kind == DesktopSettings::mouse) {
    const int dx = int(byte_[1]) - (byte_[0] & 0x10 ? 256 : 0), dy = int(byte_[2]) - (byte_[0] & 0x20 ? 256 : 0);
    if (!(byte_[0] & 0xC0)) {  // no overflow
      pose_.tip_mm.x() = std::clamp(pose_.tip_mm.x() + set_.mm_per_count * dx, -set_.box_mm, set_.box_mm);
      pose_.tip_mm.y() = std::clamp(pose_.tip_mm.y() + set_.mm_per_count * dy, -set_.box_mm, set_.box_mm);
    }
    set_button(1, byte_[0] & 1), set_button(2, byte_[0] & 2);
    return;
  }
  int32_t v[8];
  std::memcpy(v, byte_, sizeof v);
  if (v[0] == 0) {
    for (int i = 1; i < 7; ++i)
      if (v[i] < -kMostCounts || v[i] > kMostCounts) return void(++malformed_);
    // Its y points up and its z towards the user.
    push_ = Vec3(v[1], -v[3], v[2]), twist_ = Vec3(v[4], -v[6], v[5]);
  } else if (v[0] == 1 || v[0] == 2) {
    if (v[1] == 0 || v[1] == 1) set_button(v[1] == 0 ? 1 : 2, v[0] == 1);
  } else {
    ++malformed_;
  }
}

void DesktopDecoder::advance(double dt) {
  for (int i = 0; i < 3; ++i)
    pose_.tip_mm[i] = std::clamp(pose_.tip_mm[i] + curve(push_[i]) * set_.full_mm_s * dt, -set_.box_mm, set_.box_mm);
  const Vec3 w = Vec3(curve(twist_.x()), curve(twist_.y()), curve(twist_.z())) * (set_.full_rad_s * dt);
  if (const double a = w.norm(); a > 0) {
    const Eigen::Quaterniond q =
        (turn_about(a, w / a) * Eigen::Quaterniond(pose_.quat[0], pose_.quat[1], pose_.quat[2], pose_.quat[3]))
            .normalized();
    pose_.quat = {q.w(), q.x(), q.y(), q.z()};
  }
}

void DesktopDecoder::let_go() {
  push_ = twist_ = Vec3::Zero();
  pose_.buttons = 0;
  n_ = 0;
}

struct DesktopSource::Impl {
  Impl(const DesktopSettings& s, const SourceTime& t) : set(s), time(t), decoder(s), queue(1024) {
    if (set.path.empty()) {
      const char* socket = std::getenv("SPNAV_SOCKET");
      set.path = set.kind == DesktopSettings::mouse ? "/dev/input/mice" : socket ? socket : "/var/run/spnav.sock";
    }
  }

  int connect_to() {
    if (set.kind == DesktopSettings::mouse) return ::open(set.path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
    sockaddr_un a{};
    a.sun_family = AF_UNIX;
    if (set.path.size() >= sizeof a.sun_path) return errno = ENAMETOOLONG, -1;
    std::memcpy(a.sun_path, set.path.c_str(), set.path.size() + 1);
    const int fd = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (fd >= 0 && ::connect(fd, reinterpret_cast<const sockaddr*>(&a), sizeof a) != 0) {
      const int why = errno;
      ::close(fd);
      return errno = why, -1;
    }
    return fd;
  }

  void tell(const std::string& words) {
    const std::lock_guard lock(mutex);
    said = words;
  }

  void run() {
    constexpr int64_t kPeriodNs = 8'000'000, kRetryNs = 500'000'000;
    int fd = -1;
    int64_t next_try = 0, last = monotonic_ns(), next_sample = 0, seq = 0;
    while (!stop.load(std::memory_order_acquire)) {
      const int64_t now = monotonic_ns();
      if (fd < 0 && now >= next_try) {
        next_try = now + kRetryNs;
        fd = connect_to();
        tell(fd >= 0 ? "connected to " + set.path : set.path + ": " + std::strerror(errno));
        last = next_sample = now;
      }
      if (fd < 0) {
        const timespec pause{0, 20'000'000};
        nanosleep(&pause, nullptr);
        continue;
      }
      pollfd p{fd, POLLIN, 0};
      ::poll(&p, 1, 4);
      uint8_t bytes[256];
      const ssize_t n = p.revents ? ::read(fd, bytes, sizeof bytes) : 0;
      if (p.revents && (n == 0 || (n < 0 && errno != EAGAIN && errno != EINTR))) {
        ::close(fd);
        fd = -1;
        decoder.let_go();
        tell("gone");
      } else if (n > 0) {
        decoder.feed(bytes, size_t(n));
      }
      const int64_t t = monotonic_ns();
      decoder.advance(double(t - last) * 1e-9);
      last = t;
      malformed.store(decoder.malformed(), std::memory_order_relaxed);
      if (t < next_sample && fd >= 0) continue;
      next_sample = std::max(next_sample + kPeriodNs, t);
      StylusSample s = decoder.pose();
      s.seq = seq++;
      s.t_ns = time.stamp_ns(time.wall_ns(t));
      if (!queue.push(s)) lost.fetch_add(1, std::memory_order_relaxed);
    }
    if (fd >= 0) ::close(fd);
  }

  DesktopSettings set;
  const SourceTime time;
  DesktopDecoder decoder;  // of the reading thread alone
  SampleQueue queue;
  std::atomic<int64_t> malformed{0}, lost{0};
  mutable std::mutex mutex;
  std::string said = "not looked for yet";
  std::atomic<bool> stop{false};
  std::thread thread;
};

DesktopSource::DesktopSource(const DesktopSettings& settings, const SourceTime& time)
    : impl_(std::make_unique<Impl>(settings, time)) {
  impl_->thread = std::thread([this] { impl_->run(); });
}
DesktopSource::~DesktopSource() {
  impl_->stop.store(true, std::memory_order_release);
  impl_->thread.join();
}
void DesktopSource::poll(int64_t now_ns, SampleSink& sink) { impl_->queue.poll(now_ns, sink); }
SourceCounts DesktopSource::counts() const {
  return {impl_->queue.handed_over(), impl_->malformed.load(std::memory_order_relaxed),
          impl_->lost.load(std::memory_order_relaxed)};
}
std::string DesktopSource::health() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->said;
}

}  // namespace limberg
