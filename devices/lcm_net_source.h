#pragma once
// A live stream over LCM: a thread of its own receives, decodes and checks; poll() takes from a ring and never waits.
//
// Packets are taken as bytes and checked before the packaged decoder sees them (size, fingerprint, version, finite
// numbers, sequence): that decoder can be made to fail by what it reads. Time stamps are those of arrival on this
// machine, by the session's time (session_time.h), because the sender's clock is not ours. A sender may stop and come
// back. From this machine alone, unless other networks are allowed: lcm_local_link.h.
#include <memory>
#include <string>

#include "devices/session_time.h"
#include "devices/source.h"

namespace limberg {

struct LcmNetSettings {
  std::string url = "udpm://239.255.76.67:7667?ttl=0";  // this machine only
  bool allow_other_networks = false;  // anything but ttl=0 multicast or memq:// is refused unless this is set
  size_t ring = 4096;                 // samples that fit between two polls
};

class LcmNetSource final : public Source {
 public:
  /// Starts listening. InputError: a refused or unusable address (a network
  /// without a multicast route, for one: the message says which command helps).
  LcmNetSource(const LcmNetSettings& settings, const SourceTime& time);
  ~LcmNetSource() override;
  void poll(int64_t now_ns, SampleSink& sink) override;
  bool done() const override { return false; }
  SourceCounts counts() const override;
  std::string health() const override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace limberg
