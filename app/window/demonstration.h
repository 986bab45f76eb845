#pragma once
// The steps of a lesson, shown one at a time by an emulated hand. It plans and allocates: for the main thread; its
// readings go to the device thread through the same ring as those of the mouse (hand_feed.h).
#include <cstdint>
#include <memory>
#include <vector>

#include "devices/source.h"
#include "sim/commands/command.h"
#include "sim/patient/snapshot.h"

namespace limberg {

/// The steps of a lesson as they are shown one at a time: an act, and the rests and stages that follow it. Pieces of
/// one stroke are one act.
std::vector<std::vector<Command>> lesson_steps(const std::vector<Command>& script);

class Demonstration {
 public:
  explicit Demonstration(std::vector<std::vector<Command>> lesson) : lesson_(std::move(lesson)) {}
  /// Begins the next step. False: all have been shown.
  bool begin(int64_t now_ns, const Snapshot& patient);
  /// Readings and choices until now. False: the step is over.
  bool poll(int64_t now_ns, const Snapshot& patient, SampleSink& sink);
  int begun() const { return int(next_); }

 private:
  std::vector<std::vector<Command>> lesson_;
  std::unique_ptr<Source> hand_;
  size_t next_ = 0;
  int64_t began_ns_ = 0;
};

}  // namespace limberg
