#include "sim/fem/contact_forces.h"

#include <cmath>

#include "sim/error.h"

namespace limberg::fem {

ContactForces::ContactForces(const FemModel& model, std::span<const Contact> contacts) {
  item_.reserve(contacts.size());
  share_.reserve(16 * contacts.size());
  for (const Contact& c : contacts) {
    Item it;
    it.normal = c.normal.cast<double>();
    it.k = double(c.k_N_per_mm) * 1000;
    it.offset = -double(c.gap_mm);
    it.first = int32_t(share_.size());
    if (!(std::fabs(it.normal.norm() - 1) < 1e-3) || !(it.k > 0) || !std::isfinite(it.k) || !std::isfinite(it.offset))
      throw InputError("", 0, "a contact has no unit normal, no positive stiffness or no finite gap");
    // Double weights, so that two places with the same weights meet to the last bit.
    const auto add = [&](const EmbeddedPoint& p, double sign) {
      double sum = 0;
      for (float w : p.w) sum += double(w);
      for (size_t i = 0; i < 8; ++i) {
        if (p.w[i] == 0) continue;
        if (p.node[i] < 0 || size_t(p.node[i]) >= model.X_mm.size())
          throw InputError("", 0, "a contact names a node that the model does not have");
        const double w = sign * double(p.w[i]) / sum;
        it.offset += w * it.normal.dot(model.X_mm[size_t(p.node[i])]);
        Share* same = nullptr;
        for (size_t k = size_t(it.first); k < share_.size(); ++k)
          if (share_[k].node == p.node[i]) same = &share_[k];
        if (same)
          same->w += w;
        else
          share_.push_back({p.node[i], w});
      }
    };
    add(c.a, 1);
    add(c.b, -1);
    it.count = int32_t(share_.size()) - it.first;
    item_.push_back(it);
  }
}

double ContactForces::clearance_mm(size_t i, const NodeArray& u) const {
  const Item& it = item_[i];
  const Share* s = share_.data() + it.first;
  double x = 0, y = 0, z = 0;
  for (int32_t k = 0; k < it.count; ++k) {
    const Node4& v = u[size_t(s[k].node)];
    x += s[k].w * double(v.x), y += s[k].w * double(v.y), z += s[k].w * double(v.z);
  }
  return it.offset + it.normal[0] * x + it.normal[1] * y + it.normal[2] * z;
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
    const Share* share = share_.data() + it.first;
    for (int32_t k = 0; k < it.count; ++k) {
      const double f = it.k * s * share[k].w;
      Node4& n = g[size_t(share[k].node)];
      n.x += float(f * it.normal[0]), n.y += float(f * it.normal[1]), n.z += float(f * it.normal[2]);
      if (measure) n.w += float(std::fabs(f));
    }
  }
  return energy;
}

}  // namespace limberg::fem
