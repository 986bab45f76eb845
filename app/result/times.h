#pragma once
// A lane's times on their way into a result.
#include <fmt/format.h>

#include <string>

#include "app/result/schema.h"
#include "app/session/lanes.h"

namespace limberg {

/// Which percentiles a result says beside the median.
struct Percentiles {
  bool p95 = false, p99 = true, p999 = false, max = true;
};

/// `unit`: in the name's unit per ns (us: 1e-3, ms: 1e-6). Four digits are more than the histogram has.
inline ResultTimes times_of(const Histogram& h, double unit, const Percentiles& which) {
  const auto shown = [&](int64_t ns) { return Maybe(std::stod(fmt::format("{:.4g}", double(ns) * unit))); };
  ResultTimes t;
  t.p50 = shown(h.percentile_ns(0.5));
  if (which.p95) t.p95 = shown(h.percentile_ns(0.95));
  if (which.p99) t.p99 = shown(h.percentile_ns(0.99));
  if (which.p999) t.p999 = shown(h.percentile_ns(0.999));
  if (which.max) t.max = shown(h.max_ns());
  return t;
}

}  // namespace limberg
