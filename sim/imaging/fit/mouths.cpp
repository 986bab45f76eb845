#include "sim/imaging/fit/mouths.h"

#include <algorithm>
#include <cmath>

#include "sim/imaging/fit/prepare.h"

namespace limberg::imaging {

namespace {

constexpr int kChamferStep[4] = {0, 3, 4, 5};  // chamfer lengths of a step along one, two, three axes: thirds of a step
constexpr int32_t kLayer = 6;                  // thickness of a throat: no way jumps over it
constexpr int kMouthRounds = 8;

/// Shortest ways from the seeds through `may`, the nodes in order of their length.
struct Ways {
  std::vector<int32_t> length;  // -1: none
  std::vector<size_t> parent, order;
};
Ways ways(const GridSize& n, const std::vector<uint8_t>& may, const std::vector<size_t>& seeds) {
  Ways w{std::vector<int32_t>(may.size(), -1), std::vector<size_t>(may.size(), 0), {}};
  std::vector<std::vector<size_t>> at(6);  // a ring of buckets: no step is longer than 5
  size_t open = seeds.size();
  for (const size_t i : seeds) w.length[i] = 0, at[0].push_back(i);
  std::vector<size_t> now;
  for (int32_t d = 0; open > 0; ++d) {
    now.clear();
    now.swap(at[size_t(d % 6)]);
    open -= now.size();
    for (const size_t i : now) {
      if (w.length[i] != d) continue;
      w.order.push_back(i);
      all_around(n, i, [&](size_t j, int axes) {
        const int32_t l = d + kChamferStep[axes];
        if (!may[j] || (w.length[j] >= 0 && w.length[j] <= l)) return;
        w.length[j] = l, w.parent[j] = i, at[size_t(l % 6)].push_back(j), ++open;
      });
    }
  }
  return w;
}

struct Throat {
  std::vector<size_t> node;
  GridMouth mouth;
  double score = 0;    // depth over width; 0: too narrow
  int32_t outer = -1;  // the throat before it
  std::vector<int32_t> inner;
};

/// Throats of every level, each level's after the one's before.
std::vector<Throat> throats_of(const GridSize& n, const Ways& w, const MouthRule& rule) {
  std::vector<Throat> out;
  std::vector<int32_t> mark(w.length.size(), -1), before;
  for (int level = 0; level < rule.levels; ++level) {
    const int32_t from = int32_t(std::lround(3 * rule.threshold)) + kLayer * level, to = from + kLayer;
    const size_t first = out.size();
    before = mark;
    std::fill(mark.begin(), mark.end(), -1);
    for (const size_t i : w.order) {
      if (w.length[i] < from || w.length[i] >= to || mark[i] >= 0) continue;
      Throat t;
      t.node.push_back(i);
      mark[i] = int32_t(out.size());
      for (size_t k = 0; k < t.node.size(); ++k)
        all_around(n, t.node[k], [&](size_t j, int) {
          if (w.length[j] >= from && w.length[j] < to && mark[j] < 0) mark[j] = mark[i], t.node.push_back(j);
        });
      for (const size_t k : t.node) {
        const auto a = node_at(n, k);
        t.mouth.centre += Vec3(a[0], a[1], a[2]) / double(t.node.size());
      }
      t.mouth.width = 2 * std::sqrt(double(t.node.size()) / (M_PI * kLayer / 3));
      t.outer = before[i];
      out.push_back(std::move(t));
    }
    if (out.size() == first) break;
    for (const size_t i : w.order) {
      if (w.length[i] >= to && mark[w.parent[i]] >= 0) mark[i] = mark[w.parent[i]];
      if (mark[i] >= 0)
        out[size_t(mark[i])].mouth.depth =
            std::max(out[size_t(mark[i])].mouth.depth, (w.length[i] - from) / 3. + rule.threshold);
    }
  }
  for (size_t i = 0; i < out.size(); ++i) {
    if (out[i].mouth.width >= rule.least_width && out[i].mouth.width <= rule.most_width)
      out[i].score = out[i].mouth.depth / out[i].mouth.width;
    if (out[i].outer >= 0) out[size_t(out[i].outer)].inner.push_back(int32_t(i));
  }
  return out;
}

}  // namespace

std::vector<GridMouth> find_mouths(const GridSize& n, const std::vector<uint8_t>& set,
                                   const std::vector<uint8_t>& within, const Reach& narrow, const Reach& wide,
                                   const MouthRule& rule, std::vector<uint8_t>& fill, Workers& workers) {
  std::vector<uint8_t> pocket(set.size()), wide_air(set.size());
  for (size_t i = 0; i < set.size(); ++i)
    wide_air[i] = wide.air(i), pocket[i] = within[i] && !set[i] && narrow.air(i) && !wide_air[i];
  const std::vector<uint8_t> whole = pocket;
  std::vector<size_t> seeds;
  for (size_t i = 0; i < set.size(); ++i) {
    if (!wide_air[i]) continue;
    bool beside = false;
    neighbours(n, i, [&](size_t j) { beside |= pocket[j] != 0; });
    if (beside) seeds.push_back(i);
  }
  std::vector<GridMouth> mouth;
  std::vector<uint8_t> plug(set.size(), 0);
  Ways w;
  for (int round = 0; round < kMouthRounds; ++round) {
    w = ways(n, pocket, seeds);
    const std::vector<Throat> throat = throats_of(n, w, rule);
    // Best of each throat and of what lies behind it.
    std::vector<double> best(throat.size());
    for (size_t i = throat.size(); i-- > 0;) {
      best[i] = std::max(best[i], throat[i].score);
      if (throat[i].outer >= 0) best[size_t(throat[i].outer)] = std::max(best[size_t(throat[i].outer)], best[i]);
    }
    std::vector<uint8_t> closed(throat.size(), 0);
    bool any = false;
    for (size_t i = 0; i < throat.size(); ++i) {
      if (throat[i].outer >= 0 && closed[size_t(throat[i].outer)]) {
        closed[i] = 1;
        continue;
      }
      if (throat[i].score <= rule.depth_width || best[i] > rule.narrower * throat[i].score) continue;
      closed[i] = 1, any = true;
      mouth.push_back(throat[i].mouth);
      for (const size_t k : throat[i].node) plug[k] = 1, pocket[k] = 0;
    }
    if (!any) break;
    const std::vector<float> far = squared_distance(n, plug, workers);
    for (const size_t i : w.order) {  // ... and what lies straight before the throats
      const double before = rule.threshold - w.length[i] / 3. + 1;
      if (pocket[i] && before > 1 && double(far[i]) <= before * before) plug[i] = 1, pocket[i] = 0;
    }
  }
  fill.assign(set.size(), 0);
  if (!mouth.empty())
    for (size_t i = 0; i < set.size(); ++i) fill[i] = whole[i] ? (plug[i] ? 2 : w.length[i] < 0) : 0;
  std::stable_sort(mouth.begin(), mouth.end(),
                   [](const GridMouth& a, const GridMouth& b) { return a.width > b.width; });
  return mouth;
}

}  // namespace limberg::imaging
