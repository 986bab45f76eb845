#include "render/colour_map.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace limberg {

Rgb8 viridis(double t) {
  // The map at every tenth of its range (van der Walt and Smith, 2015; public domain), linear between.
  static constexpr std::array<std::array<int, 3>, 11> at{{{68, 1, 84},
                                                          {72, 36, 117},
                                                          {65, 68, 135},
                                                          {53, 95, 141},
                                                          {42, 120, 142},
                                                          {33, 145, 140},
                                                          {34, 168, 132},
                                                          {68, 191, 112},
                                                          {122, 209, 81},
                                                          {189, 223, 38},
                                                          {253, 231, 37}}};
  const double s = t > 0 ? std::min(t, 1.0) * 10 : 0;
  const size_t i = std::min(size_t(s), size_t(9));
  const double f = s - double(i);
  const auto mix = [&](size_t c) { return uint8_t(std::lround(at[i][c] + f * (at[i + 1][c] - at[i][c]))); };
  return {mix(0), mix(1), mix(2)};
}

Rgb8 diverging(double t) {
  // Steps of a quarter of one side; both sides were chosen
  // here to have the same CIE lightness step by step (88, 74,
  // 60, 45, 28 within 2), so that neither sign looks stronger.
  static constexpr std::array<std::array<int, 3>, 5> kLow{
      {{221, 221, 221}, {158, 188, 222}, {108, 150, 204}, {66, 109, 173}, {28, 65, 128}}};
  static constexpr std::array<std::array<int, 3>, 5> kHigh{
      {{221, 221, 221}, {236, 172, 150}, {221, 123, 98}, {187, 71, 58}, {131, 15, 34}}};
  const auto& at = t < 0 ? kLow : kHigh;
  const double s = std::isfinite(t) ? std::min(std::abs(t), 1.0) * 4 : 0;
  const size_t i = std::min(size_t(s), size_t(3));
  const double f = s - double(i);
  const auto mix = [&](size_t c) { return uint8_t(std::lround(at[i][c] + f * (at[i + 1][c] - at[i][c]))); };
  return {mix(0), mix(1), mix(2)};
}

Rgb8 colour_of(ColourScale scale, double t) {
  return scale == ColourScale::signed_value ? diverging(2 * t - 1) : viridis(t);
}

double linear_light(double s) { return s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4); }
Vec3f linear_light(const Vec3f& srgb) {
  return srgb.unaryExpr([](float s) { return float(linear_light(double(s))); });
}

double lightness(Rgb8 c) {
  const auto linear = [](uint8_t v) { return linear_light(v / 255.0); };
  const double y = 0.2126 * linear(c.r) + 0.7152 * linear(c.g) + 0.0722 * linear(c.b);
  const double d = 6.0 / 29;
  return 116 * (y > d * d * d ? std::cbrt(y) : y / (3 * d * d) + 4.0 / 29) - 16;
}

}  // namespace limberg
