#include "sim/fem/forces/dead_loads.h"

#include <cmath>

#include "sim/fem/forces/spring_end.h"
#include "sim/fem/model/held_pieces.h"

namespace limberg::fem {
namespace {

constexpr double mm_per_m = 1000;

}  // namespace

DeadLoads::DeadLoads(const FemModel& m, const Vec3& gravity_m_s2, std::span<const DeadLoad> loads,
                     std::span<const Spring> springs) {
  if (loads.empty() && gravity_m_s2.isZero(0)) return;
  std::vector<Vec3> f(m.X_mm.size());
  for (size_t v = 0; v < f.size(); ++v) f[v] = mm_per_m * m.mass_kg[v] * gravity_m_s2;
  for (const DeadLoad& l : loads) for_each_weight(l.at, [&](int32_t v, double w) { f[size_t(v)] += w * l.force_mN; });
  const std::vector<Held> held = held_pieces(m, springs).held;
  all_.resize(f.size());
  bool loose = false;
  for (size_t v = 0; v < f.size(); ++v) {
    all_[v] = {float(f[v][0]), float(f[v][1]), float(f[v][2]), 0};
    for (int a = 0; a < 3; ++a) loose = loose || (f[v][a] != 0 && !held[v].along(a));
  }
  if (!loose) return;
  held_ = all_;
  for (size_t v = 0; v < f.size(); ++v)
    for (int a = 0; a < 3; ++a)
      if (!held[v].along(a)) (&held_[v].x)[a] = 0;
}

double DeadLoads::add(const NodeArray& u, NodeArray& g, bool measure, double& magnitude) const {
  const NodeArray& force = acting();
  double energy = 0, size = 0;
  for (size_t i = 0; i < force.size(); ++i) {
    const Node4 &f = force[i], &x = u[i];
    const double work = double(f.x) * double(x.x) + double(f.y) * double(x.y) + double(f.z) * double(x.z);
    energy -= work, size += std::fabs(work);
    store(g[i], load(g[i]) - load(f));
    if (measure) g[i].w += std::sqrt(f.x * f.x + f.y * f.y + f.z * f.z);
  }
  magnitude = size;
  return energy;
}

Vec3 DeadLoads::sum_mN() const {
  Vec3 sum = Vec3::Zero();
  for (const Node4& f : acting()) sum += Vec3(double(f.x), double(f.y), double(f.z));
  return sum;
}

}  // namespace limberg::fem
