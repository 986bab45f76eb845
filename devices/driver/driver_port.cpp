#include "devices/driver/driver_port.h"

#include <dlfcn.h>
#include <time.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>

#include "devices/monotonic.h"
#include "sim/base/error.h"

namespace limberg {

namespace {

constexpr const char* kHeaderOfDrivers = "devices/driver/limberg_driver.h";
constexpr double kReachMm = 10'000;

[[noreturn]] void refuse_driver(const std::string& path, const std::string& why) {
  throw InputError("", 0, "--device driver:" + path + ": " + why);
}

/// Of a text that a driver wrote, and may not have ended.
template <size_t N>
std::string text_of(const char (&text)[N]) {
  std::string s(text, strnlen(text, N));
  for (char& c : s)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) c = ' ';
  return s;
}

/// What was said, or what stands for nothing said; outside of what can be: NaN.
double said_or(double value, double otherwise, double most) {
  if (value == 0) return otherwise;
  return value > 0 && value <= most ? value : std::nan("");
}

bool is_pose(const limberg_driver_pose& p) {
  double qq = 0;
  for (const double v : p.quat) qq += v * v;
  for (const double v : p.tip_mm)
    if (!std::isfinite(v) || std::abs(v) > kReachMm) return false;
  return std::isfinite(qq) && std::abs(qq - 1) < 0.02;
}

void pause_ms(int ms) {
  const timespec pause{0, long(ms) * 1'000'000};
  nanosleep(&pause, nullptr);
}

}  // namespace

DriverFunctions load_driver(const std::string& path) {
  std::error_code ec;
  const auto file = std::filesystem::canonical(path, ec);  // never a name that the loader looks for somewhere
  if (path.empty() || ec || !std::filesystem::is_regular_file(file, ec))
    refuse_driver(path, "no such file; expected a shared library, a driver by " + std::string(kHeaderOfDrivers));
  void* const library = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!library) {
    const char* const why = dlerror();
    refuse_driver(path, "cannot be loaded (" + std::string(why ? why : "no reason given") +
                            "); expected a shared library for this machine");
  }
  std::string missing;
  const auto find = [&](const char* name) {
    void* const found = dlsym(library, name);
    if (!found) missing += (missing.empty() ? "" : ", ") + std::string(name);
    return found;
  };
  const auto abi = reinterpret_cast<decltype(&limberg_driver_abi)>(find("limberg_driver_abi"));
  if (!abi) refuse_driver(path, "no driver: it has no " + missing + "; expected one by " + kHeaderOfDrivers);
  if (const uint32_t version = abi(); version != LIMBERG_DRIVER_ABI)
    refuse_driver(path, "a driver of version " + std::to_string(version) + "; expected version " +
                            std::to_string(LIMBERG_DRIVER_ABI) + ": build it anew with " + kHeaderOfDrivers);
  DriverFunctions f;
  f.path = path;
  f.open = reinterpret_cast<decltype(f.open)>(find("limberg_driver_open"));
  f.describe = reinterpret_cast<decltype(f.describe)>(find("limberg_driver_describe"));
  f.read_pose = reinterpret_cast<decltype(f.read_pose)>(find("limberg_driver_read_pose"));
  f.close = reinterpret_cast<decltype(f.close)>(find("limberg_driver_close"));
  f.write_force = reinterpret_cast<decltype(f.write_force)>(dlsym(library, "limberg_driver_write_force"));
  if (!missing.empty()) refuse_driver(path, "it has no " + missing + "; expected all functions of " + kHeaderOfDrivers);
  return f;
}

