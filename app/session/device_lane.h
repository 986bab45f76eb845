#pragma once
// The device thread's work on one tick, without the thread: newest patient in, samples through the front end, events
// and hand state out. It allocates and frees nothing, locks nothing and calls nothing but its sources, whatever the
// topology does.
#include "app/session/channels.h"
#include "devices/front_end.h"

namespace limberg {

class DeviceLane final : private EventSink, private SampleSink {
 public:
  /// `record`: pass every sample on to Channels::samples; `schedule`: and what each tick found to
  /// Channels::device_runs.
  DeviceLane(DeviceFrontEnd& front, Channels& channels, bool record, bool schedule = false)
      : front_(front), ch_(channels), record_(record), schedule_(schedule) {}

  void tick(int64_t tick) {
    const int64_t samples_before = samples_;
    ch_.patient_to_device.update();
    const Snapshot& s = ch_.patient_to_device.reading().snapshot;
    front_.tick(tick, s, *this, *this, hand_.tool);
    hand_.glove = front_.second_hand(0), hand_.other_glove = front_.second_hand(1);
    hand_.sample_ns = front_.last_sample_ns();
    ch_.hand_to_solver.writing() = hand_, ch_.hand_to_solver.publish();
    ch_.hand_to_render.writing() = hand_, ch_.hand_to_render.publish();
    if (ch_.want_headset.load(std::memory_order_relaxed))
      ch_.hand_to_headset.writing() = hand_, ch_.hand_to_headset.publish();
    snapshot_tick_ = s.device_tick, snapshot_step_ = int64_t(s.step);
    if (schedule_) note(tick, samples_ - samples_before);
  }
  /// After the last tick: passes the last row of the schedule on.
  void end_schedule() {
    if (run_.count > 0) ch_.device_runs.push(run_);
    run_ = {};
  }

  bool done() const { return front_.done(); }
  const HandState& hand() const { return hand_; }
  int64_t snapshot_tick() const { return snapshot_tick_; }  // device tick that the snapshot just used had seen
  int64_t snapshot_step() const { return snapshot_step_; }  // Snapshot::step of the snapshot just used
  uint64_t events_lost() const { return ch_.events.lost(); }
  uint64_t samples_lost() const { return ch_.samples.lost(); }
  const DeviceFrontEnd& front() const { return front_; }

 private:
  bool push(const ToolEvent& e) override { return ch_.events.push(e); }
  void missed(const MissedPress& m) override { ch_.missed.push(m); }
  void on_sample(const Sample& s) override {
    ++samples_;
    if (record_) ch_.samples.push(s);
  }
  void note(int64_t tick, int64_t samples) {
    static constexpr int32_t kLongest = 250;  // a quarter of a second: that much a killed session may lose
    if (run_.count > 0 && samples == 0 && tick == run_.tick + run_.count && snapshot_step_ == run_.snapshot &&
        run_.count < kLongest) {
      ++run_.count;
      return;
    }
    end_schedule();
    run_ = {tick, snapshot_step_, 1, int32_t(samples)};
  }

  DeviceFrontEnd& front_;
  Channels& ch_;
  bool record_, schedule_;
  HandState hand_;
  int64_t snapshot_tick_ = 0, snapshot_step_ = 0, samples_ = 0;
  DeviceRun run_;  // not passed on yet
};

}  // namespace limberg
