#pragma once
// Acts of a lesson, shown by an emulated hand. It plans and allocates: for the main thread; its
// readings go to the device thread through the same ring as those of the mouse (hand_feed.h).
#include <cstdint>
#include <memory>
#include <vector>

#include "devices/source.h"
#include "sim/commands/command.h"
#include "sim/patient/snapshot.h"

namespace limberg {

class Demonstration {
 public:
  void begin(const std::vector<Command>& acts, int64_t now_ns, const Snapshot& patient);
  /// Readings and choices until now. False: it is over.
  bool poll(int64_t now_ns, const Snapshot& patient, SampleSink& sink);

 private:
  std::unique_ptr<Source> hand_;
  int64_t began_ns_ = 0;
};

}  // namespace limberg
