#include "sim/fem/model/box_model.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "sim/base/union_find.h"

namespace limberg {

Elastic elastic_from_young(double E, double nu) {
  const double mu = E / (2 * (1 + nu));
  return {mu, E * nu / ((1 + nu) * (1 - 2 * nu)) + mu};
}

Stencil box_stencil(const Vec3& h, const Elastic& e, double density, const Mat3& F0) {
  Stencil s;
  s.volume_mm3 = h.prod();
  s.mu_kPa = e.mu_kPa;
  s.lambda_kPa = e.lambda_kPa;
  const Mat3 A = F0 * F0.transpose();
  s.p0_kPa = e.mu_kPa * A(2, 2);
  s.density_kg_mm3 = density;
  const double g = 0.5 / std::sqrt(3.0);
  for (int q = 0; q < 8; ++q) {
    Vec3 at;  // in [0, 1]
    for (int i = 0; i < 3; ++i) at[i] = 0.5 + (((q >> i) & 1) ? g : -g);
    Eigen::Matrix<double, 8, 3> D;
    for (int a = 0; a < 8; ++a)
      for (int i = 0; i < 3; ++i) {
        double v = 1;
        for (int j = 0; j < 3; ++j) {
          const bool up = (a >> j) & 1;
          v *= i == j ? (up ? 1 : -1) / h[j] : (up ? at[j] : 1 - at[j]);
        }
        D(a, i) = v;
      }
    s.K += e.mu_kPa * s.volume_mm3 / 8 * (D * A * D.transpose());
  }
  return s;
}

FemModel box_model(const BoxSpec& b) {
  FemModel m;
  const Int3 n = b.cells;
  m.cell_mm = b.size_mm.cwiseQuotient(Vec3(n.x, n.y, n.z));
  m.stencils.push_back(box_stencil(m.cell_mm, elastic_from_young(b.young_bottom_kPa, b.poisson), b.density_kg_mm3));
  m.stencils.push_back(box_stencil(m.cell_mm, elastic_from_young(b.young_top_kPa, b.poisson), b.density_kg_mm3));
  const Vec3 origin(-b.size_mm[0] / 2, -b.size_mm[1] / 2, 0);
  auto in_hole = [&](double x, double y) {
    if (b.hole_length_mm <= 0) return false;
    const double t = 2 * x / b.hole_length_mm;  // two parabolic arcs
    return std::fabs(t) < 1 && std::fabs(y) < 0.5 * b.hole_width_mm * (1 - t * t);
  };
  std::vector<int32_t> node(size_t(n.x + 1) * size_t(n.y + 1) * size_t(n.z + 1), -1);
  auto at = [&](int i, int j, int k) {
    return (size_t(k) * size_t(n.y + 1) + size_t(j)) * size_t(n.x + 1) + size_t(i);
  };
  std::vector<std::array<int, 3>> kept;
  for (int k = 0; k < n.z; ++k)
    for (int j = 0; j < n.y; ++j)
      for (int i = 0; i < n.x; ++i) {
        const Vec3 c = origin + m.cell_mm.cwiseProduct(Vec3(i + 0.5, j + 0.5, k + 0.5));
        if (in_hole(c[0], c[1])) continue;
        kept.push_back({i, j, k});
        for (int a = 0; a < 8; ++a) node[at(i + (a & 1), j + (a >> 1 & 1), k + (a >> 2))] = 0;
      }
  for (int k = 0; k <= n.z; ++k)
    for (int j = 0; j <= n.y; ++j)
      for (int i = 0; i <= n.x; ++i) {
        if (node[at(i, j, k)] < 0) continue;
        node[at(i, j, k)] = int32_t(m.X_mm.size());
        m.X_mm.push_back(origin + m.cell_mm.cwiseProduct(Vec3(i, j, k)));
        const bool side = i == 0 || j == 0 || i == n.x || j == n.y;
        m.fixed.push_back((b.fix_sides && side) || (b.fix_bottom && k == 0));
      }
  m.mass_kg.assign(m.X_mm.size(), 0);
  m.parent.assign(m.X_mm.size(), -1);
  for (auto [i, j, k] : kept) {
    HexCell c;
    c.stencil = 2 * k >= n.z ? 1 : 0;
    c.at = {int16_t(2 * i), int16_t(2 * j), int16_t(2 * k)};
    for (int a = 0; a < 8; ++a) {
      c.node[size_t(a)] = node[at(i + (a & 1), j + (a >> 1 & 1), k + (a >> 2))];
      m.mass_kg[size_t(c.node[size_t(a)])] += b.density_kg_mm3 * m.cell_mm.prod() / 8;
    }
    m.cells.push_back(c);
  }
  return m;
}

FemModel part_cells(const FemModel& before, const std::function<bool(const Vec3&, const Vec3&)>& apart) {
  FemModel m = before;
  m.parent = ParentList::identity(m.X_mm.size());
  m.born.clear();
  UnionFind corners(8 * m.cells.size());  // classes of (cell, corner)
  const auto centre = [&](size_t c) {
    Vec3 x = Vec3::Zero();
    for (int32_t v : m.cells[c].node) x += m.X_mm[size_t(v)] / 8;
    return x;
  };
  std::map<std::array<int32_t, 4>, size_t> square;  // its nodes -> the first cell that has it
  for (size_t c = 0; c < m.cells.size(); ++c)
    for (int axis = 0; axis < 3; ++axis)
      for (int high = 0; high < 2; ++high) {
        std::array<int32_t, 4> nodes;
        for (int a = 0, k = 0; a < 8; ++a)
          if ((a >> axis & 1) == high) nodes[size_t(k++)] = m.cells[c].node[size_t(a)];
        const auto [at, is_new] = square.try_emplace(nodes, c);
        if (is_new || apart(centre(at->second), centre(c))) continue;
        for (int a = 0; a < 8; ++a)
          for (int b = 0; b < 8; ++b)
            if (m.cells[c].node[size_t(a)] == m.cells[at->second].node[size_t(b)] && (a >> axis & 1) == high)
              corners.unite(int32_t(8 * c) + a, int32_t(8 * at->second) + b);
      }
  std::vector<int32_t> node(corners.size(), -1);  // of a root
  std::vector<uint8_t> taken(m.X_mm.size(), 0);
  for (size_t c = 0; c < m.cells.size(); ++c)
    for (int a = 0; a < 8; ++a) {
      int32_t& n = node[size_t(corners.find(int32_t(8 * c) + a))];
      const int32_t old = before.cells[c].node[size_t(a)];
      if (n < 0 && !taken[size_t(old)]) {
        n = old, taken[size_t(old)] = 1;
      } else if (n < 0) {
        n = int32_t(m.X_mm.size());
        m.X_mm.push_back(before.X_mm[size_t(old)]), m.fixed.push_back(before.fixed[size_t(old)]),
            m.parent.push_back(old);
      }
      m.cells[c].node[size_t(a)] = n;
    }
  m.mass_kg.assign(m.X_mm.size(), 0);
  for (const HexCell& c : m.cells) {
    const Stencil& s = m.stencils[size_t(c.stencil)];
    for (int32_t v : c.node) m.mass_kg[size_t(v)] += s.density_kg_mm3 * double(c.scale) * s.volume_mm3 / 8;
  }
  return m;
}

EmbeddedPoint embed(const FemModel& m, const Vec3& X) {
  double best = 1e300;
  EmbeddedPoint p;
  for (const HexCell& c : m.cells) {
    const Vec3 t = (X - m.X_mm[size_t(c.node[0])]).cwiseQuotient(cell_size_mm(m.cell_mm, c.level));
    const Vec3 in = t.cwiseMax(0.0).cwiseMin(1.0);
    const double d = (t - in).squaredNorm();
    if (d >= best) continue;
    best = d;
    p.node = c.node;
    for (int a = 0; a < 8; ++a) {
      double w = 1;
      for (int i = 0; i < 3; ++i) w *= ((a >> i) & 1) ? in[i] : 1 - in[i];
      p.w[size_t(a)] = float(w);
    }
  }
  return p;
}

BenchScene bench_scene(int cells_per_side, int layers, double poisson) {
  BoxSpec b;
  b.cells = {cells_per_side, cells_per_side, layers};
  b.size_mm = {120, 120, 10};
  b.young_bottom_kPa = 18, b.young_top_kPa = 60;
  b.poisson = poisson;
  b.fix_sides = true;
  b.hole_length_mm = 40, b.hole_width_mm = 9;
  BenchScene s{box_model(b), {}};
  for (int i = 0; i < 20; ++i) {
    const double x = -18 + 36.0 * i / 19, t = 2 * x / b.hole_length_mm;
    const double y = 0.5 * b.hole_width_mm * (1 - t * t);
    Spring suture;
    suture.id = i + 1;
    suture.a = embed(s.model, {x, y + 0.5, 10});
    suture.b = embed(s.model, {x, -y - 0.5, 10});
    suture.k_N_per_mm = 1;
    s.springs.push_back(suture);
  }
  Spring hook;
  hook.id = 100;
  hook.a = embed(s.model, {20, 15, 10});
  hook.to_world = true;
  hook.target_mm = {20, 15, 10};
  hook.k_N_per_mm = 0.5;
  s.springs.push_back(hook);
  return s;
}

}  // namespace limberg
