#pragma once
// Where samples come from: a live stylus over LCM, a recorded log, an emulated surgeon. One small interface.
//
// The owner of the clock polls every source once per device tick with the time of
// that tick. A source hands over, in order, each sample whose time has come. It
// does not wait. Live and recorded sources allocate nothing while they are polled.
#include <cstdint>
#include <string>

#include "devices/sample.h"

namespace limberg {

struct Snapshot;

class SampleSink {
 public:
  virtual ~SampleSink() = default;
  virtual void on_sample(const Sample& sample) = 0;
};

struct SourceCounts {
  int64_t samples = 0;    // handed over
  int64_t malformed = 0;  // refused: damaged, of another version, not finite, out of order
  int64_t lost = 0;       // dropped because a buffer was full, or missing from a sequence
};

class Source {
 public:
  virtual ~Source() = default;
  /// Hands every sample with t_ns <= now_ns that has not been handed over yet to `sink`.
  virtual void poll(int64_t now_ns, SampleSink& sink) = 0;
  /// The newest patient, shown before each poll; a source that acts on what it sees (the emulated surgeon) looks at it.
  virtual void look(const Snapshot&) {}
  /// True when no further sample will ever come.
  virtual bool done() const = 0;
  virtual SourceCounts counts() const = 0;
  /// In a line: what the device says of itself, or why it is not there. Not for the device thread.
  virtual std::string health() const { return {}; }
};

}  // namespace limberg
