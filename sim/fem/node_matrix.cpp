#include "sim/fem/node_matrix.h"

#include <algorithm>
#include <numeric>

namespace limberg::fem {
namespace {

/// Which unknowns move a node, and by how much: itself, or its masters.
class Masters {
 public:
  explicit Masters(const FemModel& m) : model_(m) {
    if (m.hanging.empty()) return;
    at_.assign(m.X_mm.size(), -1);
    for (size_t i = 0; i < m.hanging.size(); ++i) at_[size_t(m.hanging[i].node)] = int32_t(i);
  }
  bool hangs(int32_t v) const { return !at_.empty() && at_[size_t(v)] >= 0; }
  const HangingNode& of(int32_t v) const { return model_.hanging[size_t(at_[size_t(v)])]; }
  template <class F>
  void each(int32_t v, const F& f) const {
    if (!hangs(v)) return f(v, 1.0);
    const HangingNode& h = of(v);
    for (size_t k = 0; k < size_t(h.count); ++k) f(h.master[k], double(h.weight[k]));
  }

 private:
  const FemModel& model_;
  std::vector<int32_t> at_;
};

/// What a row is summed from: corner `a` of cell `c`, or node `a` of spring -1 - c, times a weight.
struct Share {
  int32_t cell = 0, corner = 0;
  double weight = 1;
};

class RowMaker {
 public:
  RowMaker(const FemModel& m, std::span<const SpringRow> springs, double mass_per_s2, std::span<const uint8_t> free,
           std::span<const uint8_t> wanted)
      : m_(m), springs_(springs), mass_(mass_per_s2), free_(free), masters_(m), matrix_(m.stencils.size()),
        place_(m.X_mm.size(), -1), hung_mass_(m.hanging.empty() || mass_per_s2 == 0 ? 0 : m.X_mm.size()) {
    // The shares of every wanted row, in the order of cells, then springs.
    const auto want = [&](int32_t v) { return free[size_t(v)] && (wanted.empty() || wanted[size_t(v)]); };
    begin_.assign(m.X_mm.size() + 1, 0);
    each_share(want, [&](int32_t v, const Share&) { ++begin_[size_t(v) + 1]; });
    std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
    share_.resize(size_t(begin_.back()));
    std::vector<int32_t> fill(begin_.begin(), begin_.end() - 1);
    each_share(want, [&](int32_t v, const Share& s) { share_[size_t(fill[size_t(v)]++)] = s; });
    if (!hung_mass_.empty())
      for (size_t i = 0; i < m.hanging.size(); ++i)
        for (int k = 0; k < m.hanging[i].count; ++k)
          hung_mass_[size_t(m.hanging[i].master[size_t(k)])].push_back(int32_t(i));
  }

