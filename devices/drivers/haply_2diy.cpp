// A driver (driver/limberg_driver.h) of the Haply 2DIY, a force device of two motors and a five-bar linkage that
// universities teach with: --device driver:build/drivers/haply-2diy.so,PORT[,level=MM][,links=A/B/C][,gain=G]
//
// Its board's protocol is public (HaplyHaptics/Haply-API-cpp, Board.cpp and Device.cpp, 2017 to 2019). The host speaks:
//   set up   0x03, device number, and for each encoder its offset in degrees and its counts a turn
//   torque   0x13, device number, the torque of each motor
// and to each torque the board answers with its device number and the angle of each encoder in degrees. The lower four
// bits of the first byte say which of four ports are in use, the upper ones what is asked. Numbers are 32-bit floats,
// little-endian, without a checksum: an answer counts when its number is right and the angles have moved as far as a
// hand can move them.
//
// The linkage hangs in a vertical plane, its motors above: scene x runs along the line between them, scene z up, and
// the effector is on the skin's level `level` mm below the motors. Kinematics of the five-bar linkage: Campion, Wang,
// Hayward, "The Pantograph Mk-II: a haptic instrument", IROS 2005. With the effector E, the elbows A and B:
//   (E - A) . dE = (E - A) . dA,   (E - B) . dE = (E - B) . dB,   torque = J^T force,   J = dE / d angles
// How many N m the board makes of a number depends on motors and firmware: `gain` is what one N m is sent as.
#include <fcntl.h>
#include <poll.h>
#include <sys/file.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <new>
#include <string>

#include "devices/driver/limberg_driver.h"
#include "devices/drivers/haply_line.h"

namespace {

using haply::kDevice;
constexpr uint8_t kSetUp = 0x03, kTorque = 0x13;  // ports 1 and 2
constexpr float kOffset_deg[2] = {180, 360}, kCounts = 13'824;
constexpr double kMostTorque_Nm = 0.3;
constexpr int64_t kAskAgainNs = 20'000'000;

int64_t now_ns() {
  timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return int64_t(t.tv_sec) * 1'000'000'000 + t.tv_nsec;
}

struct Haply {
  int fd = -1;
  haply::Answers answers;
  double level_mm = 85, gain = 1;
  bool asked = false;
  int64_t asked_ns = 0;

  ~Haply() {
    if (fd >= 0) ::close(fd);
  }

  bool send(uint8_t what, const float* value, size_t values) {
    uint8_t bytes[2 + 16];
    bytes[0] = what, bytes[1] = kDevice;
    std::memcpy(bytes + 2, value, 4 * values);  // of a little-endian machine
    size_t sent = 0;
    for (const size_t all = 2 + 4 * values; sent < all;) {
      const ssize_t k = ::write(fd, bytes + sent, all - sent);
      if (k < 0 && errno != EAGAIN && errno != EINTR) return false;
      if (k > 0) sent += size_t(k);
      pollfd p{fd, POLLOUT, 0};
      if (sent < all && ::poll(&p, 1, 5) <= 0) break;
    }
    return true;
  }

