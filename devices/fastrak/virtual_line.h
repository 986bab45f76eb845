#pragma once
// Emulator and link with the time of the line between them, in simulated time: what a known motion becomes on its way
// through the device, the line, the conversation and the time stamps.
#include <vector>

#include "devices/fastrak/emulator.h"
#include "devices/fastrak/link.h"

namespace limberg::fastrak {

class VirtualLine final : private Link::Receiver {
 public:
  VirtualLine(Motion motion, const LinkSettings& link, const EmulatorSettings& device);
  /// Readings that arrive by this millisecond; ticks must follow one another.
  const std::vector<TrackerSample>& tick(int64_t tick);
  Emulator& device() { return device_; }
  const Link& link() const { return link_; }

 private:
  void on_reading(const TrackerSample& s) override { got_.push_back(s); }
  Emulator device_;
  Link link_;
  int64_t byte_delay_ns_;
  std::vector<TrackerSample> got_;
};

/// Everything that comes of a motion in so many seconds, as a recording would hold it.
std::vector<Sample> readings_of(Motion motion, double seconds, const LinkSettings& link,
                                const EmulatorSettings& device = {});

}  // namespace limberg::fastrak
