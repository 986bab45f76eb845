#include "sim/fem/forces/contact_forces.h"

#include <algorithm>
#include <cmath>

#include "sim/base/error.h"

namespace limberg::fem {
namespace {

constexpr size_t kGrain = 256;

}  // namespace

ContactForces::ContactForces(const FemModel& model, std::span<const Contact> contacts) {
  InlineWorkers here;
  set(model, contacts, here);
}

// Null when the contact is sound.
const char* ContactForces::fault_of(const FemModel& model, const Contact& c, Item& it) {
  it = Item();
  it.normal = c.normal.cast<double>();
  it.k = double(c.k_N_per_mm) * 1000;
  it.soft = double(c.soft_mm);
  it.offset = -double(c.gap_mm);
  if (!(std::fabs(it.normal.norm() - 1) < 1e-3) || !(it.k > 0) || !std::isfinite(it.k) || !(it.soft >= 0) ||
      !std::isfinite(it.offset))
    return "a contact has no unit normal, no positive stiffness or no finite gap";
  for (size_t side = 0; side < 2; ++side) {
    const EmbeddedPoint& p = side == 0 ? c.a : c.b;
    double sum = 0;  // single-precision weights sum to 1 only nearly
    for (float w : p.w) sum += double(w);
    for (size_t i = 0; i < 8; ++i) {
      if (p.w[i] == 0) continue;
      if (p.node[i] < 0 || size_t(p.node[i]) >= model.X_mm.size())
        return "a contact names a node that the model does not have";
      const double w = (side == 0 ? 1 : -1) * double(p.w[i]) / sum;
      it.node[8 * side + i] = p.node[i], it.w[8 * side + i] = float(w);
      it.offset += w * it.normal.dot(model.X_mm[size_t(p.node[i])]);
    }
  }
  return nullptr;
}

void ContactForces::set(const FemModel& model, std::span<const Contact> contacts, Workers& workers) {
  struct NoneUnlessWhole {  // contacts half set name nodes of another model
    std::vector<Item>& item;
    bool whole = false;
    ~NoneUnlessWhole() {
      if (!whole) item.clear();
    }
  } set{item_};
  item_.resize(contacts.size());
  force_.resize(contacts.size());
  energy_.assign((contacts.size() + kGrain - 1) / kGrain, 0);
  std::vector<const char*> fault(energy_.size(), nullptr);  // the first of each chunk
  workers.parallel_for(contacts.size(), kGrain, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i)
      if (const char* wrong = fault_of(model, contacts[i], item_[i]); wrong && !fault[begin / kGrain])
        fault[begin / kGrain] = wrong;
  });
  for (const char* wrong : fault)
    if (wrong) throw InputError("", 0, wrong);
  set.whole = true;
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
  return contact_push(clearance_mm(i, u), item_[i].k, item_[i].soft).force;
}

double ContactForces::add(const NodeArray& u, NodeArray& g, bool measure) {
  InlineWorkers here;
  return add(u, g, measure, here);
}

double ContactForces::add(const NodeArray& u, NodeArray& g, bool measure, Workers& workers) {
  workers.parallel_for(item_.size(), kGrain, [&](size_t begin, size_t end) {
    double sum = 0;
    for (size_t i = begin; i < end; ++i) {
      const Push push = contact_push(clearance_mm(i, u), item_[i].k, item_[i].soft);
      force_[i] = float(push.force), sum += push.energy;
    }
    energy_[begin / kGrain] = sum;
  });
  double energy = 0;
  for (double e : energy_) energy += e;
  for (size_t i = 0; i < item_.size(); ++i) {
    const float f = force_[i];
    if (f == 0) continue;
    const Item& it = item_[i];
    const v4 along = {-f * float(it.normal[0]), -f * float(it.normal[1]), -f * float(it.normal[2]), 0};
    for (size_t k = 0; k < 16; ++k) {
      Node4& n = g[size_t(it.node[k])];
      store(n, load(n) + it.w[k] * along);
      if (measure) n.w += std::fabs(f * it.w[k]);
    }
  }
  return energy;
}

}  // namespace limberg::fem