  bool torque(double t1_Nm, double t2_Nm) {
    const float t[2] = {float(gain * std::fmin(kMostTorque_Nm, std::fmax(-kMostTorque_Nm, t1_Nm))),
                        float(gain * std::fmin(kMostTorque_Nm, std::fmax(-kMostTorque_Nm, t2_Nm)))};
    asked = true, asked_ns = now_ns();
    return send(kTorque, t, 2);
  }
};

bool set_option(Haply& h, const std::string& option) {
  const char* text = option.c_str();
  int end = 0;
  haply::Linkage& l = h.answers.linkage;
  if (std::sscanf(text, "level=%lf%n", &h.level_mm, &end) == 1 && !text[end]) return std::abs(h.level_mm) < 1000;
  if (std::sscanf(text, "gain=%lf%n", &h.gain, &end) == 1 && !text[end]) return std::abs(h.gain) < 1000;
  if (std::sscanf(text, "links=%lf/%lf/%lf%n", &l.a_mm, &l.b_mm, &l.apart_mm, &end) == 3 && !text[end])
    return l.a_mm > 5 && l.b_mm > 5 && l.apart_mm >= 0 && l.a_mm + l.b_mm + l.apart_mm < 1000;
  return false;
}

bool open_line(Haply& h, const std::string& port, std::string& why) {
  h.fd = ::open(port.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  termios t{};
  if (h.fd < 0 || tcgetattr(h.fd, &t) != 0)
    return why = port + ": " + (h.fd < 0 ? std::strerror(errno) : "not a serial port"), false;
  cfmakeraw(&t);
  t.c_cflag |= CLOCAL | CREAD;
  cfsetispeed(&t, B115200), cfsetospeed(&t, B115200);  // of a USB line: no more than a word
  if (tcsetattr(h.fd, TCSANOW, &t) != 0 || flock(h.fd, LOCK_EX | LOCK_NB) != 0)
    return why = port + (errno == EWOULDBLOCK ? ": another program has it open" : ": cannot be set up"), false;
  const float parameters[4] = {kOffset_deg[0], kCounts, kOffset_deg[1], kCounts};
  if (!h.send(kSetUp, parameters, 4)) return why = port + ": takes nothing", false;
  const timespec pause{0, 50'000'000};  // what it says to that is none of the angles
  nanosleep(&pause, nullptr);
  tcflush(h.fd, TCIFLUSH);
  return true;
}

}  // namespace

uint32_t limberg_driver_abi(void) { return LIMBERG_DRIVER_ABI; }

void* limberg_driver_open(const char* options, char* why, size_t why_size) {
  auto* h = new (std::nothrow) Haply;
  if (!h) return nullptr;
  std::string said, rest = options, port;
  for (size_t at = 0; said.empty() && at <= rest.size();) {
    const size_t comma = std::min(rest.find(',', at), rest.size());
    const std::string word = rest.substr(at, comma - at);
    if (at == 0)
      port = word;
    else if (!set_option(*h, word))
      said = "\"" + word + "\" is no option of it; expected level=MM, links=A/B/C or gain=G";
    at = comma + 1;
  }
  if (said.empty() && port.empty()) said = "no port; expected one as in driver:haply-2diy.so,/dev/ttyACM0";
  if (said.empty() && open_line(*h, port, said)) return h;
  std::snprintf(why, why_size, "%s", said.c_str());
  delete h;
  return nullptr;
}

void limberg_driver_describe(void*, struct limberg_driver_description* d) {
  d->gives_force = 1;
  std::snprintf(d->name, sizeof d->name, "Haply 2DIY");
  d->peak_force_N = 2;  // with its 0.3 N m at bars of 50 mm it gives more nowhere for long
  d->stiffness_N_mm = 0.7, d->damping_N_s_mm = 0.001, d->delay_ms = 1;
  const double x[2] = {-60, 60}, z[2] = {-30, 50};
  for (int i = 0; i < 2; ++i) d->workspace_mm[0][i] = x[i], d->workspace_mm[2][i] = z[i];
}

int limberg_driver_read_pose(void* device, int wait_ms, struct limberg_driver_pose* pose) {
  Haply& h = *static_cast<Haply*>(device);
  const int64_t end = now_ns() + int64_t(wait_ms) * 1'000'000;
  // It speaks when it is spoken to. A word that was lost is said again, with no torque.
  if ((!h.asked || now_ns() - h.asked_ns > kAskAgainNs) && !h.torque(0, 0)) return LIMBERG_DRIVER_GONE;
  bool fresh = false;
  do {
    pollfd p{h.fd, POLLIN, 0};
    const int ready = ::poll(&p, 1, int(std::max<int64_t>(0, (end - now_ns() + 999'999) / 1'000'000)));
    if (ready > 0) {
      uint8_t bytes[64];
      const ssize_t got = ::read(h.fd, bytes, sizeof bytes);
      if (got == 0 || (got < 0 && errno != EAGAIN && errno != EINTR)) return LIMBERG_DRIVER_GONE;
      for (ssize_t i = 0; i < got; ++i) fresh |= h.answers.take(bytes[i], now_ns());
    }
  } while (!fresh && now_ns() < end);
  if (!fresh) return LIMBERG_DRIVER_NOTHING;
  h.asked = false;
  const haply::Linkage& l = h.answers.linkage;
  pose->tip_mm[0] = l.x_mm - l.apart_mm / 2;
  pose->tip_mm[1] = 0;
  pose->tip_mm[2] = h.level_mm - l.y_mm;
  return LIMBERG_DRIVER_OK;
}

int limberg_driver_write_force(void* device, const double force_N[3]) {
  Haply& h = *static_cast<Haply*>(device);
  // Scene x is the linkage's, scene z against its y; what pushes out of its plane it cannot give. mm to m.
  const double fx = force_N[0], fy = -force_N[2];
  const auto& j = h.answers.linkage.jacobian;
  return h.torque((j[0][0] * fx + j[1][0] * fy) * 1e-3, (j[0][1] * fx + j[1][1] * fy) * 1e-3) ? LIMBERG_DRIVER_OK
                                                                                              : LIMBERG_DRIVER_GONE;
}

void limberg_driver_close(void* device) {
  Haply* h = static_cast<Haply*>(device);
  h->torque(0, 0);
  delete h;
}
