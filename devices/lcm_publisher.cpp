#include "devices/lcm_publisher.h"

#include "devices/lcm_library.h"
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

LcmPublisher::LcmPublisher(const std::string& url, bool allow_other_networks) {
  if (!allow_other_networks && !stays_here(url))
    throw InputError(
        "", 0,
        "LCM address \"" + url +
            "\" reaches other machines; expected udpm://239.255.76.67:7667?ttl=0 or explicit leave to send there");
  lcm_ = open_lcm(url);
}

LcmPublisher::~LcmPublisher() = default;

bool LcmPublisher::publish(const Sample& sample) {
  if (std::holds_alternative<RawSample>(sample)) return false;
  MessageBytes bytes;
  const size_t n = std::visit([&](const auto& s) { return encode_message(to_message(s), bytes); }, sample);
  if (n == 0 || !lcm_->publish(std::string(channel_of(sample)), bytes.data(), n)) return false;
  return ++sent_, true;
}

}  // namespace limberg
