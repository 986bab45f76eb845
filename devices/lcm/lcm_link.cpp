// The part limberg-lcm.so: LcmLibrary by LCM.
#include <lcm/lcm-cpp.hpp>

#include "devices/lcm_library.h"

namespace limberg {
namespace {

class LcmLink final : public LcmLibrary {
 public:
  explicit LcmLink(const std::string& url) : lcm_(url) {}
  bool good() const { return lcm_.good(); }
  void listen_to(const std::string& channel) override { lcm_.subscribeFunction(channel, &LcmLink::on_packet, this); }
  bool receive(int wait_ms, const Taker& take) override {
    take_ = &take;
    return lcm_.handleTimeout(wait_ms) >= 0;
  }
  bool publish(const std::string& channel, const uint8_t* data, size_t n) override {
    return lcm_.publish(channel, data, unsigned(n)) == 0;
  }

 private:
  static void on_packet(const lcm::ReceiveBuffer* buffer, const std::string& channel, LcmLink* self) {
    (*self->take_)(channel, static_cast<const uint8_t*>(buffer->data), buffer->data_size);
  }

  lcm::LCM lcm_;
  const Taker* take_ = nullptr;  // during receive()
};

}  // namespace
}  // namespace limberg

extern "C" limberg::LcmLibrary* limberg_lcm(const std::string& url) {
  auto link = std::make_unique<limberg::LcmLink>(url);
  return link->good() ? link.release() : nullptr;
}
