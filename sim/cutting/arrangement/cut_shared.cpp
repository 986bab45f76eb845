// Blades that continue an older wall (deepening, progressive drawing) share its explicit vertices by id.
#include <algorithm>

#include "sim/cutting/arrangement/cut_builder.h"
#include "sim/cutting/arrangement/sign_sort.h"

namespace limberg {

CutBuilder::Outcome CutBuilder::take_shared_edges() {
  const auto is_shared = [&](int32_t p) { return p < delta_.points; };
  std::vector<std::pair<int32_t, int32_t>> edges;
  for (int32_t s = first_orig_; s < int32_t(store_.orig.size()); ++s)
    for (size_t k = 0; k < 3; ++k) {
      const int32_t a = store_.orig[s].v[k], b = store_.orig[s].v[(k + 1) % 3];
      if (is_shared(a) && is_shared(b)) edges.push_back({std::min(a, b), std::max(a, b)});
    }
  if (edges.empty()) return ok;
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  for (const auto& [lo, hi] : edges) {
    // Every known point of the edge, from the older triangles that have it.
    std::vector<int32_t> chain{lo, hi};
    for (int32_t g = store_.op.size() > 1 ? store_.op[1].first_orig : first_orig_; g < first_orig_; ++g) {
      if (store_.edge_of_orig(g, lo, hi) < 0) continue;
      for (int32_t f : store_.faces_of(g))
        for (int32_t p : store_.face[f].v) {
          const PointKey key = store_.points.key(p);
          if (key.kind == PointKey::line_plane && key.id[0] == lo && key.id[1] == hi) chain.push_back(p);
        }
    }
    std::sort(chain.begin(), chain.end());
    chain.erase(std::unique(chain.begin(), chain.end()), chain.end());
    int axis = 0;
    (store_.points.approx(hi) - store_.points.approx(lo)).cwiseAbs().maxCoeff(&axis);
    sort_by_signs(chain.begin(), chain.end(),
                  [&](int32_t a, int32_t b) { return store_.points.order(axis, a, b) < 0; });
    for (int32_t p : chain)
      if (p != lo && p != hi) edge_point_.push_back({lo, hi, p});
    for (size_t i = 0; i + 1 < chain.size(); ++i)
      if (store_.edges.first(chain[i], chain[i + 1]) >= 0)
        shared_edge_.push_back({std::min(chain[i], chain[i + 1]), std::max(chain[i], chain[i + 1])});
  }
  std::sort(shared_edge_.begin(), shared_edge_.end());
  return ok;
}

std::vector<int32_t> live_shared_points(const ArrangementStore& store, const Blade& blade) {
  std::vector<int32_t> shared, live;
  for (int32_t p : blade.shared_point)
    if (p >= 0) shared.push_back(p);
  std::sort(shared.begin(), shared.end());
  const auto is_shared = [&](int32_t p) { return std::binary_search(shared.begin(), shared.end(), p); };
  for (const OrigTri& g : store.orig) {
    if (g.live == 0 || !(is_shared(g.v[0]) || is_shared(g.v[1]) || is_shared(g.v[2]))) continue;
    for (int32_t f : store.faces_of(int32_t(&g - store.orig.data()))) {
      if (!store.face[size_t(f)].live()) continue;
      for (int32_t p : store.face[size_t(f)].v) {
        const auto* ends = store.points.edge_of(p);
        if (!ends && is_shared(p)) live.push_back(p);
        if (ends && is_shared((*ends)[0]) && is_shared((*ends)[1]))
          live.push_back((*ends)[0]), live.push_back((*ends)[1]);
      }
    }
  }
  std::sort(live.begin(), live.end());
  std::vector<int32_t> out = blade.shared_point;
  for (int32_t& p : out)
    if (p >= 0 && !std::binary_search(live.begin(), live.end(), p)) p = -1;
  return out;
}

int CutBuilder::vote_at_shared_edge(int32_t a, int32_t b, int32_t s, int32_t third) const {
  std::vector<RadialFace> around;
  for (int32_t h = store_.edges.first(a, b); h >= 0; h = store_.edges.next(h)) {
    const Face& f = store_.face[h / 3];
    around.push_back(
        {&store_.orig[f.orig].plane, f.orig, f.v[size_t(h % 3)] == a ? 1 : -1, f.v[size_t(h % 3 + 2) % 3], f.mat, h});
  }
  // The new face as one of them; its own bits do not matter. Sense as if its corners were a, b, third.
  RadialFace me;
  me.plane = &store_.orig[s].plane;
  me.orig = s;
  me.third = third;
  me.sense = store_.points.turn(*me.plane, a, b, third);
  around.insert(around.begin(), me);
  if (!sort_radially(store_.points, a, b, around)) return -1;
  const bool after = around[1].cw_material(), before = around.back().ccw_material();
  return after != before ? -1 : after ? 1 : 0;
}

}  // namespace limberg
