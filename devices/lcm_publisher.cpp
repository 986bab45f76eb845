#include "devices/lcm_publisher.h"

#include <lcm/lcm-cpp.hpp>

#include "devices/message_codec.h"
#include "sim/base/error.h"

namespace limberg {

bool stays_here(const std::string& url) {
  if (url.starts_with("memq://")) return true;
  const size_t question = url.find('?');
  if (!url.starts_with("udpm://239.") || question == std::string::npos) return false;
  const std::string options = "&" + url.substr(question + 1) + "&";
  const size_t ttl = options.find("&ttl=");
  return options.find("&ttl=0&") != std::string::npos && options.find("&ttl=", ttl + 1) == std::string::npos;
}

struct LcmPublisher::Impl {
  explicit Impl(const std::string& url) : lcm(url) {}
  lcm::LCM lcm;
};

LcmPublisher::LcmPublisher(const std::string& url, bool allow_other_networks) {
  if (!allow_other_networks && !stays_here(url))
    throw InputError(
        "", 0,
        "LCM address \"" + url +
            "\" reaches other machines; expected udpm://239.255.76.67:7667?ttl=0 or explicit leave to send there");
  impl_ = std::make_unique<Impl>(url);
  if (!impl_->lcm.good())
    throw InputError(
        "", 0,
        "LCM address \"" + url +
            "\" cannot be opened; expected a multicast route, for instance after: ip route add 224.0.0.0/4 dev lo");
}

LcmPublisher::~LcmPublisher() = default;

bool LcmPublisher::publish(const Sample& sample) {
  if (std::holds_alternative<RawSample>(sample)) return false;
  MessageBytes bytes;
  const size_t n = std::visit([&](const auto& s) { return encode_message(to_message(s), bytes); }, sample);
  if (n == 0 || impl_->lcm.publish(std::string(channel_of(sample)), bytes.data(), unsigned(n)) != 0) return false;
  return ++sent_, true;
}

}  // namespace limberg