DriverPort::DriverPort(const DriverFunctions& driver, const std::string& options, int32_t device_id)
    : driver_(driver), options_(options), device_id_(device_id) {
  std::string why;
  if (!open(why)) refuse_driver(driver_.path, "its device cannot be had: " + why);
  limberg_driver_description d{};
  d.size = sizeof d;
  driver_.describe(device_, &d);
  name_ = text_of(d.name);
  gives_force_ = d.gives_force != 0;
  const ForceLimits usual;
  limits_.force_N = said_or(d.peak_force_N, usual.force_N, 100);
  limits_.stiffness_N_mm = said_or(d.stiffness_N_mm, usual.stiffness_N_mm, 1000);
  limits_.damping_N_s_mm = said_or(d.damping_N_s_mm, usual.damping_N_s_mm, 1);
  const double own = said_or(d.own_damping_N_s_mm, 0.0005, 1), delay_ms = said_or(d.delay_ms, 0, 30);
  limits_.delay_s = delay_ms * 1e-3;
  limits_.stiffness_N_mm =
      std::min(limits_.stiffness_N_mm, stable_stiffness_N_mm(own, limits_.damping_N_s_mm, delay_ms * 1e-3));
  if (std::isnan(limits_.force_N + limits_.stiffness_N_mm + limits_.damping_N_s_mm + own + delay_ms) ||
      (gives_force_ && !driver_.write_force)) {
    driver_.close(device_);
    refuse_driver(driver_.path,
                  gives_force_ && !driver_.write_force
                      ? "it says that its device gives forces, and has no limberg_driver_write_force; expected it"
                      : "what it says of its device cannot be; expected a peak force up to 100 N, a stiffness up to "
                        "1000 N/mm, dampings up to 1 N s/mm and a delay up to 30 ms");
  }
}

DriverPort::~DriverPort() {
  if (device_) driver_.close(device_);
}

bool DriverPort::open(std::string& why) {
  std::array<char, 256> said{};
  device_ = driver_.open(options_.c_str(), said.data(), said.size());
  there_.store(device_ != nullptr, std::memory_order_relaxed);
  char text[256];
  std::memcpy(text, said.data(), said.size());
  why = text_of(text);
  if (!device_ && why.empty()) why = "no reason given; expected another device or other options";
  return device_ != nullptr;
}

void DriverPort::gone() {
  constexpr int64_t kRetryNs = 1'000'000'000;
  driver_.close(device_);
  device_ = nullptr;
  there_.store(false, std::memory_order_relaxed);
  unplugged_.fetch_add(1, std::memory_order_relaxed);
  next_try_ns_ = monotonic_ns() + kRetryNs;
}

bool DriverPort::read(int wait_ms, PortReading& reading) {
  if (!device_) {
    std::string why;
    if (monotonic_ns() < next_try_ns_ || !open(why)) {
      if (monotonic_ns() >= next_try_ns_) next_try_ns_ = monotonic_ns() + 1'000'000'000;
      return pause_ms(wait_ms), false;
    }
  }
  limberg_driver_pose p{};
  p.size = sizeof p;
  p.quat[0] = 1;
  const int got = driver_.read_pose(device_, wait_ms, &p);
  if (got == LIMBERG_DRIVER_GONE) return gone(), false;
  if (got != LIMBERG_DRIVER_OK) return false;
  if (!is_pose(p)) return malformed_.fetch_add(1, std::memory_order_relaxed), false;
  reading.pose.valid = true;
  reading.pose.tip_mm = Vec3(p.tip_mm[0], p.tip_mm[1], p.tip_mm[2]);
  for (int i = 0; i < 4; ++i) reading.pose.quat[size_t(i)] = p.quat[i];
  reading.pose.buttons = p.buttons;
  reading.device_id = device_id_, reading.seq = seq_++, reading.came_ns = monotonic_ns();
  return true;
}

void DriverPort::answer(const PortReading&, bool valid, const ForceState& felt, int64_t) {
  if (!device_ || !gives_force_) return;
  double force[3] = {0, 0, 0};
  for (int i = 0; i < 3 && valid; ++i) force[i] = felt.force_N[i];
  if (driver_.write_force(device_, force) == LIMBERG_DRIVER_GONE) gone();
}

std::string DriverPort::says() const {
  const int64_t n = unplugged_.load(std::memory_order_relaxed);
  return name_ + (gives_force_ ? "" : ", gives no force") + (there_.load(std::memory_order_relaxed) ? "" : ", gone") +
         (n > 0 ? ", unplugged " + std::to_string(n) + " times" : std::string());
}

}  // namespace limberg
