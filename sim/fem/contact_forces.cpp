#include "sim/fem/contact_forces.h"

#include <cmath>

#include "sim/error.h"

namespace limberg::fem {

ContactForces::ContactForces(const FemModel& model, std::span<const Contact> contacts) {
  item_.reserve(contacts.size());
  for (const Contact& c : contacts) {
    Item it;
    it.normal = c.normal.cast<double>();
    it.k = double(c.k_N_per_mm) * 1000;
    it.offset = -double(c.gap_mm);
    if (!(std::fabs(it.normal.norm() - 1) < 1e-3) || !(it.k > 0) || !std::isfinite(it.k) || !std::isfinite(it.offset))
      throw InputError("", 0, "a contact has no unit normal, no positive stiffness or no finite gap");
    for (size_t side = 0; side < 2; ++side) {
      const EmbeddedPoint& p = side == 0 ? c.a : c.b;
      double sum = 0;  // single-precision weights sum to 1 only nearly
      for (float w : p.w) sum += double(w);
      for (size_t i = 0; i < 8; ++i) {
        if (p.w[i] == 0) continue;
        if (p.node[i] < 0 || size_t(p.node[i]) >= model.X_mm.size())
          throw InputError("", 0, "a contact names a node that the model does not have");
        const double w = (side == 0 ? 1 : -1) * double(p.w[i]) / sum;
        it.node[8 * side + i] = p.node[i], it.w[8 * side + i] = float(w);
        it.offset += w * it.normal.dot(model.X_mm[size_t(p.node[i])]);
      }
    }
    item_.push_back(it);
  }
}

double ContactForces::clearance_mm(size_t i, const NodeArray& u) const {
  const Item& it = item_[i];
  v4 a = {}, b = {};
  for (size_t k = 0; k < 8; ++k) {
    a += it.w[k] * load(u[size_t(it.node[k])]);
    b += it.w[8 + k] * load(u[size_t(it.node[8 + k])]);
  }
  const v4 r = a + b;
  return it.offset + it.normal[0] * double(r[0]) + it.normal[1] * double(r[1]) + it.normal[2] * double(r[2]);
}

double ContactForces::force_mN(size_t i, const NodeArray& u) const {
  const double s = clearance_mm(i, u);
  return s < 0 ? -item_[i].k * s : 0;
}

double ContactForces::add(const NodeArray& u, NodeArray& g, bool measure) const {
  double energy = 0;
  for (size_t i = 0; i < item_.size(); ++i) {
    const double s = clearance_mm(i, u);
    if (!(s < 0)) continue;
    const Item& it = item_[i];
    energy += 0.5 * it.k * s * s;
    const double f = it.k * s;
    const v4 along = {float(f * it.normal[0]), float(f * it.normal[1]), float(f * it.normal[2]), 0};
    for (size_t k = 0; k < 16; ++k) {
      Node4& n = g[size_t(it.node[k])];
      store(n, load(n) + it.w[k] * along);
      if (measure) n.w += float(std::fabs(f * double(it.w[k])));
    }
  }
  return energy;
}

}  // namespace limberg::fem
