#pragma once
// LCM's own library, for addresses that reach other machines and for sending. It is a part of its own (sim/base/part.h,
// lcm/lcm_link.cpp): what this machine alone hears needs none (lcm_local_link.h).
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

namespace limberg {

class LcmLibrary {
 public:
  using Taker = std::function<void(std::string_view channel, const uint8_t* data, size_t n)>;

  virtual ~LcmLibrary() = default;
  /// Hears one more channel, from now on.
  virtual void listen_to(const std::string& channel) = 0;
  /// Waits so long for a packet of these channels and hands it over. False: the socket is broken.
  virtual bool receive(int wait_ms, const Taker& take) = 0;
  /// False: not sent.
  virtual bool publish(const std::string& channel, const uint8_t* data, size_t n) = 0;
};

/// InputError: the library is missing, or the address cannot be opened.
std::unique_ptr<LcmLibrary> open_lcm(const std::string& url);

}  // namespace limberg
