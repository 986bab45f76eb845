#pragma once
// A device whose driver is a shared library of somebody else's (limberg_driver.h): --device driver:PATH[,OPTIONS].
//
// The library is loaded, its version and functions looked at, and the device opened when the session starts; whatever
// is missing is said and nothing is called. A device that is gone is closed and opened again each second. Poses that
// are none (not finite, further than 10 m, not turned by a unit quaternion) are refused and counted.
#include <atomic>
#include <memory>
#include <string>

#include "devices/driver/limberg_driver.h"
#include "devices/force/force_port.h"

namespace limberg {

/// The functions of a driver, once the library was found to be one. It stays loaded: drivers start threads.
struct DriverFunctions {
  decltype(&limberg_driver_open) open = nullptr;
  decltype(&limberg_driver_describe) describe = nullptr;
  decltype(&limberg_driver_read_pose) read_pose = nullptr;
  decltype(&limberg_driver_write_force) write_force = nullptr;  // null: it has none, and may give no force
  decltype(&limberg_driver_close) close = nullptr;
  std::string path;
};
/// InputError: no such file, no library, no driver, or one for another version.
DriverFunctions load_driver(const std::string& path);

class DriverPort final : public ForcePort {
 public:
  /// InputError: the device cannot be opened, in the driver's words; or what it says of itself cannot be.
  DriverPort(const DriverFunctions& driver, const std::string& options, int32_t device_id);
  ~DriverPort() override;
  bool read(int wait_ms, PortReading& reading) override;
  void answer(const PortReading& reading, bool valid, const ForceState& felt, int64_t now_ns) override;
  ForceLimits limits() const override { return limits_; }
  std::string says() const override;
  int64_t malformed() const override { return malformed_.load(std::memory_order_relaxed); }

 private:
  bool open(std::string& why);
  void gone();
  const DriverFunctions driver_;
  const std::string options_;
  const int32_t device_id_;
  ForceLimits limits_;
  std::string name_;
  bool gives_force_ = false;
  void* device_ = nullptr;
  int64_t seq_ = 0, next_try_ns_ = 0;
  std::atomic<int64_t> malformed_{0}, unplugged_{0};
  std::atomic<bool> there_{false};
};

}  // namespace limberg
