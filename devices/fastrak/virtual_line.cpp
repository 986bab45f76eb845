#include "devices/fastrak/virtual_line.h"

#include <algorithm>

namespace limberg::fastrak {

namespace {
constexpr int64_t kTickNs = 1'000'000;
}

VirtualLine::VirtualLine(Motion motion, const LinkSettings& link, const EmulatorSettings& device)
    : device_(std::move(motion), device), link_(link), byte_delay_ns_(int64_t(33 * 1e10 / link.baud)) {
  link_.opened(0);
}

const std::vector<TrackerSample>& VirtualLine::tick(int64_t tick) {
  got_.clear();
  const int64_t now = tick * kTickNs;
  const std::vector<uint8_t> out = link_.take_output();
  device_.receive(out.data(), out.size(), now);
  // The last byte of a record comes so long after it was ready.
  const std::vector<uint8_t> in = device_.send(now - byte_delay_ns_);
  link_.receive(in.data(), in.size(), now, *this);
  link_.tick(now);
  return got_;
}

std::vector<Sample> readings_of(Motion motion, double seconds, const LinkSettings& link,
                                const EmulatorSettings& device) {
  VirtualLine line(std::move(motion), link, device);
  std::vector<Sample> all;
  int64_t last = -1;
  for (int64_t tick = 0; tick < int64_t(seconds * 1000); ++tick)
    for (TrackerSample s : line.tick(tick)) {
      s.t_ns = last = std::max(s.t_ns, last + 1);
      all.push_back(s);
    }
  return all;
}

}  // namespace limberg::fastrak
