#include "devices/motion.h"

#include <cmath>
#include <numbers>

#include "sim/base/elementary.h"

namespace limberg {

Tremor::Tremor(uint64_t seed, double amplitude_mm, double low_hz, double high_hz) {
  RandomStream random(seed);
  for (auto& axis : sine_) {
    double sum = 0;
    for (Sine& s : axis) {
      s.amplitude = 0.3 + 0.7 * random.uniform();
      s.hz = low_hz + (high_hz - low_hz) * random.uniform();
      s.phase = 2 * std::numbers::pi * random.uniform();
      sum += s.amplitude;
    }
    for (Sine& s : axis) s.amplitude *= amplitude_mm / sum;
  }
}

Vec3 Tremor::at(double t_s) const {
  Vec3 p = Vec3::Zero();
  for (int i = 0; i < 3; ++i)
    for (const Sine& s : sine_[size_t(i)])
      p[i] += s.amplitude * elementary::sin(2 * std::numbers::pi * s.hz * t_s + s.phase);
  return p;
}

Dropouts::Dropouts(uint64_t seed, double per_s, double longest_s)
    : random_(seed), per_s_(per_s), longest_s_(longest_s) {
  draw_next(0);
}

void Dropouts::draw_next(double after_s) {
  // Exponential waiting times make a Poisson process.
  begin_s_ = per_s_ > 0 ? after_s - elementary::log(1 - random_.uniform()) / per_s_ : 1e300;
  end_s_ = begin_s_ + longest_s_ * (1 + 2 * random_.uniform()) / 3;
}

bool Dropouts::lost(double t_s) {
  while (t_s >= end_s_) draw_next(end_s_);
  return t_s >= begin_s_;
}

}  // namespace limberg
