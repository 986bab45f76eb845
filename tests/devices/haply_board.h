#pragma once
// The board of a Haply 2DIY at the other end of a pseudo-terminal, with its linkage in a simulated hand: it knows the
// protocol from the public source only, and the linkage by its inverse kinematics, so that driver and board share
// nothing. Torques act on the hand by the angles' numerical derivatives (virtual work).
#include <fcntl.h>
#include <poll.h>
#include <pty.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cmath>
#include <cstring>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "devices/force/force_device.h"
#include "devices/monotonic.h"

namespace limberg::test {

class HaplyBoard {
 public:
  static constexpr double kUpper_mm = 50, kLower_mm = 70, kApart_mm = 20, kLevel_mm = 85;

  explicit HaplyBoard(const SimulatedHand& hand) : hand_(hand) {
    int slave = -1;
    char name[128] = "";
    if (openpty(&fd_, &slave, name, nullptr, nullptr) != 0) return;
    termios t{};
    tcgetattr(slave, &t), cfmakeraw(&t), tcsetattr(slave, TCSANOW, &t);
    ::close(slave);
    path = name;
    thread_ = std::thread([this] { run(); });
  }
  ~HaplyBoard() { unplug(); }
  void unplug() {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
    if (fd_ >= 0) ::close(fd_);
    fd_ = -1;
  }

  /// Angles in degrees at which the effector is there; scene axes, from the middle between the motors.
  static std::array<double, 2> angles(double x_mm, double z_mm) {
    const double x = x_mm + kApart_mm / 2, y = kLevel_mm - z_mm;
    std::array<double, 2> t;
    for (int i = 0; i < 2; ++i) {
      const double dx = x - (i == 0 ? 0 : kApart_mm), r = std::hypot(dx, y);
      const double elbow = std::acos((kUpper_mm * kUpper_mm + r * r - kLower_mm * kLower_mm) / (2 * kUpper_mm * r));
      t[size_t(i)] = (std::atan2(y, dx) + (i == 0 ? elbow : -elbow)) * 180 / M_PI;
    }
    return t;
  }
  /// Of torques in N m, on the effector in N.
  static Vec3 force(double x, double z, const std::array<float, 2>& torque) {
    constexpr double h = 1e-4;
    Vec3 f = Vec3::Zero();
    for (int i = 0; i < 2; ++i) {
      const size_t k = size_t(i);
      const double per_x = (angles(x + h, z)[k] - angles(x - h, z)[k]) / (2 * h) * M_PI / 180;
      const double per_z = (angles(x, z + h)[k] - angles(x, z - h)[k]) / (2 * h) * M_PI / 180;
      f += Vec3(per_x, 0, per_z) * double(torque[k]) * 1e3;  // rad / mm times N mm
    }
    return f;
  }

  std::string path;
  double noise = 0;  // share of bytes that the line damages
  std::atomic<int64_t> torques{0}, setups{0}, least_uJ{0}, depth_um{0};
  std::array<float, 4> setup() const {
    const std::lock_guard lock(mutex_);
    return setup_;
  }
  Vec3 felt_N() const {
    const std::lock_guard lock(mutex_);
    return felt_;
  }

 private:
  void run() {
    std::vector<uint8_t> got;
    const int64_t start = monotonic_ns();
    Vec3 x = Vec3::Zero(), force_now = Vec3::Zero();
    double energy_mJ = 0;
    bool first = true;
    uint64_t dice = 1;
    while (!stop_) {
      pollfd p{fd_, POLLIN, 0};
      ::poll(&p, 1, 1);
      uint8_t bytes[64];
      const ssize_t n = (p.revents & POLLIN) ? ::read(fd_, bytes, sizeof bytes) : 0;
      if (n > 0) got.insert(got.end(), bytes, bytes + n);
      const int64_t t_ns = monotonic_ns() - start;
      hand_.read(t_ns);
      const Vec3 at = hand_.true_mm();
      if (!first) energy_mJ -= force_now.dot(at - x);
      first = false, x = at;
      least_uJ = std::min(least_uJ.load(), int64_t(1e3 * energy_mJ));
      depth_um = int64_t(-1e3 * at.z());
      while (got.size() >= 2) {
        const size_t floats = got[0] == 0x03 ? 4 : got[0] == 0x13 ? 2 : 0;
        if (floats == 0 || got[1] != 5) {
          got.erase(got.begin());
          continue;
        }
        if (got.size() < 2 + 4 * floats) break;
        if (floats == 4) {
          const std::lock_guard lock(mutex_);
          std::memcpy(setup_.data(), got.data() + 2, 16), ++setups;
        } else {
          std::array<float, 2> torque;
          std::memcpy(torque.data(), got.data() + 2, 8);
          force_now = force(at.x(), at.z(), torque);
          hand_.push(force_now);
          {
            const std::lock_guard lock(mutex_);
            felt_ = force_now;
          }
          ++torques;
          std::array<uint8_t, 9> reply{5};
          const auto a = angles(at.x(), at.z());
          for (size_t i = 0; i < 2; ++i) {
            constexpr double kStep = 360.0 / 13'824;
            const float deg = float(std::round(a[i] / kStep) * kStep);
            std::memcpy(reply.data() + 1 + 4 * i, &deg, 4);
          }
          for (uint8_t& b : reply) {
            dice = dice * 6364136223846793005ull + 1442695040888963407ull;
            if (double(dice >> 11) * 0x1p-53 < noise) b ^= uint8_t(1u << ((dice >> 8) & 7));
          }
          [[maybe_unused]] const ssize_t sent = ::write(fd_, reply.data(), reply.size());
        }
        got.erase(got.begin(), got.begin() + long(2 + 4 * floats));
      }
    }
  }

  int fd_ = -1;
  SimulatedForceDevice hand_;
  mutable std::mutex mutex_;
  std::array<float, 4> setup_{};
  Vec3 felt_ = Vec3::Zero();
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace limberg::test
