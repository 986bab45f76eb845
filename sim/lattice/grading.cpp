#include "sim/lattice/grading.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "sim/base/error.h"
#include "sim/lattice/lattice.h"

namespace limberg {
namespace {

constexpr double kTakenOff = 1.0 / 16;  // of a cell's edge, at each side

// Squared distance of a box from a stretch: convex along the stretch, so the thirds that hold its least value close in
// on it. 40 of them leave 1e-7 of the length.
double distance2_to_stretch(const Vec3& low, const Vec3& high, const Vec3& from, const Vec3& to) {
  const auto at = [&](double t) {
    double sum = 0;
    for (int a = 0; a < 3; ++a) {
      const double p = from[a] + t * (to[a] - from[a]), off = p - std::clamp(p, low[a], high[a]);
      sum += off * off;
    }
    return sum;
  };
  if (from == to) return at(0);
  double a = 0, b = 1;
  for (int i = 0; i < 40; ++i) {
    const double l = a + (b - a) / 3, r = b - (b - a) / 3;
    (at(l) < at(r) ? b : a) = at(l) < at(r) ? r : l;
  }
  return std::min({at(0), at(0.5 * (a + b)), at(1)});
}

bool reaches_into(const GradedZone& z, const Vec3& low, const Vec3& high) {
  for (int a = 0; a < 3; ++a)
    if (low[a] > std::max(z.from_mm[a], z.to_mm[a]) + z.radius_mm ||
        high[a] < std::min(z.from_mm[a], z.to_mm[a]) - z.radius_mm)
      return false;
  double least_depth = 0;
  for (int a = 0; a < 3; ++a) least_depth += z.inward[a] * ((z.inward[a] > 0 ? low[a] : high[a]) - z.from_mm[a]);
  if (least_depth > z.depth_mm) return false;
  return distance2_to_stretch(low, high, z.from_mm, z.to_mm) <= z.radius_mm * z.radius_mm;
}

}  // namespace

int zone_level(const Grading& grading, const Vec3& low_mm, const Vec3& high_mm) {
  const Vec3 off = kTakenOff * (high_mm - low_mm);
  int level = 0;
  for (const GradedZone& z : grading.zones)
    if (z.level > level && reaches_into(z, low_mm + off, high_mm - off)) level = z.level;
  return level;
}

void check_grading(const Grading& grading) {
  const auto level_ok = [](int level) { return level >= 0 && level <= kLevels; };
  const std::string levels = "; a level from 0 to " + std::to_string(kLevels) + " was expected";
  if (!level_ok(grading.wound_level))
    throw InputError("", 0, "wounds ask for level " + std::to_string(grading.wound_level) + levels);
  for (const GradedZone& z : grading.zones) {
    if (!level_ok(z.level))
      throw InputError("", 0, "a zone of the lattice asks for level " + std::to_string(z.level) + levels);
    const bool sound = z.from_mm.allFinite() && z.to_mm.allFinite() && std::isfinite(z.radius_mm) && z.radius_mm > 0 &&
                       z.depth_mm > 0 && std::abs(z.inward.squaredNorm() - 1) < 1e-6;
    if (!sound)
      throw InputError("", 0,
                       "a zone of the lattice is none; finite ends, a radius and a depth above 0 and a unit vector "
                       "into the body were expected");
  }
}

}  // namespace limberg
