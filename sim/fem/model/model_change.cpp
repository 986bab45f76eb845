// What of a model's rows is the same as in the model before (node_matrix.h).
#include <algorithm>

#include "sim/fem/model/masters.h"
#include "sim/fem/preconditioner/node_matrix.h"

namespace limberg::fem {
namespace {

bool same_stencil(const FemModel& m, const Stencil& a, const FemModel& n, const Stencil& b) {
  const auto law = [](const FemModel& model, const MaterialPoint& p) { return model.laws[size_t(p.law)].get(); };
  return a.volume_mm3 == b.volume_mm3 && a.mu_kPa == b.mu_kPa && a.lambda_kPa == b.lambda_kPa && a.level == b.level &&
         a.sample == b.sample && a.mean_gradients == b.mean_gradients && a.K == b.K && a.slide_kPa == b.slide_kPa &&
         std::equal(a.points.begin(), a.points.end(), b.points.begin(), b.points.end(), [&](auto& p, auto& q) {
           return p.at == q.at && p.volume_mm3 == q.volume_mm3 && p.M == q.M && p.gradients == q.gradients &&
                  law(m, p) == law(n, q);
         });
}

}  // namespace

void keep_rising(std::vector<int32_t>& a) {
  std::vector<int32_t> tail;  // place of the smallest last number of a rising sequence of each length
  std::vector<int32_t> before(a.size(), -1);
  bool rising = true;
  for (size_t i = 0, last = a.size(); i < a.size(); ++i) {
    if (a[i] < 0) continue;
    rising = rising && (last == a.size() || a[last] < a[i]);
    last = i;
  }
  if (rising) return;
  for (size_t i = 0; i < a.size(); ++i) {
    if (a[i] < 0) continue;
    const auto at =
        std::lower_bound(tail.begin(), tail.end(), a[i], [&](int32_t t, int32_t v) { return a[size_t(t)] < v; });
    if (at != tail.begin()) before[i] = *(at - 1);
    if (at == tail.end())
      tail.push_back(int32_t(i));
    else
      *at = int32_t(i);
  }
  std::vector<uint8_t> kept(a.size(), 0);
  for (int32_t i = tail.back(); i >= 0; i = before[size_t(i)]) kept[size_t(i)] = 1;
  for (size_t i = 0; i < a.size(); ++i)
    if (!kept[i]) a[i] = -1;
}

bool same_model(const FemModel& a, const FemModel& b) {
  const auto same_cell = [](const HexCell& c, const HexCell& d) {
    return c.node == d.node && c.stencil == d.stencil && c.scale == d.scale;
  };
  const auto same_hanging = [](const HangingNode& c, const HangingNode& d) {
    return c.node == d.node && c.count == d.count && c.master == d.master && c.weight == d.weight;
  };
  return a.X_mm.size() == b.X_mm.size() && a.cells.size() == b.cells.size() && a.stencils.size() == b.stencils.size() &&
         a.cell_mm == b.cell_mm && a.fixed == b.fixed && a.mass_kg == b.mass_kg && a.X_mm == b.X_mm &&
         std::equal(a.hanging.begin(), a.hanging.end(), b.hanging.begin(), b.hanging.end(), same_hanging) &&
         std::equal(a.cells.begin(), a.cells.end(), b.cells.begin(), same_cell) &&
         std::equal(a.stencils.begin(), a.stencils.end(), b.stencils.begin(),
                    [&](const Stencil& s, const Stencil& t) { return same_stencil(a, s, b, t); });
}

bool compare_models(const FemModel& before, std::span<const SpringRow> springs_before, const FemModel& now,
                    std::span<const SpringRow> springs_now, const ParentList& cell_parent, NodeChange& change) {
  const size_t n = now.X_mm.size(), n_before = before.X_mm.size();
  const bool itself = &before == &now;
  if ((!itself && cell_parent.size() != now.cells.size()) || now.cell_mm != before.cell_mm) return false;
  change.parent = (itself ? ParentList::identity(n) : now.parent).flat();
  change.child.assign(n_before, -1);
  change.dirty.assign(n, 0);
  std::vector<uint8_t> children(n_before, 0);
  for (size_t v = 0; v < n; ++v) {
    int32_t& p = change.parent[v];
    if (p >= int32_t(n_before)) return false;
    if (p >= 0 && before.X_mm[size_t(p)] != now.X_mm[v]) p = -1;  // born of several
    if (p < 0) continue;
    children[size_t(p)] = uint8_t(std::min(2, children[size_t(p)] + 1));
    change.child[size_t(p)] = children[size_t(p)] == 1 ? int32_t(v) : -1;
  }
  keep_rising(change.child);

  // Nodes that play another part than before.
  const Masters masters(now), masters_before(before);
  const std::vector<uint8_t> free = free_nodes(now), free_before = free_nodes(before);
  std::vector<uint8_t> other(n, 0);
  for (size_t v = 0; v < n; ++v) {
    const int32_t p = change.parent[v];
    if (p < 0 || change.child[size_t(p)] < 0) {
      other[v] = 1;
      continue;
    }
    other[v] = free[v] != free_before[size_t(p)] || masters.hangs(int32_t(v)) != masters_before.hangs(p);
    if (now.mass_kg[v] != before.mass_kg[size_t(p)])
      masters.each(int32_t(v), [&](int32_t master, double) { change.dirty[size_t(master)] = 1; });
    if (other[v] || !masters.hangs(int32_t(v))) continue;
    const HangingNode &a = masters.of(int32_t(v)), &b = masters_before.of(p);
    other[v] = a.count != b.count || a.weight != b.weight;
    for (size_t k = 0; k < size_t(a.count) && !other[v]; ++k)
      other[v] = change.child[size_t(b.master[k])] != a.master[k];
  }

  // Cells that are what they were; whatever any other cell touches is dirty.
  std::vector<int32_t> now_of(before.cells.size(), -1);  // per cell before: the same cell now
  std::vector<int8_t> stencil(now.stencils.size(), -1);  // 1: the same as the one of that index before
  for (size_t c = 0; c < now.cells.size(); ++c) {
    const int32_t q = itself ? int32_t(c) : cell_parent[c];
    const HexCell& cell = now.cells[c];
    if (q < 0 || size_t(q) >= before.cells.size() || now_of[size_t(q)] >= 0) continue;
    const HexCell& old = before.cells[size_t(q)];
    bool same = cell.stencil == old.stencil && cell.scale == old.scale;
    for (size_t a = 0; a < 8 && same; ++a)
      same = !other[size_t(cell.node[a])] && change.parent[size_t(cell.node[a])] == old.node[a];
    if (!same) continue;
    int8_t& s = stencil[size_t(cell.stencil)];
    if (s < 0)
      s = size_t(cell.stencil) < before.stencils.size() &&
          same_stencil(now, now.stencils[size_t(cell.stencil)], before, before.stencils[size_t(cell.stencil)]);
    if (s == 1) now_of[size_t(q)] = int32_t(c);
  }
  keep_rising(now_of);
  std::vector<uint8_t> kept(now.cells.size(), 0);
  for (int32_t c : now_of)
    if (c >= 0) kept[size_t(c)] = 1;
  for (size_t c = 0; c < now.cells.size(); ++c)
    if (!kept[c])
      for (int32_t v : now.cells[c].node)
        masters.each(v, [&](int32_t master, double) { change.dirty[size_t(master)] = 1; });
  const auto touch_before = [&](int32_t p) {
    if (change.child[size_t(p)] >= 0) change.dirty[size_t(change.child[size_t(p)])] = 1;
  };
  for (size_t q = 0; q < before.cells.size(); ++q)
    if (now_of[q] < 0)
      for (int32_t v : before.cells[q].node)
        masters_before.each(v, [&](int32_t master, double) { touch_before(master); });
  for (size_t v = 0; v < n; ++v)
    if (other[v]) change.dirty[v] = 1;

  // Springs are matched in their order.
  size_t s = 0;
  const auto same_spring_row = [&](const SpringRow& a, const SpringRow& b) {
    bool same = a.k_mN_per_mm == b.k_mN_per_mm && a.w == b.w && a.node.size() == b.node.size();
    for (size_t i = 0; i < a.node.size() && same; ++i) same = a.node[i] == change.child[size_t(b.node[i])];
    return same;
  };
  const auto drop_before = [&](const SpringRow& r) {
    for (int32_t p : r.node) touch_before(p);
  };
  for (const SpringRow& r : springs_now) {
    size_t k = s;
    while (k < springs_before.size() && !same_spring_row(r, springs_before[k])) ++k;
    if (k == springs_before.size()) {
      for (int32_t v : r.node) change.dirty[size_t(v)] = 1;
      continue;
    }
    for (; s < k; ++s) drop_before(springs_before[s]);
    s = k + 1;
  }
  for (; s < springs_before.size(); ++s) drop_before(springs_before[s]);
  return true;
}

}  // namespace limberg::fem
