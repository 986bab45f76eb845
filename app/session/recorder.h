#pragma once
// Empties the ring of samples into the recording. Writes to disk: not for the device thread.
//
// When the disk refuses, what was written stays, what follows waits for room, and the rings are still emptied, so that
// the session can go on or end as its owner decides. What is thrown for want of memory has lost nothing: a value leaves
// its ring when it has been written down.
#include <string>
#include <utility>

#include "app/session/channels.h"
#include "devices/recording.h"

namespace limberg {

class Recorder {
 public:
  /// InputError as RecordingWriter::open.
  Recorder(Channels& channels, const std::string& path, const SessionInfo& info, const std::vector<Blob>& blobs,
           bool replace)
      : ch_(channels) {
    writer_.open(path, info, blobs, replace);
  }

  /// Tick 0 was then: before the first drain().
  void began(int64_t utc_start_ns) { writer_.began(utc_start_ns); }
  void drain() {
    for (; const Sample* s = ch_.samples.front(); ++samples_) writer_.on_sample(*s), ch_.samples.drop();
    for (; const DeviceRun* r = ch_.device_runs.front();) writer_.schedule(*r), ch_.device_runs.drop();
    for (; const SolverTake* t = ch_.solver_takes.front();) writer_.schedule(*t), ch_.solver_takes.drop();
    for (; const StateSample* s = ch_.states.front();) writer_.state(*s), ch_.states.drop();
    if (ch_.samples.lost() + ch_.events.lost() + ch_.device_runs.lost() + ch_.solver_takes.lost() > 0)
      writer_.schedule_lost();
  }
  void checkpoint(int64_t tick, uint64_t hash) { writer_.checkpoint(tick, hash); }
  void finish(int64_t tick, uint64_t hash) {
    drain();
    writer_.finish(tick, hash);
  }
  /// Of a session that has failed: everything until then, without an end, as it is after a loss of power.
  void cut_short() noexcept {
    for (int attempt = 0; attempt < 2; ++attempt) try {
        drain();
        break;
      } catch (...) {  // no memory: what the failed session held is free by now, or never
      }
    writer_.cut_short();
  }
  bool failed() const { return !writer_.error().empty(); }
  bool given_up() const { return writer_.given_up(); }
  void give_up() { writer_.give_up(); }
  const std::string& error() const { return writer_.error(); }
  const std::string& path() const { return writer_.path(); }
  int64_t samples() const { return samples_; }

 private:
  Channels& ch_;
  RecordingWriter writer_;
  int64_t samples_ = 0;
};

/// What a person is told while the disk refuses, once each time.
class RecordingWatch {
 public:
  /// Empty: nothing new.
  std::string look(const Recorder& r) {
    if (path_.empty()) path_ = r.path();
    if (path_ != r.path()) return std::exchange(path_, r.path()) + ": was removed; the recording goes on in " + path_;
    if (r.given_up() && !stopped_) return stopped_ = waits_ = true, "recording stopped: " + r.error();
    if (r.failed() && !waits_)
      return waits_ = true, "recording waits: " + r.error() + "; what follows is held in memory";
    if (!r.failed() && waits_)
      return waits_ = false, r.path() + ": can be written again; the recording has lost nothing";
    return "";
  }

 private:
  std::string path_;
  bool waits_ = false, stopped_ = false;
};

}  // namespace limberg
