#pragma once
// How a hand moves: minimum-jerk paths, tremor, and the noise and gaps of the tracker that watches it.
#include <array>
#include <cstdint>

#include "sim/geometry/vec.h"

namespace limberg {

/// Share of the way at share s of the time: 10 s^3 - 15 s^4 + 6 s^5, the path of least mean square jerk from rest to
/// rest (Flash and Hogan 1985, eq. 2). Its highest speed is 15/8 of the mean. Clamped outside [0, 1].
inline double minimum_jerk(double s) {
  if (s <= 0) return 0;
  if (s >= 1) return 1;
  return s * s * s * (10 + s * (6 * s - 15));
}

/// A stream of random numbers that is the same on every machine (splitmix64).
class RandomStream {
 public:
  explicit RandomStream(uint64_t seed) : state_(seed) {}
  uint64_t next() {
    uint64_t z = (state_ += 0x9e3779b97f4a7c15ull);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
    return z ^ (z >> 31);
  }
  double uniform() { return double(next() >> 11) * 0x1p-53; }  // [0, 1)
  /// Standard normal but for its tails: the sum of twelve uniform numbers, which no mathematical library can change.
  double normal() {
    double sum = -6;
    for (int i = 0; i < 12; ++i) sum += uniform();
    return sum;
  }
  Vec3 normal3() {
    const double x = normal(), y = normal();
    return {x, y, normal()};
  }

 private:
  uint64_t state_;
};

/// Physiological tremor: on each axis three sines in the band, with their own phases; |value| <= amplitude.
class Tremor {
 public:
  Tremor(uint64_t seed, double amplitude_mm, double low_hz, double high_hz);
  Vec3 at(double t_s) const;

 private:
  struct Sine {
    double amplitude = 0, hz = 0, phase = 0;
  };
  std::array<std::array<Sine, 3>, 3> sine_;
};

/// Gaps of a tracker: they come at random with a mean rate, and last between a third of the longest and the longest.
class Dropouts {
 public:
  Dropouts(uint64_t seed, double per_s, double longest_s);
  bool lost(double t_s);  // t must not decrease

 private:
  void draw_next(double after_s);
  RandomStream random_;
  double per_s_, longest_s_, begin_s_ = 0, end_s_ = 0;
};

}  // namespace limberg
