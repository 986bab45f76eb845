#pragma once
// What the parts of `bench cutting` share: a timed cut, and how it is reported.
#include <stdexcept>

#include "app/operating_point/cpu_clock.h"
#include "sim/base/text.h"
#include "sim/cutting/arrangement/arrangement.h"
#include "tests/bench/cutting.h"

namespace limberg::bench {

inline void say(const CuttingSettings& s, const std::string& text) {
  if (s.progress) s.progress(text);
}

inline CutResult cut(Arrangement& a, const Blade& blade, uint64_t seed, Times& times) {
  const double start = cpu_ms();
  CutResult r = a.cut(blade, seed);
  times.add(cpu_ms() - start);
  if (!r.ok()) throw std::runtime_error("bench cutting: a cut was refused: " + r.reason);
  return r;
}

inline void add_row(Result& out, const std::string& name, const std::string& method, const std::string& settings,
                    const Times& t) {
  Row r;
  r.name = name;
  r.method = method;
  r.settings = settings + text("; median of %zu, best %.3f ms", t.ms.size(), t.best());
  r.time_ms = t.median();
  out.rows.push_back(r);
}

inline void add_bar(Result& out, const std::string& name, double value, double bar, bool larger, const char* source) {
  out.bars.push_back({name, value, false, bar, larger, larger ? value >= bar : value <= bar, source});
}

inline constexpr const char* kTargets = "issue 3, from the prototype's figures";

}  // namespace limberg::bench
