#include "sim/fem/preconditioner/scalar_matrix.h"

#include <algorithm>
#include <map>
#include <numeric>

#include "sim/fem/elements/element_system.h"
#include "sim/fem/elements/material_points.h"
#include "sim/fem/forces/spring_end.h"
#include "sim/fem/model/hanging_nodes.h"

namespace limberg::fem {

namespace {

const HangingNode* hanging_at(const FemModel& m, int32_t node) {
  const auto it = std::lower_bound(m.hanging.begin(), m.hanging.end(), node,
                                   [](const HangingNode& h, int32_t n) { return h.node < n; });
  return it != m.hanging.end() && it->node == node ? &*it : nullptr;
}

/// A cell with hanging corners as the unknowns around it see it: T^T K T, T from `node` to the corners.
struct WideCell {
  std::vector<int32_t> node;
  Eigen::MatrixXd K;
};

WideCell widen(const FemModel& m, const HexCell& c, const Mat8& K, std::span<const int32_t> hangs) {
  WideCell w;
  std::vector<std::array<double, 8>> T;  // per node of w: its weight at each corner
  auto add = [&](int32_t node, size_t corner, double weight) {
    size_t k = size_t(std::find(w.node.begin(), w.node.end(), node) - w.node.begin());
    if (k == w.node.size()) w.node.push_back(node), T.push_back({});
    T[k][corner] += weight;
  };
  for (size_t a = 0; a < 8; ++a) {
    const int32_t at = hangs[size_t(c.node[a])];
    if (at < 0) {
      add(c.node[a], a, 1);
    } else {
      const HangingNode& h = m.hanging[size_t(at)];
      for (size_t k = 0; k < size_t(h.count); ++k) add(h.master[k], a, double(h.weight[k]));
    }
  }
  Eigen::MatrixXd t(8, Eigen::Index(w.node.size()));
  for (size_t k = 0; k < T.size(); ++k)
    for (int a = 0; a < 8; ++a) t(a, Eigen::Index(k)) = T[k][size_t(a)];
  w.K = double(c.scale) * (t.transpose() * K * t);
  w.K = (0.5 * (w.K + w.K.transpose())).eval();
  return w;
}

}  // namespace

Mat8 scalar_cell_matrix(const FemModel& m, const Stencil& s, bool augmented) {
  const Eigen::Matrix<double, 8, 3> B = volume_gradients(s, m.cell_mm);
  Mat8 K = s.K + effective_bulk_kPa(s, augmented) * s.volume_mm3 * (B * B.transpose());
  if (!s.points.empty()) K += points_scalar(m, s, m.cell_mm);
  return K;
}

SpringRow spring_row(const FemModel& model, const Spring& s) {
  SpringRow r;
  r.id = s.id;
  r.k_mN_per_mm = s.k_N_per_mm * 1000;
  std::map<int32_t, double> w;
  auto add = [&](std::span<const HeldPlace> end, double sign, Vec3& rest) {
    for_each_weight(end, [&](int32_t node, double v) {
      rest += v * model.X_mm[size_t(node)];
      if (const HangingNode* h = hanging_at(model, node)) {
        for (size_t k = 0; k < size_t(h->count); ++k)
          if (!model.fixed[size_t(h->master[k])].all()) w[h->master[k]] += sign * v * double(h->weight[k]);
      } else if (!model.fixed[size_t(node)].all()) {
        w[node] += sign * v;
      }
    });
  };
  add(s.held_a(), 1, r.rest_a_mm);
  if (!s.to_world) add(s.held_b(), -1, r.rest_b_mm);
  for (auto [node, v] : w) r.node.push_back(node), r.w.push_back(v);
  return r;
}

bool same_spring(const SpringRow& a, const SpringRow& b) {
  constexpr double place_mm = 1e-3;
  return a.id == b.id && a.k_mN_per_mm == b.k_mN_per_mm && (a.rest_a_mm - b.rest_a_mm).norm() < place_mm &&
         (a.rest_b_mm - b.rest_b_mm).norm() < place_mm;
}

ScalarMatrix assemble_scalar(const FemModel& m, std::span<const SpringRow> springs, double mass_per_s2,
                             bool augmented) {
  const size_t n = m.X_mm.size();
  std::vector<Mat8> cell_matrix(m.stencils.size());
  for (size_t s = 0; s < m.stencils.size(); ++s) cell_matrix[s] = scalar_cell_matrix(m, m.stencils[s], augmented);

  // Cells around each node; those with hanging corners apart, with the unknowns that move them.
  const std::vector<int32_t> hangs = hanging_index(m);
  std::vector<WideCell> wide;
  std::vector<std::vector<std::pair<int32_t, int32_t>>> node_wide(hangs.size());  // (wide cell, place in it)
  auto is_wide = [&](const HexCell& c) {
    return !hangs.empty() &&
           std::any_of(c.node.begin(), c.node.end(), [&](int32_t v) { return hangs[size_t(v)] >= 0; });
  };
  std::vector<int32_t> begin(n + 1, 0);
  for (const HexCell& c : m.cells) {
    if (!is_wide(c)) {
      for (int32_t v : c.node) ++begin[size_t(v) + 1];
      continue;
    }
    wide.push_back(widen(m, c, cell_matrix[size_t(c.stencil)], hangs));
    for (size_t k = 0; k < wide.back().node.size(); ++k)
      node_wide[size_t(wide.back().node[k])].push_back({int32_t(wide.size()) - 1, int32_t(k)});
  }
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<int32_t> fill(begin.begin(), begin.end() - 1), list;
  list.resize(size_t(begin[n]));
  for (size_t c = 0; c < m.cells.size(); ++c)
    for (int a = 0; a < 8 && !is_wide(m.cells[c]); ++a)
      list[size_t(fill[size_t(m.cells[c].node[size_t(a)])]++)] = int32_t(8 * c) + a;
  // A hanging mass is a spring to nothing on its masters.
  std::vector<SpringRow> masses;
  for (const HangingNode& h : m.hanging) {
    if (mass_per_s2 == 0) break;
    SpringRow r;
    r.k_mN_per_mm = mass_per_s2 * m.mass_kg[size_t(h.node)];
    for (size_t k = 0; k < size_t(h.count); ++k)
      if (!m.fixed[size_t(h.master[k])].all()) r.node.push_back(h.master[k]), r.w.push_back(double(h.weight[k]));
    masses.push_back(std::move(r));
  }
  auto row_of = [&](int32_t s) -> const SpringRow& {
    return size_t(s) < springs.size() ? springs[size_t(s)] : masses[size_t(s) - springs.size()];
  };
  std::vector<std::vector<std::pair<int32_t, int32_t>>> node_springs(n);  // (spring, place in its row)
  for (int32_t s = 0; s < int32_t(springs.size() + masses.size()); ++s)
    for (size_t i = 0; i < row_of(s).node.size(); ++i)
      node_springs[size_t(row_of(s).node[i])].push_back({s, int32_t(i)});

  ScalarMatrix A;
  A.row_of_node.assign(n, -1);
  for (size_t v = 0; v < n; ++v)
    if (!m.fixed[v].all() && (begin[v] < begin[v + 1] || (!hangs.empty() && !node_wide[v].empty())))
      A.row_of_node[v] = A.n(), A.node_of_row.push_back(int32_t(v));

  std::vector<int32_t> place(size_t(A.n()), -1);
  std::vector<std::pair<int32_t, double>> column;
  A.begin.push_back(0);
  for (int32_t j = 0; j < A.n(); ++j) {
    const size_t v = size_t(A.node_of_row[size_t(j)]);
    column.clear();
    auto add = [&](int32_t node, double value) {
      const int32_t i = A.row_of_node[size_t(node)];
      if (i < j) return;
      if (place[size_t(i)] < 0) place[size_t(i)] = int32_t(column.size()), column.push_back({i, 0});
      column[size_t(place[size_t(i)])].second += value;
    };
    add(int32_t(v), mass_per_s2 * m.mass_kg[v]);
    for (int32_t k = begin[v]; k < begin[v + 1]; ++k) {
      const HexCell& c = m.cells[size_t(list[size_t(k)] / 8)];
      const int a = list[size_t(k)] % 8;
      const Mat8& K = cell_matrix[size_t(c.stencil)];
      for (int b = 0; b < 8; ++b) add(c.node[size_t(b)], double(c.scale) * K(b, a));
    }
    if (!hangs.empty())
      for (auto [w, i] : node_wide[v])
        for (size_t b = 0; b < wide[size_t(w)].node.size(); ++b)
          add(wide[size_t(w)].node[b], wide[size_t(w)].K(Eigen::Index(b), i));
    for (auto [s, i] : node_springs[v]) {
      const SpringRow& r = row_of(s);
      for (size_t b = 0; b < r.node.size(); ++b) add(r.node[b], r.k_mN_per_mm * r.w[size_t(i)] * r.w[b]);
    }
    column[0].second *= 1 + floating_shift;
    for (auto& e : column) place[size_t(e.first)] = -1;
    std::sort(column.begin(), column.end());
    for (auto& e : column) A.row.push_back(e.first), A.value.push_back(e.second);
    A.begin.push_back(int32_t(A.row.size()));
  }
  return A;
}

std::vector<int32_t> inherited_order(const ScalarMatrix& now, std::span<const int32_t> order_before,
                                     std::span<const int32_t> ancestor) {
  int32_t nodes_before = 0;
  for (int32_t v : order_before) nodes_before = std::max(nodes_before, v + 1);
  for (int32_t v : ancestor) nodes_before = std::max(nodes_before, v + 1);
  const int32_t last = int32_t(order_before.size());
  std::vector<int32_t> rank(size_t(nodes_before), last);
  for (size_t k = 0; k < order_before.size(); ++k) rank[size_t(order_before[k])] = int32_t(k);
  std::vector<int32_t> order(size_t(now.n()));
  std::iota(order.begin(), order.end(), 0);
  auto key = [&](int32_t row) {
    const int32_t a = ancestor[size_t(now.node_of_row[size_t(row)])];
    return a < 0 ? last : rank[size_t(a)];
  };
  std::stable_sort(order.begin(), order.end(), [&](int32_t a, int32_t b) { return key(a) < key(b); });
  return order;
}

}  // namespace limberg::fem
