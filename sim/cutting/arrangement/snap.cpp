// The snap rule: a blade that lies entirely on earlier walls has cut nothing.
#include <cmath>

#include "sim/base/elementary.h"
#include "sim/cutting/arrangement/store.h"
#include "sim/geometry/triangle.h"

namespace limberg {

namespace {

constexpr double kAside_mm = 0.05;  // from the wall's plane
constexpr double kBeyond_mm = 0.1;  // from the wall's triangle, all directions
const double kSnapCosine = elementary::cos(15 * 3.14159265358979323846 / 180);

}  // namespace

bool ArrangementStore::is_cut_already(const Blade& blade) const {
  if (forest.empty()) return false;
  const double aside = kAside_mm / grid.half_unit_mm(), beyond = kBeyond_mm / grid.half_unit_mm();
  for (const Tri& t : blade.tri) {
    std::array<Vec3, 4> sample;
    for (size_t k = 0; k < 3; ++k) {
      const Int3& p = blade.vertex[size_t(t[k])];
      sample[k] = Vec3(p.x, p.y, p.z);
    }
    sample[3] = (sample[0] + sample[1] + sample[2]) / 3;
    const Vec3 n = area_vector2(sample[0], sample[1], sample[2]).normalized();
    for (const Vec3& p : sample) {
      bool covered = false;
      const Vec3 reach = Vec3::Constant(beyond);
      blades_near(box_within(p - reach, p + reach), [&](int32_t i, const IntBox&) {
        const OrigTri& o = orig[i];
        if (covered || o.live == 0) return;
        const Vec3 &a = points.approx(o.v[0]), &b = points.approx(o.v[1]), &c = points.approx(o.v[2]);
        const Vec3 m = area_vector2(a, b, c).normalized();
        covered = std::abs(m.dot(n)) >= kSnapCosine && std::abs(m.dot(p - a)) <= aside &&
                  (closest_on_triangle(p, a, b, c).point - p).norm() <= beyond;
      });
      if (!covered) return false;
    }
  }
  return true;
}

}  // namespace limberg