  void make(int32_t v, NodeMatrix& out) {
    row_.clear();
    if (mass_ > 0) {
      add(v, mass_ * m_.mass_kg[size_t(v)]);
      if (!hung_mass_.empty()) add_hanging_mass(v);
    }
    for (int32_t k = begin_[size_t(v)]; k < begin_[size_t(v) + 1]; ++k) {
      const Share& s = share_[size_t(k)];
      if (s.cell < 0) {
        const SpringRow& r = springs_[size_t(-1 - s.cell)];
        for (size_t b = 0; b < r.node.size(); ++b) add(r.node[b], r.k_mN_per_mm * r.w[size_t(s.corner)] * r.w[b]);
        continue;
      }
      const HexCell& c = m_.cells[size_t(s.cell)];
      const Mat8& K = matrix(c.stencil);
      for (int b = 0; b < 8; ++b) {
        const double value = s.weight * double(c.scale) * K(b, s.corner);
        masters_.each(c.node[size_t(b)], [&](int32_t node, double w) { add(node, w * value); });
      }
    }
    for (auto& e : row_) place_[size_t(e.first)] = -1;
    std::sort(row_.begin(), row_.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    for (auto& [node, value] : row_) {
      out.column.push_back(node);
      out.value.push_back(float(node == v ? value * (1 + floating_shift) : value));
    }
  }

 private:
  template <class Want, class F>
  void each_share(const Want& want, const F& f) const {
    for (size_t c = 0; c < m_.cells.size(); ++c)
      for (int32_t a = 0; a < 8; ++a)
        masters_.each(m_.cells[c].node[size_t(a)], [&](int32_t v, double w) {
          if (want(v)) f(v, Share{int32_t(c), a, w});
        });
    for (size_t s = 0; s < springs_.size(); ++s)
      for (size_t i = 0; i < springs_[s].node.size(); ++i)
        if (want(springs_[s].node[i])) f(springs_[s].node[i], Share{-1 - int32_t(s), int32_t(i), 1});
  }
  void add(int32_t node, double value) {
    if (!free_[size_t(node)]) return;
    int32_t& p = place_[size_t(node)];
    if (p < 0) p = int32_t(row_.size()), row_.push_back({node, 0});
    row_[size_t(p)].second += value;
  }
  void add_hanging_mass(int32_t v) {
    for (int32_t i : hung_mass_[size_t(v)]) {
      const HangingNode& h = m_.hanging[size_t(i)];
      double own = 0;
      for (size_t k = 0; k < size_t(h.count); ++k) own += h.master[k] == v ? double(h.weight[k]) : 0;
      for (size_t k = 0; k < size_t(h.count); ++k)
        add(h.master[k], mass_ * m_.mass_kg[size_t(h.node)] * own * double(h.weight[k]));
    }
  }
  const Mat8& matrix(int32_t stencil) {
    auto& K = matrix_[size_t(stencil)];
    if (!K) {
      const Mat8 one = scalar_cell_matrix(m_, m_.stencils[size_t(stencil)], true);
      K = std::make_unique<Mat8>(0.5 * (one + one.transpose()));  // to the last bit, so that the rows are
    }
    return *K;
  }

  const FemModel& m_;
  std::span<const SpringRow> springs_;
  double mass_;
  std::span<const uint8_t> free_;
  Masters masters_;
  std::vector<std::unique_ptr<Mat8>> matrix_;  // of the stencils met so far
  std::vector<int32_t> begin_, place_;
  std::vector<Share> share_;
  std::vector<std::vector<int32_t>> hung_mass_;
  std::vector<std::pair<int32_t, double>> row_;
};

bool same_stencil(const FemModel& m, const Stencil& a, const FemModel& n, const Stencil& b) {
  const auto law = [](const FemModel& model, const MaterialPoint& p) { return model.laws[size_t(p.law)].get(); };
  return a.volume_mm3 == b.volume_mm3 && a.mu_kPa == b.mu_kPa && a.lambda_kPa == b.lambda_kPa && a.level == b.level &&
         a.sample == b.sample && a.K == b.K && std::equal(a.points.begin(), a.points.end(), b.points.begin(), b.points.end(), [&](auto& p, auto& q) {
           return p.at == q.at && p.volume_mm3 == q.volume_mm3 && p.M == q.M && law(m, p) == law(n, q);
         });
}

}  // namespace

void keep_rising(std::vector<int32_t>& a) {
  std::vector<int32_t> tail;                    // place of the smallest last number of a rising sequence of each length
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
    const auto at = std::lower_bound(tail.begin(), tail.end(), a[i], [&](int32_t t, int32_t v) { return a[size_t(t)] < v; });
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

std::vector<uint8_t> free_nodes(const FemModel& m) {
  std::vector<uint8_t> free(m.X_mm.size(), 0);
  for (const HexCell& c : m.cells)
    for (int32_t v : c.node) free[size_t(v)] = 1;
  for (const HangingNode& h : m.hanging) {
    free[size_t(h.node)] = 0;
    for (int k = 0; k < h.count; ++k) free[size_t(h.master[size_t(k)])] = 1;
  }
  for (size_t v = 0; v < free.size(); ++v)
    if (m.fixed[v]) free[v] = 0;
  return free;
}

NodeMatrix assemble_rows(const FemModel& m, std::span<const SpringRow> springs, double mass_per_s2, std::span<const uint8_t> free) {
  RowMaker rows(m, springs, mass_per_s2, free, {});
  NodeMatrix A;
  A.begin.reserve(m.X_mm.size() + 1);
  A.column.reserve(27 * m.X_mm.size()), A.value.reserve(27 * m.X_mm.size());
  for (size_t v = 0; v < m.X_mm.size(); ++v) {
    if (free[v]) rows.make(int32_t(v), A);
    A.begin.push_back(int32_t(A.column.size()));
  }
  return A;
}

NodeMatrix assemble_rows(const FemModel& m, std::span<const SpringRow> springs, double mass_per_s2, std::span<const uint8_t> free,
                         const NodeMatrix& before, const NodeChange& change) {
  RowMaker rows(m, springs, mass_per_s2, free, change.dirty);
  NodeMatrix A;
  A.begin.reserve(m.X_mm.size() + 1);
  A.column.reserve(before.column.size() + before.column.size() / 8), A.value.reserve(A.column.capacity());
  for (size_t v = 0; v < m.X_mm.size(); ++v) {
    if (free[v] && change.dirty[v])
      rows.make(int32_t(v), A);
    else if (free[v])
      copy_row(before, change.parent[v], change.child, A);
    A.begin.push_back(int32_t(A.column.size()));
  }
  return A;
}

void copy_row(const NodeMatrix& before, int32_t row, std::span<const int32_t> child, NodeMatrix& out) {
  const size_t from = size_t(before.begin[size_t(row)]), to = size_t(before.begin[size_t(row) + 1]), at = out.column.size();
  out.column.resize(at + to - from);
  for (size_t e = from; e < to; ++e) out.column[at + e - from] = child[size_t(before.column[e])];
  out.value.insert(out.value.end(), before.value.begin() + long(from), before.value.begin() + long(to));
}

bool same_model(const FemModel& a, const FemModel& b) {
  const auto same_cell = [](const HexCell& c, const HexCell& d) { return c.node == d.node && c.stencil == d.stencil && c.scale == d.scale; };
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
                    std::span<const SpringRow> springs_now, std::span<const int32_t> cell_parent, NodeChange& change) {
  const size_t n = now.X_mm.size(), n_before = before.X_mm.size();
  const bool itself = &before == &now;
  if ((!itself && cell_parent.size() != now.cells.size()) || now.cell_mm != before.cell_mm) return false;
  change.parent = now.parent;
  if (itself) std::iota(change.parent.begin(), change.parent.end(), 0);
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
    if (now.mass_kg[v] != before.mass_kg[size_t(p)]) masters.each(int32_t(v), [&](int32_t master, double) { change.dirty[size_t(master)] = 1; });
    if (other[v] || !masters.hangs(int32_t(v))) continue;
    const HangingNode &a = masters.of(int32_t(v)), &b = masters_before.of(p);
    other[v] = a.count != b.count || a.weight != b.weight;
    for (size_t k = 0; k < size_t(a.count) && !other[v]; ++k) other[v] = change.child[size_t(b.master[k])] != a.master[k];
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
      for (int32_t v : now.cells[c].node) masters.each(v, [&](int32_t master, double) { change.dirty[size_t(master)] = 1; });
  const auto touch_before = [&](int32_t p) {
    if (change.child[size_t(p)] >= 0) change.dirty[size_t(change.child[size_t(p)])] = 1;
  };
  for (size_t q = 0; q < before.cells.size(); ++q)
    if (now_of[q] < 0)
      for (int32_t v : before.cells[q].node) masters_before.each(v, [&](int32_t master, double) { touch_before(master); });
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

ScalarMatrix lower_columns(const NodeMatrix& A, double relative_shift) {
  ScalarMatrix L;
  L.row_of_node.assign(size_t(A.rows()), -1);
  for (int32_t v = 0; v < A.rows(); ++v)
    if (A.begin[size_t(v)] < A.begin[size_t(v) + 1]) L.row_of_node[size_t(v)] = L.n(), L.node_of_row.push_back(v);
  L.begin.push_back(0);
  L.row.reserve(A.column.size() / 2 + A.begin.size()), L.value.reserve(L.row.capacity());
  for (int32_t v : L.node_of_row) {
    for (int32_t e = A.begin[size_t(v)]; e < A.begin[size_t(v) + 1]; ++e) {
      const int32_t u = A.column[size_t(e)];
      if (u < v) continue;
      L.row.push_back(L.row_of_node[size_t(u)]);
      L.value.push_back(double(A.value[size_t(e)]) * (u == v ? 1 + relative_shift : 1));
    }
    L.begin.push_back(int32_t(L.row.size()));
  }
  return L;
}

}  // namespace limberg::fem
