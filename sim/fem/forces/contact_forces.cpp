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
const char* ContactForces::fault_of(const FemModel& model, const Contact& c, Item& it, Friction* f) {
  it = Item();
  it.normal = c.normal.cast<double>();
  it.k = double(c.k_N_per_mm) * 1000;
  it.soft = double(c.soft_mm);
  it.offset = -double(c.gap_mm);
  if (!(std::fabs(it.normal.norm() - 1) < 1e-3) || !(it.k > 0) || !std::isfinite(it.k) || !(it.soft >= 0) ||
      !std::isfinite(it.offset))
    return "a contact has no unit normal, no positive stiffness or no finite gap";
  if (f) {
    *f = Friction();
    f->from = -c.stick_mm.cast<double>(), f->hold = double(c.hold_mN), f->k = double(c.grip_N_per_mm) * 1000;
    if (!(f->hold >= 0) || !std::isfinite(f->hold) || (f->hold > 0 && !(f->k > 0 && std::isfinite(f->k))) ||
        !f->from.allFinite())
      return "a contact's friction has no finite hold, or none that is positive without a spring";
  }
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
      if (f) f->from += w * model.X_mm[size_t(p.node[i])];
    }
  }
  return nullptr;
}

void ContactForces::set(const FemModel& model, std::span<const Contact> contacts, Workers& workers) {
  struct NoneUnlessWhole {  // contacts half set name nodes of another model
    std::vector<Item>& item;
    std::vector<Friction>& friction;
    bool whole = false;
    ~NoneUnlessWhole() {
      if (!whole) item.clear(), friction.clear();
    }
  } set{item_, friction_};
  item_.resize(contacts.size());
  const bool grips = std::any_of(contacts.begin(), contacts.end(), [](const Contact& c) { return c.hold_mN != 0; });
  friction_.resize(grips ? contacts.size() : 0);
  force_.resize(contacts.size());
  energy_.assign((contacts.size() + kGrain - 1) / kGrain, 0);
  std::vector<const char*> fault(energy_.size(), nullptr);  // the first of each chunk
  workers.parallel_for(contacts.size(), kGrain, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i)
      if (const char* wrong = fault_of(model, contacts[i], item_[i], grips ? &friction_[i] : nullptr);
          wrong && !fault[begin / kGrain])
        fault[begin / kGrain] = wrong;
  });
  for (const char* wrong : fault)
    if (wrong) throw InputError("", 0, wrong);
  set.whole = true;
}

v4 ContactForces::relative(const Item& it, const NodeArray& u) const {
  v4 a = {}, b = {};
  for (size_t k = 0; k < 8; ++k) {
    a += it.w[k] * load(u[size_t(it.node[k])]);
    b += it.w[8 + k] * load(u[size_t(it.node[8 + k])]);
  }
  return a + b;
}

double ContactForces::clearance_mm(size_t i, const NodeArray& u) const {
  const Item& it = item_[i];
  const v4 r = relative(it, u);
  return it.offset + it.normal[0] * double(r[0]) + it.normal[1] * double(r[1]) + it.normal[2] * double(r[2]);
}

double ContactForces::force_mN(size_t i, const NodeArray& u) const {
  return contact_push(clearance_mm(i, u), item_[i].k, item_[i].soft).force;
}

// `force`: on point a, mN.
Push ContactForces::pull(const Item& it, const Friction& f, const v4& r, v4& force) const {
  const Vec3 way = f.from + Vec3(double(r[0]), double(r[1]), double(r[2]));
  const Vec3 slid = way - it.normal.dot(way) * it.normal;
  const double slid_mm = slid.norm();
  const Push p = friction_pull(slid_mm, f.k, f.hold);
  const Vec3 back = slid_mm > 0 ? Vec3(-p.force / slid_mm * slid) : Vec3::Zero();
  force = v4{float(back[0]), float(back[1]), float(back[2]), 0};
  return p;
}

Vec3 ContactForces::friction_mN(size_t i, const NodeArray& u) const {
  v4 force = {};
  if (!friction_.empty() && friction_[i].hold > 0) pull(item_[i], friction_[i], relative(item_[i], u), force);
  return {double(force[0]), double(force[1]), double(force[2])};
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
      if (friction_.empty() || !(friction_[i].hold > 0)) continue;
      sum += pull(item_[i], friction_[i], relative(item_[i], u), friction_[i].force).energy;
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
  for (size_t i = 0; i < friction_.size(); ++i) {
    const v4 f = friction_[i].force;
    const float size = std::sqrt(f[0] * f[0] + f[1] * f[1] + f[2] * f[2]);
    if (!(size > 0)) continue;
    const Item& it = item_[i];
    for (size_t k = 0; k < 16; ++k) {
      Node4& n = g[size_t(it.node[k])];
      store(n, load(n) - it.w[k] * f);
      if (measure) n.w += size * std::fabs(it.w[k]);
    }
  }
  return energy;
}

}  // namespace limberg::fem
