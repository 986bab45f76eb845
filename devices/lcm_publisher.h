#pragma once
// Samples onto LCM, for other programs: what a device says here,
// whoever listens there has (LcmNetSource is one of them).
//
// Publishing is a call into the kernel, 7 to 19 us each: never from the
// device thread. `limberg devices --publish` does it from a loop of its own.
#include <memory>
#include <string>

#include "devices/sample.h"

namespace limberg {

class LcmLibrary;

class LcmPublisher {
 public:
  /// InputError: an address that leaves this machine and
  /// `allow_other_networks` is not set, or one that cannot be opened.
  LcmPublisher(const std::string& url, bool allow_other_networks);
  ~LcmPublisher();
  /// Stylus, tracker and control samples; bytes as they came stay here. False: not sent.
  bool publish(const Sample& sample);
  int64_t sent() const { return sent_; }

 private:
  std::unique_ptr<LcmLibrary> lcm_;
  int64_t sent_ = 0;
};

/// Whether an LCM address keeps what is sent to it on this machine: memory, or multicast with a time to live of 0.
bool stays_here(const std::string& lcm_url);

}  // namespace limberg
