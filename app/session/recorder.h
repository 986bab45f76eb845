#pragma once
// Empties the ring of samples into the recording. Writes to disk: not for the device thread.
//
// When the disk refuses, what was written stays, the first error is kept and the ring is still emptied, so that the
// session can go on or end as its owner decides.
#include <string>

#include "app/session/channels.h"
#include "devices/recording.h"

namespace limberg {

class Recorder {
 public:
  /// InputError as RecordingWriter::open.
  Recorder(Channels& channels, const std::string& path, const SessionInfo& info, const std::vector<Blob>& blobs,
           bool replace)
      : ch_(channels), path_(path) {
    writer_.open(path, info, blobs, replace);
  }

  /// Tick 0 was then: before the first drain().
  void began(int64_t utc_start_ns) { writer_.began(utc_start_ns); }
  void drain() {
    for (Sample s; ch_.samples.pop(s); ++samples_) writer_.on_sample(s);
    for (DeviceRun r; ch_.device_runs.pop(r);) writer_.schedule(r);
    for (SolverTake t; ch_.solver_takes.pop(t);) writer_.schedule(t);
    for (StateSample s; ch_.states.pop(s);) writer_.state(s);
    if (ch_.samples.lost() + ch_.events.lost() + ch_.device_runs.lost() + ch_.solver_takes.lost() > 0)
      writer_.schedule_lost();
  }
  void checkpoint(int64_t tick, uint64_t hash) { writer_.checkpoint(tick, hash); }
  void finish(int64_t tick, uint64_t hash) {
    drain();
    writer_.finish(tick, hash);
  }
  /// Of a session that has failed: everything until then, without an end, as it is after a loss of power.
  void cut_short() {
    drain();
    writer_.cut_short();
  }
  bool failed() const { return !writer_.error().empty(); }
  const std::string& error() const { return writer_.error(); }
  const std::string& path() const { return path_; }
  int64_t samples() const { return samples_; }

 private:
  Channels& ch_;
  std::string path_;
  RecordingWriter writer_;
  int64_t samples_ = 0;
};

}  // namespace limberg
