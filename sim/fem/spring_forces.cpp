#include "sim/fem/spring_forces.h"

#include <cmath>

namespace limberg::fem {

SpringForces::SpringForces(const FemModel& model, std::span<const Spring> springs) {
  for (const Spring& s : springs) {
    Item it;
    it.id = s.id;
    it.k = s.k_N_per_mm * 1000;
    auto add = [&](const EmbeddedPoint& p, double sign) {
      double sum = 0;
      for (float x : p.w) sum += double(x);
      for (size_t i = 0; i < 8; ++i) {
        if (p.w[i] == 0) continue;
        const double w = sign * double(p.w[i]) / sum;  // single-precision weights sum to 1 only nearly
        it.node[size_t(it.count)] = p.node[i], it.w[size_t(it.count)] = w, ++it.count;
        it.offset += w * model.X_mm[size_t(p.node[i])];
      }
    };
    add(s.a, 1);
    if (!s.to_world) add(s.b, -1);
    it.offset -= s.target_mm;
    items_.push_back(it);
  }
}

Vec3 SpringForces::gap_mm(size_t i, const NodeArray& u) const {
  const Item& it = items_[i];
  Vec3 r = it.offset;
  for (size_t k = 0; k < size_t(it.count); ++k) {
    const Node4& v = u[size_t(it.node[k])];
    r += it.w[k] * Vec3(double(v.x), double(v.y), double(v.z));
  }
  return r;
}

double SpringForces::add(const NodeArray& u, NodeArray& g, bool measure) const {
  double energy = 0;
  for (size_t i = 0; i < items_.size(); ++i) {
    const Item& it = items_[i];
    const Vec3 r = gap_mm(i, u);
    energy += 0.5 * it.k * r.squaredNorm();
    const double size = it.k * r.norm();
    for (size_t k = 0; k < size_t(it.count); ++k) {
      const Vec3 f = it.k * it.w[k] * r;
      Node4& n = g[size_t(it.node[k])];
      n.x += float(f[0]), n.y += float(f[1]), n.z += float(f[2]);
      if (measure) n.w += float(size * std::fabs(it.w[k]));
    }
  }
  return energy;
}

int SpringForces::find(int32_t id) const {
  for (size_t i = 0; i < items_.size(); ++i)
    if (items_[i].id == id) return int(i);
  return -1;
}

}  // namespace limberg::fem
