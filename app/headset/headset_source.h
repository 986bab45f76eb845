#pragma once
// A headset as a device, and what is seen in it. Two threads of its own: one draws at the runtime's rate, one reads
// the hands every 4 ms; poll() takes readings from a queue and never waits, so the device thread stays what it is. Its
// filters (devices/tracking.h) predict each reading to the tick, as they do those of every tracker.
//
//   a controller in the hand that has the stylus   a stylus: the trigger presses, the grip is the clutch
//   the other hand, as cameras see it              the glove: the tips of forefinger and thumb are its stations
//   a controller in that other hand                the glove too: the trigger closes it
//   the hand of the stylus without a controller    the other glove
//
// Places are the patient's (room.h): a recording needs no headset and no calibration to be replayed. Each way of
// failing ends in words, the session without a headset goes on, and it is looked for again.
#include <memory>
#include <string>

#include "app/headset/eyes.h"
#include "devices/session_time.h"
#include "devices/source.h"

namespace limberg {

struct HeadsetSettings {
  static constexpr int32_t kDevice = 600;  // and kDevice + 1: the other glove
  EyesSettings eyes;
  bool left_handed = false;  // the stylus is in the left hand
  int nice = 5;              // of the drawing thread, as of the window's
};

/// "", "left", "scale=3", "left,scale=3,table=0.9": the options of --device headset. InputError on what cannot be read.
HeadsetSettings parse_headset(const std::string& text);

/// A headset's places are the patient's already: InputError for a calibration that carries the tracker of a room, or
/// the tip of a stylus.
void check_calibration(const Calibration& calibration);

/// Of one hand: readings in the patient's frame, as samples of stations. A hand keeps its own size in the patient,
/// however large that lies in the room: its forefinger's tip is where it is seen, its thumb's as far from there as it
/// is.
class HandStations {
 public:
  explicit HandStations(bool has_stylus) : has_stylus_(has_stylus) {}
  /// At most three samples; returns how many. `suppress`: the trigger means the tablet.
  int samples(const HandReading& hand, const PatientPlace& place, bool suppress, TrackerSample (&out)[3]);

 private:
  TrackerSample station(int which, StationRole role, int32_t device, const Vec3& at_mm, const Eigen::Quaterniond& q);
  bool has_stylus_;
  int64_t seq_[5]{};
  double open_m_ = 0.07;  // of a hand that is a controller
};

class HeadsetSource final : public Source {
 public:
  /// Never fails: a headset that is not there is looked for again and again; health() says why. `shared` may be null:
  /// then nothing is drawn.
  HeadsetSource(const HeadsetSettings& settings, const SourceTime& time, std::shared_ptr<HeadsetShared> shared);
  ~HeadsetSource() override;
  void poll(int64_t now_ns, SampleSink& sink) override;
  bool done() const override { return false; }
  SourceCounts counts() const override;
  std::string health() const override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace limberg
