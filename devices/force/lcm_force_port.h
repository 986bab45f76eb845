#pragma once
// A force device in another process of this machine, over LCM: its poses come as LIMBERG_STYLUS, as those of any stylus
// do, and each is answered by a LIMBERG_FORCE that names it (messages/force_t.lcm). Clients for a laboratory to begin
// with lie in devices/clients.
//
// The first stylus that is heard has the forces; another may have them when it has been silent for a second. Only what
// this machine sends is heard (lcm_local_link.h). Of several poses that have come the newest is answered.
#include <atomic>
#include <memory>

#include "devices/force/force_port.h"
#include "devices/heard_streams.h"
#include "devices/lcm_local_link.h"
#include "devices/session_time.h"

namespace limberg {

class LcmLibrary;

/// Of a device of which nothing is said: its next tick gives the force, so that it is a millisecond late, and what it
/// holds by itself then, with a damping of 0.0005 N s/mm of its own.
ForceLimits limits_over_lcm();

class LcmForcePort final : public ForcePort {
 public:
  /// InputError: an address that leaves this machine, or that cannot be opened.
  LcmForcePort(const std::string& url, const SourceTime& time, const ForceLimits& limits = limits_over_lcm());
  ~LcmForcePort() override;
  bool read(int wait_ms, PortReading& reading) override;
  void answer(const PortReading& reading, bool valid, const ForceState& felt, int64_t now_ns) override;
  ForceLimits limits() const override { return limits_; }
  std::string says() const override;
  int64_t malformed() const override { return malformed_.load(std::memory_order_relaxed); }

 private:
  void take(const uint8_t* data, size_t n);
  LcmLocalLink link_;
  std::unique_ptr<LcmLibrary> out_;
  const SourceTime time_;
  const ForceLimits limits_;
  const std::string channel_;
  HeardStreams heard_;
  PortReading newest_;
  bool fresh_ = false;
  int64_t seq_ = 0;
  std::atomic<int64_t> malformed_{0}, others_{0}, unsent_{0};
};

}  // namespace limberg
