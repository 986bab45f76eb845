#include "sim/fem/model/hanging_nodes.h"

#include <cmath>

namespace limberg::fem {

void follow_masters(std::span<const HangingNode> hanging, NodeArray& u) {
  for (const HangingNode& h : hanging) {
    v4 s = {};
    for (int k = 0; k < h.count; ++k) s += h.weight[size_t(k)] * load(u[size_t(h.master[size_t(k)])]);
    store(u[size_t(h.node)], s);
  }
}

void give_to_masters(std::span<const HangingNode> hanging, NodeArray& g) {
  for (const HangingNode& h : hanging) {
    const v4 f = load(g[size_t(h.node)]);
    for (int k = 0; k < h.count; ++k) {
      Node4& m = g[size_t(h.master[size_t(k)])];
      store(m, load(m) + h.weight[size_t(k)] * f);
    }
    g[size_t(h.node)] = Node4{};
  }
}

std::vector<int32_t> hanging_index(const FemModel& model) {
  std::vector<int32_t> at;
  if (model.hanging.empty()) return at;
  at.assign(model.X_mm.size(), -1);
  for (size_t i = 0; i < model.hanging.size(); ++i) at[size_t(model.hanging[i].node)] = int32_t(i);
  return at;
}

std::string check_hanging(const FemModel& m) {
  const int32_t n = int32_t(m.X_mm.size());
  int32_t last = -1;
  for (const HangingNode& h : m.hanging) {
    const std::string name = "hanging node " + std::to_string(h.node) + ": ";
    if (h.node <= last || h.node >= n) return name + "the list is not ascending by node";
    last = h.node;
    if (h.count != 2 && h.count != 4) return name + "2 or 4 masters were expected";
  }
  const std::vector<int32_t> at = hanging_index(m);
  for (const HangingNode& h : m.hanging) {
    const std::string name = "hanging node " + std::to_string(h.node) + ": ";
    float sum = 0;
    Vec3 X = Vec3::Zero();
    for (size_t k = 0; k < size_t(h.count); ++k) {
      const int32_t v = h.master[k];
      if (v < 0 || v >= n) return name + "a master is no node";
      if (at[size_t(v)] >= 0) return name + "a master hangs itself";
      sum += h.weight[k];
      X += double(h.weight[k]) * m.X_mm[size_t(v)];
    }
    if (std::fabs(sum - 1) > 1e-6f) return name + "its weights do not sum to 1";
    if ((X - m.X_mm[size_t(h.node)]).norm() > 1e-6 * m.cell_mm.norm()) return name + "its masters do not surround it";
    if (m.fixed[size_t(h.node)].any()) return name + "it is fixed; only its masters may be";
  }
  return {};
}

}  // namespace limberg::fem
