#include "sim/fem/forces/spring_forces.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "sim/fem/forces/spring_end.h"

namespace limberg::fem {

SpringForces::SpringForces(const FemModel& model, std::span<const Spring> springs) {
  std::map<int32_t, int> number;
  for (const Spring& s : springs) {
    Item it;
    it.id = s.id;
    it.k = s.k_N_per_mm * 1000;
    auto add = [&](std::span<const HeldPlace> end, double sign) {
      const size_t first = it.node.size();
      for_each_weight(end, [&](int32_t node, double share) {
        const double w = sign * share;
        const auto known = std::find(it.node.begin() + std::ptrdiff_t(first), it.node.end(), node);
        if (known == it.node.end())
          it.node.push_back(node), it.w.push_back(w);
        else
          it.w[size_t(known - it.node.begin())] += w;
        it.offset += w * model.X_mm[size_t(node)];
      });
    };
    add(s.held_a(), 1);
    if (!s.to_world) add(s.held_b(), -1);
    if (s.thread > 0) {
      const auto [at, fresh] = number.try_emplace(s.thread, int(threads_.size()));
      if (fresh) threads_.push_back({s.thread_mm, {}});
      it.thread = at->second;
      it.keep_mm = s.target_mm.norm();
      threads_[size_t(it.thread)].length_mm -= it.keep_mm;
      threads_[size_t(it.thread)].spans.push_back(items_.size());
    } else {
      it.offset -= s.target_mm;
    }
    items_.push_back(std::move(it));
  }
}

Vec3 SpringForces::gap_mm(size_t i, const NodeArray& u) const {
  const Item& it = items_[i];
  Vec3 r = it.offset;
  for (size_t k = 0; k < it.node.size(); ++k) {
    const Node4& v = u[size_t(it.node[k])];
    r += it.w[k] * Vec3(double(v.x), double(v.y), double(v.z));
  }
  return r;
}

double SpringForces::thread_stretch_mm(std::vector<double>& l, double thread_mm) {
  // sum max(0, l - m) falls with m in straight pieces, which part at the l: the longest n spans hold the thread.
  std::sort(l.begin(), l.end(), std::greater<>());
  double sum = 0;
  for (size_t n = 1; n <= l.size(); ++n) {
    sum += l[n - 1];
    const double m = (sum - thread_mm) / double(n);
    if (n == l.size() || m >= l[n]) return std::max(0.0, m);
  }
  return 0;
}

double SpringForces::length_mm(const Item& it, const Vec3& r) const { return std::max(0.0, r.norm() - it.keep_mm); }

double SpringForces::stretch_mm(const Thread& t, const NodeArray& u) const {
  std::vector<double> length;
  length.reserve(t.spans.size());
  for (size_t i : t.spans) length.push_back(length_mm(items_[i], gap_mm(i, u)));
  return thread_stretch_mm(length, std::max(0.0, t.length_mm));
}

Vec3 SpringForces::force_mN(size_t i, const NodeArray& u) const {
  const Item& it = items_[i];
  const Vec3 r = gap_mm(i, u);
  if (it.thread < 0) return -it.k * r;
  const double l = length_mm(it, r), m = stretch_mm(threads_[size_t(it.thread)], u);
  return l > 0 ? Vec3(-it.k * std::min(l, m) / r.norm() * r) : Vec3(Vec3::Zero());
}

void SpringForces::pull(const Item& it, const Vec3& force, NodeArray& g, bool measure) const {
  const double size = force.norm();
  for (size_t k = 0; k < it.node.size(); ++k) {
    const Vec3 f = it.w[k] * force;
    Node4& n = g[size_t(it.node[k])];
    n.x += float(f[0]), n.y += float(f[1]), n.z += float(f[2]);
    if (measure) n.w += float(size * std::fabs(it.w[k]));
  }
}

double SpringForces::add(const NodeArray& u, NodeArray& g, bool measure) const {
  double energy = 0;
  for (size_t i = 0; i < items_.size(); ++i) {
    const Item& it = items_[i];
    if (it.thread >= 0) continue;
    const Vec3 r = gap_mm(i, u);
    energy += 0.5 * it.k * r.squaredNorm();
    const double size = it.k * r.norm();
    for (size_t k = 0; k < it.node.size(); ++k) {
      const Vec3 f = it.k * it.w[k] * r;
      Node4& n = g[size_t(it.node[k])];
      n.x += float(f[0]), n.y += float(f[1]), n.z += float(f[2]);
      if (measure) n.w += float(size * std::fabs(it.w[k]));
    }
  }
  for (const Thread& t : threads_) {
    const double m = stretch_mm(t, u);
    for (size_t i : t.spans) {
      const Vec3 r = gap_mm(i, u);
      const double l = length_mm(items_[i], r), pulled = std::min(l, m);
      if (!(pulled > 0)) continue;
      energy += 0.5 * items_[i].k * pulled * pulled;
      pull(items_[i], items_[i].k * pulled / r.norm() * r, g, measure);
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
