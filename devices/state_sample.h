#pragma once
// Some places of the patient after a solver step: what is recorded once a second, so that a replay that differs can say
// by how much.
#include <array>
#include <cmath>
#include <cstdint>

namespace limberg {

struct StateSample {
  static constexpr int32_t kPlaces = 64;
  int64_t step = 0;       // of the solver, from 1
  uint64_t topology = 0;  // hash
  int32_t vertices = 0;   // of the surface shown
  int32_t n = 0;          // places used: vertices k * vertices / n
  std::array<std::array<float, 3>, kPlaces> at_mm{};
  float sutures_N = 0, hooks_N = 0;  // sums of the forces' sizes
};

/// How far a replay is from what was recorded, over the steps at which both were sampled.
struct StateDifference {
  int64_t compared = 0;
  int64_t other_topology = 0;  // samples whose surfaces are not the same, so that places cannot be compared
  double mm = 0, N = 0;        // the largest distance of a place, and difference of a sum of forces
};

inline void add(StateDifference& d, const StateSample& was, const StateSample& is) {
  ++d.compared;
  if (was.topology != is.topology || was.vertices != is.vertices || was.n != is.n) {
    ++d.other_topology;
    return;
  }
  for (int32_t k = 0; k < is.n; ++k) {
    double square = 0;
    for (size_t j = 0; j < 3; ++j) {
      const double e = double(was.at_mm[size_t(k)][j]) - double(is.at_mm[size_t(k)][j]);
      square += e * e;
    }
    const double far = std::sqrt(square);
    if (far > d.mm) d.mm = far;
  }
  for (const double e : {double(was.sutures_N - is.sutures_N), double(was.hooks_N - is.hooks_N)})
    if (std::abs(e) > d.N) d.N = std::abs(e);
}

}  // namespace limberg
