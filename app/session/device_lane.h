#pragma once
// The device thread's work on one tick, without the thread: newest patient in, samples through the front end, events and
// hand state out. Between changes of topology it allocates nothing, locks nothing and calls nothing but its sources.
#include "app/session/channels.h"
#include "devices/front_end.h"

namespace limberg {

class DeviceLane final : private EventSink, private SampleSink {
 public:
  /// `record`: pass every sample on to Channels::samples.
  DeviceLane(DeviceFrontEnd& front, Channels& channels, bool record) : front_(front), ch_(channels), record_(record) {}

  void tick(int64_t tick) {
    ch_.patient_to_device.update();
    const Snapshot& s = ch_.patient_to_device.reading().snapshot;
    front_.tick(tick, s, *this, *this, hand_.tool);
    ch_.topologies.moved_to(kDeviceReader, s.topology_version);
    hand_.glove = front_.second_hand();
    hand_.sample_ns = front_.last_sample_ns();
    ch_.hand_to_solver.writing() = hand_, ch_.hand_to_solver.publish();
    ch_.hand_to_render.writing() = hand_, ch_.hand_to_render.publish();
    snapshot_tick_ = s.device_tick;
  }

  bool done() const { return front_.done(); }
  const HandState& hand() const { return hand_; }
  int64_t snapshot_tick() const { return snapshot_tick_; }  // device tick that the snapshot just used had seen
  uint64_t events_lost() const { return ch_.events.lost(); }
  uint64_t samples_lost() const { return ch_.samples.lost(); }
  const DeviceFrontEnd& front() const { return front_; }

 private:
  bool push(const ToolEvent& e) override { return ch_.events.push(e); }
  void on_sample(const Sample& s) override {
    if (record_) ch_.samples.push(s);
  }

  DeviceFrontEnd& front_;
  Channels& ch_;
  bool record_;
  HandState hand_;
  int64_t snapshot_tick_ = 0;
};

}  // namespace limberg
