#pragma once
// CPU time of this process, for benchmarks: other load on the machine disturbs it least.
#include <algorithm>
#include <ctime>
#include <vector>

namespace limberg::bench {

inline double cpu_ms() {
  timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return double(t.tv_sec) * 1e3 + double(t.tv_nsec) * 1e-6;
}

/// Repeated measurements of one thing.
struct Times {
  std::vector<double> ms;
  void add(double t) { ms.push_back(t); }
  bool empty() const { return ms.empty(); }
  double best() const { return ms.empty() ? 0 : *std::min_element(ms.begin(), ms.end()); }
  double median() const {
    if (ms.empty()) return 0;
    std::vector<double> s = ms;
    std::sort(s.begin(), s.end());
    return 0.5 * (s[(s.size() - 1) / 2] + s[s.size() / 2]);
  }
  /// The measurement that this share of all lies below.
  double percentile(double share) const {
    if (ms.empty()) return 0;
    std::vector<double> s = ms;
    std::sort(s.begin(), s.end());
    return s[std::min(s.size() - 1, size_t(share * double(s.size())))];
  }
};

}  // namespace limberg::bench
