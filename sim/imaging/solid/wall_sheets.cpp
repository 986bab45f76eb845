#include "sim/imaging/solid/wall_sheets.h"

#include <algorithm>
#include <array>

namespace limberg::imaging {

namespace {

constexpr int kAcross = 24;  // places to either side

}  // namespace

WallSheet wall_sheet(const VolumeSampler& volume, const Vec3& x, const Vec3& normal, double reach, double cortical) {
  std::array<double, 2 * kAcross + 1> f{};
  const double step = reach / kAcross;
  for (int i = -kAcross; i <= kAcross; ++i) f[size_t(i + kAcross)] = volume.value(x + i * step * normal);
  // The feet of the crest: the lowest place on either side, no farther than the reach.
  const auto top = std::max_element(f.begin() + kAcross / 2, f.end() - kAcross / 2);
  const auto left = std::min_element(f.begin(), top + 1), right = std::min_element(top, f.end());
  const double a = double(left - f.begin()), b = double(right - f.begin());
  WallSheet s{x, normal, 0};
  if (!(b > a) || !(cortical > std::max(*left, *right))) return s;
  double mass = 0, moment = 0, thickness = 0;
  for (int i = int(a); i <= int(b); ++i) {
    const double t = (i - a) / (b - a), beside = (1 - t) * *left + t * *right;
    const double over = std::max(0., f[size_t(i)] - beside);
    mass += over, moment += over * (i - kAcross) * step, thickness += step * over / (cortical - beside);
  }
  if (!(mass > 0)) return s;
  s.contrast = *top - std::max(*left, *right);
  s.middle_mm = x + moment / mass * normal, s.thickness_mm = thickness;
  return s;
}

}  // namespace limberg::imaging
