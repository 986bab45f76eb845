#pragma once
// A force device whose readings are waited for: one in another process (lcm_force_port.h), or behind a maker's library
// that takes its time. A thread of its own waits (waited_source.h); the device thread never does.
#include <string>

#include "devices/force/force_device.h"

namespace limberg {

/// A reading with what its sender says of it, so that the answer can name it.
struct PortReading {
  ForceReading pose;
  int32_t device_id = 0;
  int64_t seq = -1, sent_ns = -1;  // as it was sent
  int64_t came_ns = -1;            // CLOCK_MONOTONIC
};

class ForcePort {
 public:
  virtual ~ForcePort() = default;
  /// Waits at most so long for the newest reading. False: none came, and `reading` is as it was.
  virtual bool read(int wait_ms, PortReading& reading) = 0;
  /// What is felt at that reading. `valid`: false where no reading came for long, and then there is no force.
  virtual void answer(const PortReading& reading, bool valid, const ForceState& felt, int64_t now_ns) = 0;
  virtual ForceLimits limits() const { return {}; }
  /// In a few words, from any thread.
  virtual std::string says() const = 0;
  /// Readings that were refused; from any thread.
  virtual int64_t malformed() const { return 0; }
};

}  // namespace limberg
