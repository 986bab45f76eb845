#include "sim/fem/preconditioner/node_matrix.h"

#include <algorithm>
#include <numeric>

#include "sim/fem/model/masters.h"

namespace limberg::fem {
namespace {

/// What a row is summed from: corner `a` of cell `c`, or node `a` of spring -1 - c, times a weight.
struct Share {
  int32_t cell = 0, corner = 0;
  double weight = 1;
};

class RowMaker {
 public:
  RowMaker(const FemModel& m, std::span<const SpringRow> springs, double mass_per_s2, std::span<const uint8_t> free,
           std::span<const uint8_t> wanted)
      : m_(m),
        springs_(springs),
        mass_(mass_per_s2),
        free_(free),
        masters_(m),
        matrix_(m.stencils.size()),
        place_(m.X_mm.size(), -1),
        hung_mass_(m.hanging.empty() || mass_per_s2 == 0 ? 0 : m.X_mm.size()) {
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

}  // namespace

std::vector<uint8_t> free_nodes(const FemModel& m) {
  std::vector<uint8_t> free(m.X_mm.size(), 0);
  for (const HexCell& c : m.cells)
    for (int32_t v : c.node) free[size_t(v)] = 1;
  for (const HangingNode& h : m.hanging) {
    free[size_t(h.node)] = 0;
    for (int k = 0; k < h.count; ++k) free[size_t(h.master[size_t(k)])] = 1;
  }
  for (size_t v = 0; v < free.size(); ++v)
    if (m.fixed[v].all()) free[v] = 0;
  return free;
}

NodeMatrix assemble_rows(const FemModel& m, std::span<const SpringRow> springs, double mass_per_s2,
                         std::span<const uint8_t> free) {
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

NodeMatrix assemble_rows(const FemModel& m, std::span<const SpringRow> springs, double mass_per_s2,
                         std::span<const uint8_t> free, const NodeMatrix& before, const NodeChange& change) {
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
  const size_t from = size_t(before.begin[size_t(row)]), to = size_t(before.begin[size_t(row) + 1]),
               at = out.column.size();
  out.column.resize(at + to - from);
  for (size_t e = from; e < to; ++e) out.column[at + e - from] = child[size_t(before.column[e])];
  out.value.insert(out.value.end(), before.value.begin() + long(from), before.value.begin() + long(to));
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
