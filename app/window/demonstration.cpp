#include "app/window/demonstration.h"

#include <algorithm>

#include "app/window/pointer_source.h"
#include "devices/emulator.h"
#include "devices/head_surgeon.h"

namespace limberg {

namespace {

SurgeonSettings steady_hand() {
  SurgeonSettings s;
  s.noise_mm = s.noise_rad = s.tremor_mm = 0;
  s.dropouts_per_s = 0;
  s.start_s = 0.15, s.settle_s = 0.2;
  s.device_id = PointerSource::kDevice;
  return s;
}

}  // namespace

void Demonstration::begin(const std::vector<Command>& step, int64_t now_ns, const Snapshot& patient) {
  // What acts on bone, and everything where there is no skin, is shown by the hand for bone: with the stylus, as the
  // mouse is one.
  const bool bone = !patient.topology->body || std::any_of(step.begin(), step.end(), [](const Command& c) {
    return std::holds_alternative<HeadCommand>(c);
  });
  if (bone)
    hand_ = std::make_unique<EmulatedHeadSurgeon>(step, steady_hand(), HeadHands::stylus);
  else
    hand_ = std::make_unique<EmulatedSurgeon>(step, steady_hand());
  began_ns_ = now_ns;
}

bool Demonstration::poll(int64_t now_ns, const Snapshot& patient, SampleSink& sink) {
  if (!hand_) return false;
  hand_->look(patient);
  hand_->poll(now_ns - began_ns_, sink);
  if (hand_->done()) hand_.reset();
  return hand_ != nullptr;
}

}  // namespace limberg
