#include "sim/patient/soft_hold.h"

#include <map>

#include "sim/geometry/triangle.h"

namespace limberg {
namespace {

constexpr int32_t kFirstSoft = 1 << 28;

struct SoftlyHeld {
  std::array<double, 8> w{};
  double k_mN_mm = 0;
};

}  // namespace

const std::vector<Spring>& SoftHold::springs() {
  const SurfaceTopology& s = tissue_.surface();
  if (found_ && version_ == s.version) return springs_;
  version_ = s.version, found_ = true;
  springs_.clear();
  const std::vector<float>& soft = tissue_.body().soft_kPa_mm;
  if (soft.empty()) return springs_;
  std::map<std::array<int32_t, 8>, SoftlyHeld> of_cell;
  const SurfaceView& view = s.view;
  for (size_t t = 0; t < view.tri.size(); ++t) {
    if (view.kind[t] == FaceKind::wall || !(soft[size_t(view.origin[t])] > 0)) continue;
    const Tri& c = view.tri[t];
    const double area =
        0.5 * area_vector2(view.X_mm[size_t(c[0])], view.X_mm[size_t(c[1])], view.X_mm[size_t(c[2])]).norm();
    for (const int32_t v : c) {
      const EmbeddedPoint& at = s.embedding[size_t(v)];
      SoftlyHeld& held = of_cell[at.node];
      const double k = double(soft[size_t(view.origin[t])]) * area / 3;
      held.k_mN_mm += k;
      for (size_t i = 0; i < 8; ++i) held.w[i] += k * double(at.w[i]);
    }
  }
  const FemModel& m = *tissue_.version().model;
  for (const auto& [node, held] : of_cell) {
    if (!(held.k_mN_mm > 0)) continue;
    Spring spring;
    spring.id = kFirstSoft + int32_t(springs_.size()), spring.to_world = spring.lasting = true;
    spring.k_N_per_mm = 1e-3 * held.k_mN_mm;
    spring.a.node = node;
    for (size_t i = 0; i < 8; ++i) {
      spring.a.w[i] = float(held.w[i] / held.k_mN_mm);
      spring.target_mm += double(spring.a.w[i]) * m.X_mm[size_t(node[i])];
    }
    springs_.push_back(spring);
  }
  return springs_;
}

Vec3 SoftHold::force_mN() const {
  Vec3 sum = Vec3::Zero();
  for (const Spring& s : springs_) sum += tissue_.solver().spring_force_mN(s.id);
  return sum;
}

}  // namespace limberg
