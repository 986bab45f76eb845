#include "sim/patient/carried_skin.h"

#include <algorithm>

namespace limberg {

void CarriedSkin::carry(SoftTissue& skin, const Head& head) {
  const bone::Bones& bones = head.bones();
  std::vector<Eigen::Isometry3d> poses;
  for (const bone::Fragment& f : bones.fragments()) poses.push_back(f.pose);
  const bool moved = poses.size() != poses_.size() ||
                     !std::equal(poses.begin(), poses.end(), poses_.begin(),
                                 [](const auto& a, const auto& b) { return a.matrix() == b.matrix(); });
  const bool other = skin_version_ != skin.topology()->version || bones_version_ != bones.version();
  if (!moved && !other && !stale_) return;
  poses_ = std::move(poses);
  size_t at = 0;
  if (other) carrier_.clear(), skin_version_ = skin.topology()->version, bones_version_ = bones.version();
  skin.hold_at([&](const Vec3& X) {
    if (other) {
      Vec3 on = Vec3::Zero();
      const int32_t id = bones.nearest_fragment(X, &on);
      carrier_.emplace_back(X, id >= 0 && (on - X).norm() <= reach_mm_ ? id : -1);
    }
    const bone::Fragment* f = bones.fragment(carrier_[at++].second);
    return f ? Vec3(f->pose * X) : X;
  });
  stale_ = false;
}

}  // namespace limberg
