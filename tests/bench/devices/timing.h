#pragma once
// The device thread beside other work: how late it wakes, how long a tick takes, how old what it shows is; and what the
// buffers between threads cost, beside a mutex.
#include <cstdint>
#include <string>
#include <vector>

#include "app/session/lanes.h"

namespace limberg::bench {

struct WakeFigures {
  std::string settings;
  Histogram wake;                // how late
  uint64_t ticks = 0, late = 0;  // by more than 1 ms
};
/// A loop of 1 kHz for so long, with or without SCHED_FIFO, with so many busy processes beside it.
WakeFigures wake_trial(double seconds, bool fifo, int hogs);

struct BufferFigures {
  std::string name;
  double ns_write = 0, ns_read = 0;  // one thread, nobody else
  Histogram writer;                  // with a reader that never stops
  uint64_t torn = 0;                 // values of which a part was of another time
};
std::vector<BufferFigures> buffer_trials(int64_t writes);

/// A writer of high priority against a reader that holds what it reads for a while, while the cores are busy: the
/// longest that the writer waited, in us, by the name of the buffer. Empty without leave for real-time scheduling.
struct InversionFigures {
  std::string name;
  Histogram writer;
};
std::vector<InversionFigures> inversion_trials(double seconds);

}  // namespace limberg::bench
