#pragma once
// The lips upon a face: philtrum, vermilion of both lips, the line between them, commissures. Right half.
#include <algorithm>

#include "sim/imaging/anatomical/fields.h"

namespace limberg::anatomical {

class Mouth {
 public:
  static constexpr double kCorner_mm = 26.8;  // x of the commissure

  /// Heights, x mm from the middle: of the line where the lips meet, and of the borders of red lip above and below.
  static double line_mm(double x) {
    static constexpr double at[] = {0, 4, 12, 20, 28}, z[] = {-55.9, -55.5, -55.5, -55.7, -56.0};
    return between(at, z, x);
  }
  static double red_from_mm(double x) {
    static constexpr double at[] = {0, 7, 13, 20, 27}, z[] = {-65.2, -65.0, -63.4, -60.4, -56.4};
    return between(at, z, x);
  }
  static double red_to_mm(double x) {
    static constexpr double at[] = {0, 2.5, 5.5, 12, 19, 27}, z[] = {-48.6, -48.2, -47.2, -48.8, -51.6, -55.4};
    return between(at, z, x);
  }

  /// The slit between lips that are parted by so much, up to the commissures, through whatever lies before the teeth.
  static double slit(const Vec3& q, double parted_mm) {
    const double high = std::abs(q.z() - line_mm(std::abs(q.x()))) - parted_mm / 2;
    return std::max({high, std::abs(q.x()) - (kCorner_mm - 1), 70 - q.y()});
  }

  double upon(double face, const Vec3& q) const {
    if (!near_.holds(q)) return face;
    double d = join(face, column_, q, 4);
    d = carve(d, philtrum_, q, 4);
    return smin(d, join(upper_(q), lower_, q, 0.5), 3.6);
  }

 private:
  template <size_t N>
  static double between(const double (&at)[N], const double (&z)[N], double x) {
    for (size_t i = 1; i < N; ++i)
      if (x <= at[i]) return z[i - 1] + (z[i] - z[i - 1]) * std::clamp((x - at[i - 1]) / (at[i] - at[i - 1]), 0., 1.);
    return z[N - 1];
  }
  Ball near_{{0, 98, -54}, 46};
  Tube upper_{{-5.2, 105.6, -51.1, 4.6}, {0, 105.6, -51.9, 4.5}, {5.2, 105.6, -51.1, 4.6},
              {12, 102.7, -51.5, 4.1},   {19, 97.6, -53.2, 3.0}, {26.8, 91.4, -55.6, 1.2}};
  Tube lower_{{-6, 102.8, -60.8, 4.9}, {0, 103.0, -60.7, 5.0}, {6, 102.8, -60.8, 4.9},
              {13, 99.6, -59.7, 4.2},  {20, 95.2, -58.2, 3.0}, {26.8, 91.2, -56.4, 1.2}};
  Tube column_{{3.6, 102.8, -36, 2.2}, {5.4, 105.2, -45.5, 2.6}};
  Tube philtrum_{{0, 108.3, -39, 3.0}, {0, 110.0, -46, 3.6}};
};

}  // namespace limberg::anatomical
