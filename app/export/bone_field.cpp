#include "app/export/bone_field.h"

#include <algorithm>
#include <limits>

#include "app/export/solids.h"
#include "sim/skull/bone/surface.h"

namespace limberg {

void BoneField::add(const Surface& s) {
  if (s.tri.empty()) return;
  Vec3 low = s.x_mm.front(), high = low;
  for (const Vec3& x : s.x_mm) low = low.cwiseMin(x), high = high.cwiseMax(x);
  part_.push_back({SurfaceTarget(s), Bvh(s.x_mm, s.tri), low, high});
}

double BoneField::distance_mm(const Vec3& x) const {
  double least = std::numeric_limits<double>::infinity();
  for (const Part& p : part_) {
    const double box = (p.low_mm - x).cwiseMax(x - p.high_mm).cwiseMax(Vec3::Zero()).norm();
    if (box >= least) continue;
    const SurfaceTarget::Place c = p.target.closest(x);
    least = std::min(least, c.normal.dot(x - c.point_mm) < 0 ? -c.distance_mm : c.distance_mm);
  }
  return least;
}

bool BoneField::meets(const Vec3& from, const Vec3& direction, double reach_mm) const {
  std::array<Bvh::LineHit, 1> hit;
  return std::any_of(part_.begin(), part_.end(),
                     [&](const Part& p) { return p.bvh.line(from, direction, 0, reach_mm, hit) > 0; });
}

Surface fragment_surface(const bone::Bones& bones, const bone::Fragment& f) {
  const bone::BoneSurface b = bone::bone_surface(bones.mesh(), bone::component_of(bones.mesh(), f.vertex));
  return compacted({b.X_mm, b.tri});
}

}  // namespace limberg
