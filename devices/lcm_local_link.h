#pragma once
// LCM's multicast as this machine alone hears it. A time to live of 0 keeps what is sent here from leaving; it does
// not keep what others send from arriving, and the packaged library does not tell who sent. So packets are taken
// from a socket of our own, and those whose sender's address is none of this machine's are refused and counted.
//
// Only small packets: magic "LC02", a sequence number, the channel with
// its zero, the payload. Fragments of larger ones are none of ours.
#include <netinet/in.h>

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace limberg {

class LcmLocalLink {
 public:
  using Taker = std::function<void(std::string_view channel, const uint8_t* data, size_t n)>;

  /// "udpm://239.a.b.c[:port]?ttl=0". InputError: no such address, or no multicast route.
  explicit LcmLocalLink(const std::string& url);
  ~LcmLocalLink();
  LcmLocalLink(const LcmLocalLink&) = delete;
  LcmLocalLink& operator=(const LcmLocalLink&) = delete;

  /// Waits so long for packets and hands over those that are there. False: the socket is broken.
  bool receive(int wait_ms, const Taker& take);
  int64_t foreign() const { return foreign_; }  // packets of other machines

  /// The parts of a small packet; false when it is none.
  static bool parse(const uint8_t* packet, size_t n, std::string_view& channel, const uint8_t*& data, size_t& size);
  /// One of this machine's own addresses (asked anew when it is not known).
  bool is_own(in_addr address);

 private:
  void read_own_addresses();
  int fd_ = -1;
  std::vector<in_addr_t> own_;
  int64_t asked_ns_ = -1, foreign_ = 0;
  std::vector<uint8_t> packet_;
};

}  // namespace limberg
