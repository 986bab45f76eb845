#include "sim/imaging/anatomical/lid_bed.h"

#include <cmath>

#include "sim/base/elementary.h"
#include "sim/imaging/anatomical/eye_shape.h"

namespace limberg {
namespace {

using anatomical::Eye;

constexpr double kIrisOver_mm = 0.04, kPupilOver_mm = 0.08, kCapDeep_mm = 2;
constexpr double kEdge_mm = 0.9, kCapEdge_mm = 0.5;
constexpr int kTurns = 72;  // about the globe's axis

/// How far before the globe's middle its surface lies, so far from the axis.
double front_mm(double from_axis_mm) {
  const double f = from_axis_mm * from_axis_mm;
  const auto before = [&](double radius) { return std::sqrt(std::max(0., radius * radius - f)); };
  return std::max(before(Eye::kBare_mm), Eye::kCornea_y_mm + before(Eye::kCornea_mm));
}

/// What a line of places (from the axis, before the middle) sweeps that begins and ends on the axis, turned about it.
TriMesh turned(const std::vector<Vec2>& line) {
  TriMesh m;
  const Vec3 c = Eye::parted_centre();
  const auto place = [&](const Vec2& q, int turn) {
    const double a = 2 * M_PI * turn / kTurns;
    return Vec3(c + Vec3(q.x() * elementary::cos(a), q.y(), q.x() * elementary::sin(a)));
  };
  m.X_mm.push_back(place(line.front(), 0));
  for (size_t i = 1; i + 1 < line.size(); ++i)
    for (int k = 0; k < kTurns; ++k) m.X_mm.push_back(place(line[i], k));
  m.X_mm.push_back(place(line.back(), 0));
  const int32_t last = int32_t(m.X_mm.size()) - 1, rings = int32_t(line.size()) - 2;
  for (int32_t k = 0; k < kTurns; ++k) {
    const int32_t next = (k + 1) % kTurns;
    m.tri.push_back({0, 1 + next, 1 + k});
    for (int32_t i = 0; i + 1 < rings; ++i) {
      const int32_t here = 1 + i * kTurns, there = here + kTurns;
      m.tri.push_back({here + k, here + next, there + next});
      m.tri.push_back({here + k, there + next, there + k});
    }
    m.tri.push_back({last, 1 + (rings - 1) * kTurns + k, 1 + (rings - 1) * kTurns + next});
  }
  return m;
}

TriMesh globe() {
  std::vector<Vec2> line;
  const double limbus = elementary::atan2(Eye::kLimbus_mm, front_mm(Eye::kLimbus_mm));
  const int before = int(std::ceil(Eye::kLimbus_mm / kEdge_mm)),
            behind = int(std::ceil((M_PI - limbus) * Eye::kBare_mm / kEdge_mm));
  for (int i = 0; i < before; ++i) {
    const double r = Eye::kLimbus_mm * i / before;
    line.emplace_back(r, front_mm(r));
  }
  for (int i = 0; i < behind; ++i) {
    const double a = limbus + (M_PI - limbus) * i / behind;
    line.emplace_back(Eye::kBare_mm * elementary::sin(a), Eye::kBare_mm * elementary::cos(a));
  }
  line.emplace_back(0, -Eye::kBare_mm);
  return turned(line);
}

/// What lies on the globe about its axis: so wide, and so much over it.
TriMesh cap(double radius_mm, double over_mm) {
  std::vector<Vec2> line;
  const int n = int(std::ceil(radius_mm / kCapEdge_mm));
  for (int i = 0; i <= n; ++i) {
    const double r = radius_mm * i / n;
    line.emplace_back(r, front_mm(r) + over_mm);
  }
  line.emplace_back(radius_mm, front_mm(radius_mm) - kCapDeep_mm);
  line.emplace_back(0, front_mm(radius_mm) - kCapDeep_mm);
  return turned(line);
}

}  // namespace

LidBedMeshes make_lid_bed() {
  return {globe(), cap(Eye::kLimbus_mm, kIrisOver_mm), cap(Eye::kPupil_mm, kPupilOver_mm)};
}

}  // namespace limberg
