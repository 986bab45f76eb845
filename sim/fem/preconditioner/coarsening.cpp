#include "sim/fem/preconditioner/coarsening.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "sim/base/union_find.h"

namespace limberg::fem {
namespace {

// up to so many, an odd number is not halved: a half-empty layer of blocks would be a large part
constexpr int few_layers = 7;

constexpr int32_t floor_div(int32_t a, int32_t b) { return a >= 0 ? a / b : -((b - 1 - a) / b); }

/// A coarse cell: the box that its corners span, eighths.
struct CoarseBox {
  std::array<int32_t, 3> low, size;
  /// f(corner, weight) for the corners with a weight at a place in the box.
  template <class F>
  void each(const std::array<int32_t, 3>& at, const F& f) const {
    std::array<float, 3> t;
    for (size_t i = 0; i < 3; ++i) t[i] = float(at[i] - low[i]) / float(size[i]);
    for (int k = 0; k < 8; ++k) {
      float w = 1;
      for (size_t i = 0; i < 3; ++i) w *= k >> i & 1 ? t[i] : 1 - t[i];
      if (w > 0) f(k, w);
    }
  }
};

}  // namespace

GridLevel grid_level(const FemModel& m, const Vec3& zero_mm, std::span<const uint8_t> free) {
  GridLevel g;
  g.free.assign(free.begin(), free.end());
  g.at.resize(m.X_mm.size());
  const Vec3 per_mm = 8 * m.cell_mm.cwiseInverse();
  for (size_t v = 0; v < m.X_mm.size(); ++v)
    for (int i = 0; i < 3; ++i) g.at[v][size_t(i)] = int32_t(std::lround((m.X_mm[v][i] - zero_mm[i]) * per_mm[i]));
  g.cells.resize(m.cells.size());
  for (size_t c = 0; c < m.cells.size(); ++c)
    g.cells[c] = {m.cells[c].node, g.at[size_t(m.cells[c].node[0])], 8 >> m.cells[c].level};
  return g;
}

BlockRule block_rule(const GridLevel& g) {
  BlockRule r;
  if (g.cells.empty()) return {{0, 0, 0}, {16, 16, 16}};
  std::array<int32_t, 3> high{};
  r.origin = high = g.cells[0].at;
  for (const GridCell& c : g.cells)
    for (size_t i = 0; i < 3; ++i) r.origin[i] = std::min(r.origin[i], c.at[i]), high[i] = std::max(high[i], c.at[i]);
  for (size_t i = 0; i < 3; ++i) {
    r.origin[i] = floor_div(r.origin[i], 8) * 8;
    const int32_t layers = floor_div(high[i] - r.origin[i], 8) + 1;
    r.size[i] = layers % 2 && layers <= few_layers ? 8 : 16;
  }
  return r;
}

BlockRule part_rule(const GridLevel& g) {
  std::array<size_t, 9> of_size{};
  for (const GridCell& c : g.cells) ++of_size[size_t(std::min(c.size, 8))];
  size_t smaller = 0;
  for (int32_t size = 2; size <= 8; size *= 2) {
    smaller += of_size[size_t(size / 2)];
    // Eight or more of them make one.
    const bool thins = 7 * smaller > 2 * g.cells.size();
    if (smaller > 0 && (thins || size == 8)) return {{0, 0, 0}, {size, size, size}, size};
  }
  return {};
}

Coarsening coarsen(const GridLevel& fine, const BlockRule& rule) {
  Coarsening out;
  out.rule = rule;
  const size_t cells = fine.cells.size(), nodes = fine.at.size();

  // Cells by block.
  std::vector<std::array<int32_t, 3>> block(cells);
  std::array<int32_t, 3> low{}, high{};
  for (size_t c = 0; c < cells; ++c)
    for (size_t i = 0; i < 3; ++i) {
      block[c][i] = floor_div(fine.cells[c].at[i] - rule.origin[i], rule.size[i]);
      low[i] = c ? std::min(low[i], block[c][i]) : block[c][i],
      high[i] = c ? std::max(high[i], block[c][i]) : block[c][i];
    }
  std::array<int64_t, 3> count;
  for (size_t i = 0; i < 3; ++i) count[i] = high[i] - low[i] + 1;
  const auto block_index = [&](const std::array<int32_t, 3>& b) {
    return size_t((int64_t(b[2] - low[2]) * count[1] + (b[1] - low[1])) * count[0] + (b[0] - low[0]));
  };
  std::vector<int32_t> begin(size_t(count[0] * count[1] * count[2]) + 1, 0), order(cells);
  for (size_t c = 0; c < cells; ++c) ++begin[block_index(block[c]) + 1];
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  {
    std::vector<int32_t> fill(begin.begin(), begin.end() - 1);
    for (size_t c = 0; c < cells; ++c) order[size_t(fill[block_index(block[c])]++)] = int32_t(c);
  }

  // Components in each block: cells that share a node.
  std::vector<int32_t> component(cells), seen_in(nodes, -1), seen_by(nodes, 0);
  std::vector<CoarseBox> component_box;
  const auto merges = [&](int32_t c) { return !rule.parts_below || fine.cells[size_t(c)].size < rule.parts_below; };
  const auto box_of = [&](int32_t c) -> CoarseBox {
    const GridCell& cell = fine.cells[size_t(c)];
    if (!merges(c)) return {cell.at, {cell.size, cell.size, cell.size}};
    CoarseBox box{{}, rule.size};
    for (size_t i = 0; i < 3; ++i) box.low[i] = rule.origin[i] + block[size_t(c)][i] * rule.size[i];
    return box;
  };
  {
    UnionFind joined(cells);
    for (size_t b = 0; b + 1 < begin.size(); ++b) {
      for (int32_t k = begin[b]; k < begin[b + 1]; ++k) {
        const int32_t c = order[size_t(k)];
        if (!merges(c)) continue;
        for (int32_t v : fine.cells[size_t(c)].node) {
          if (v < 0) continue;
          if (seen_in[size_t(v)] == int32_t(b))
            joined.unite(c, seen_by[size_t(v)]);
          else
            seen_in[size_t(v)] = int32_t(b), seen_by[size_t(v)] = c;
        }
      }
      for (int32_t k = begin[b]; k < begin[b + 1]; ++k) {  // the root is the component's first cell
        const int32_t c = order[size_t(k)], root = joined.find(c);
        if (root == c) component[size_t(c)] = int32_t(component_box.size()), component_box.push_back(box_of(c));
        component[size_t(c)] = component[size_t(root)];
      }
    }
  }

  // Corners of components, joined over the free nodes that they both interpolate.
  UnionFind corners(8 * component_box.size());
  std::vector<int32_t>&first = seen_in, &last = seen_by;  // per node: the first component that met it, and the latest
  std::fill(first.begin(), first.end(), -1);
  for (int32_t c : order) {
    const int32_t C = component[size_t(c)];
    for (int32_t v : fine.cells[size_t(c)].node) {
      if (v < 0 || !fine.free[size_t(v)]) continue;
      if (first[size_t(v)] < 0) first[size_t(v)] = last[size_t(v)] = C;
      if (last[size_t(v)] == C) continue;
      last[size_t(v)] = C;
      const int32_t F = first[size_t(v)];
      const std::array<int32_t, 3>& at = fine.at[size_t(v)];
      std::array<int32_t, 8> mine;
      int n = 0;
      component_box[size_t(F)].each(at, [&](int corner, float) { mine[size_t(n++)] = 8 * F + corner; });
      n = 0;
      component_box[size_t(C)].each(at, [&](int corner, float) { corners.unite(mine[size_t(n++)], 8 * C + corner); });
    }
  }

  // Corners that move something, numbered by place, and at one place by the first node that they move.
  std::vector<int32_t> number(corners.size(), -1), first_moved(corners.size(), -1);
  struct Key {
    int64_t place;
    int32_t moved, corner;
    bool operator<(const Key& o) const { return place != o.place ? place < o.place : moved < o.moved; }
  };
  // Whole blocks are counted in blocks, what parts are put together to stays in eighths.
  const auto coordinate = [&](const CoarseBox& box, int corner, size_t i) {
    const int32_t at = box.low[i] + (corner >> i & 1) * box.size[i];
    return rule.parts_below ? at : (at - rule.origin[i]) / rule.size[i];
  };
  std::vector<Key> keys;
  for (size_t v = 0; v < nodes; ++v) {
    if (!fine.free[v] || first[v] < 0) continue;
    const int32_t F = first[v];
    const CoarseBox& box = component_box[size_t(F)];
    box.each(fine.at[v], [&](int corner, float) {
      const int32_t root = corners.find(8 * F + corner);
      if (first_moved[size_t(root)] >= 0) return;
      first_moved[size_t(root)] = int32_t(v);
      int64_t place = 0;
      for (size_t i = 3; i-- > 0;) place = (place << 21) + (coordinate(box, corner, i) + (1 << 19));
      keys.push_back({place, int32_t(v), root});
    });
  }
  std::sort(keys.begin(), keys.end());
  out.place.reserve(keys.size());
  for (size_t k = 0; k < keys.size(); ++k)
    number[size_t(keys[k].corner)] = int32_t(k), out.place.push_back(keys[k].place);

  // The coarse lattice.
  GridLevel& g = out.level;
  g.free.assign(keys.size(), 1);
  g.at.resize(keys.size());
  g.cells.resize(component_box.size());
  const int32_t unit = rule.parts_below ? 1 : 8;
  for (size_t C = 0; C < component_box.size(); ++C) {
    const CoarseBox& box = component_box[C];
    if (rule.parts_below) g.cells[C].size = box.size[0];
    for (size_t i = 0; i < 3; ++i) g.cells[C].at[i] = unit * coordinate(box, 0, i);
    for (int k = 0; k < 8; ++k) {
      const int32_t v = number[size_t(corners.find(int32_t(8 * C) + k))];
      g.cells[C].node[size_t(k)] = v;
      if (v < 0) continue;
      for (size_t i = 0; i < 3; ++i) g.at[size_t(v)][i] = unit * coordinate(box, k, i);
    }
  }

  // Weights, and their transpose.
  Interpolation& P = out.prolong;
  P.begin.reserve(nodes + 1);
  P.column.reserve(4 * nodes), P.weight.reserve(4 * nodes);
  for (size_t v = 0; v < nodes; ++v) {
    if (fine.free[v] && first[v] >= 0) {
      const size_t start = P.column.size();
      const int32_t F = first[v];
      component_box[size_t(F)].each(fine.at[v], [&](int corner, float w) {
        const int32_t column = number[size_t(corners.find(8 * F + corner))];
        size_t k = P.column.size();
        P.column.push_back(column), P.weight.push_back(w);
        for (; k > start && P.column[k - 1] > column; --k) P.column[k] = P.column[k - 1], P.weight[k] = P.weight[k - 1];
        P.column[k] = column, P.weight[k] = w;
      });
    }
    P.begin.push_back(int32_t(P.column.size()));
  }
  Interpolation& R = out.restrict_;
  R.begin.assign(keys.size() + 1, 0);
  for (int32_t c : P.column) ++R.begin[size_t(c) + 1];
  std::partial_sum(R.begin.begin(), R.begin.end(), R.begin.begin());
  R.column.resize(P.column.size()), R.weight.resize(P.column.size());
  std::vector<int32_t> fill(R.begin.begin(), R.begin.end() - 1);
  for (size_t v = 0; v < nodes; ++v)
    for (int32_t e = P.begin[v]; e < P.begin[v + 1]; ++e) {
      const size_t to = size_t(fill[size_t(P.column[size_t(e)])]++);
      R.column[to] = int32_t(v), R.weight[to] = P.weight[size_t(e)];
    }
  return out;
}

namespace {

constexpr size_t leaf_nodes = 12;

void dissect(std::span<const std::array<int32_t, 3>> at, std::span<int32_t> nodes) {
  if (nodes.size() <= leaf_nodes) return;
  std::array<int32_t, 3> low = at[size_t(nodes[0])], high = low;
  for (int32_t v : nodes)
    for (size_t i = 0; i < 3; ++i)
      low[i] = std::min(low[i], at[size_t(v)][i]), high[i] = std::max(high[i], at[size_t(v)][i]);
  size_t axis = 0;
  for (size_t i = 1; i < 3; ++i)
    if (high[i] - low[i] > high[axis] - low[axis]) axis = i;
  if (high[axis] == low[axis]) return;  // copies of one place
  // The plane that holds the median node, unless it is the first or the last.
  std::vector<int32_t> plane;
  plane.reserve(nodes.size());
  for (int32_t v : nodes) plane.push_back(at[size_t(v)][axis]);
  std::nth_element(plane.begin(), plane.begin() + long(plane.size() / 2), plane.end());
  int32_t middle = plane[plane.size() / 2];
  if (middle == low[axis] || middle == high[axis]) {
    int32_t inner = middle;
    for (int32_t v : nodes) {
      const int32_t p = at[size_t(v)][axis];
      if (p != low[axis] && p != high[axis] && (inner == middle || std::abs(p - middle) < std::abs(inner - middle)))
        inner = p;
    }
    if (inner == middle) return;  // two planes only
    middle = inner;
  }
  const auto part = [&](int32_t v) {
    const int32_t p = at[size_t(v)][axis];
    return p < middle ? 0 : p > middle ? 1 : 2;
  };
  const auto second = std::stable_partition(nodes.begin(), nodes.end(), [&](int32_t v) { return part(v) == 0; });
  const auto last = std::stable_partition(second, nodes.end(), [&](int32_t v) { return part(v) == 1; });
  const size_t a = size_t(second - nodes.begin()), b = size_t(last - nodes.begin());
  dissect(at, nodes.subspan(0, a));
  dissect(at, nodes.subspan(a, b - a));
}

}  // namespace

std::vector<int32_t> dissection_order(std::span<const std::array<int32_t, 3>> at) {
  std::vector<int32_t> order(at.size());
  std::iota(order.begin(), order.end(), 0);
  dissect(at, order);
  return order;
}

}  // namespace limberg::fem
