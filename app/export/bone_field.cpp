#include "app/export/bone_field.h"

#include <algorithm>
#include <limits>

#include "app/export/solids.h"

namespace limberg {

void BoneField::add(const Surface& s) {
  if (s.tri.empty()) return;
  Vec3 low = s.x_mm.front(), high = low;
  for (const Vec3& x : s.x_mm) low = low.cwiseMin(x), high = high.cwiseMax(x);
  bone::BoneSurface b;
  b.X_mm = s.x_mm, b.tri = s.tri, b.bvh = Bvh(s.x_mm, s.tri);
  part_.push_back({std::move(b), low, high});
}

double BoneField::distance_mm(const Vec3& x) const {
  double least = std::numeric_limits<double>::infinity();
  for (const Part& p : part_) {
    const double box = (p.low_mm - x).cwiseMax(x - p.high_mm).cwiseMax(Vec3::Zero()).norm();
    if (box >= least) continue;
    const double far = p.surface.bvh.closest(x).distance_mm;
    least = std::min(least, box == 0 && p.surface.contains(x) ? -far : far);
  }
  return least;
}

bool BoneField::meets(const Vec3& from, const Vec3& direction, double reach_mm) const {
  std::array<Bvh::LineHit, 1> hit;
  return std::any_of(part_.begin(), part_.end(),
                     [&](const Part& p) { return p.surface.bvh.line(from, direction, 0, reach_mm, hit) > 0; });
}

Surface fragment_surface(const bone::Bones& bones, const bone::Fragment& f) {
  const bone::BoneSurface b = bone::bone_surface(bones.mesh(), bone::component_of(bones.mesh(), f.vertex));
  return compacted({b.X_mm, b.tri});
}

}  // namespace limberg
