#pragma once
// CLOCK_MONOTONIC, from which a session's time counts. Read by whoever drives a session and by the devices' own reader
// threads; everybody else is handed times.
#include <time.h>

#include <cstdint>

namespace limberg {

inline int64_t monotonic_ns() {
  timespec ts;
  clock_gettime(CLOCK_MONOTONIC, &ts);
  return int64_t(ts.tv_sec) * 1'000'000'000 + ts.tv_nsec;
}

}  // namespace limberg
