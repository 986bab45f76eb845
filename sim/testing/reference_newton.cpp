#include "sim/testing/reference_newton.h"

#include <cholmod.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <numeric>

#include "sim/fem/forces/contact_law.h"
#include "sim/fem/model/hanging_nodes.h"
#include "sim/fem/preconditioner/cholesky.h"
#include "sim/testing/direct_factor.h"
#include "sim/testing/reference_cells.h"

namespace limberg {
namespace {

using CellHessian = Eigen::Matrix<double, 24, 24>;

}  // namespace

struct ReferenceElasticity::Impl {
  /// A contact as one row: s = w . x along the normal - gap; and y = w . x - stick across it.
  struct ContactRow {
    Vec3 normal = Vec3::UnitZ(), stick = Vec3::Zero();
    double k = 0, gap = 0, soft = 0, hold = 0, grip = 0;
    std::vector<std::pair<int32_t, double>> share;  // node, signed weight; each node once

    ContactRow(const Contact& c)
        : normal(c.normal.cast<double>()),
          stick(c.stick_mm.cast<double>()),
          k(double(c.k_N_per_mm) * 1000),
          gap(double(c.gap_mm)),
          soft(double(c.soft_mm)),
          hold(double(c.hold_mN)),
          grip(double(c.grip_N_per_mm) * 1000) {
      for (const EmbeddedPoint* p : {&c.a, &c.b}) {
        const double sum = std::accumulate(p->w.begin(), p->w.end(), 0.0), sign = p == &c.a ? 1 : -1;
        for (size_t i = 0; i < 8; ++i) {
          if (p->w[i] == 0) continue;
          const auto same =
              std::find_if(share.begin(), share.end(), [&](const auto& s) { return s.first == p->node[i]; });
          const double w = sign * double(p->w[i]) / sum;
          same == share.end() ? void(share.push_back({p->node[i], w})) : void(same->second += w);
        }
      }
    }
    void give_to_masters(const FemModel& m, std::span<const int32_t> hangs) {
      std::map<int32_t, double> sum;
      for (const auto& [n, w] : share) {
        const int32_t at = hangs[size_t(n)];
        if (at < 0) sum[n] += w;
        for (size_t j = 0; at >= 0 && j < size_t(m.hanging[size_t(at)].count); ++j)
          sum[m.hanging[size_t(at)].master[j]] += w * double(m.hanging[size_t(at)].weight[j]);
      }
      share.assign(sum.begin(), sum.end());
    }
    double clearance(const FemModel& m, std::span<const Vec3> u) const {
      double s = -gap;
      for (const auto& [n, w] : share) s += w * normal.dot(m.X_mm[size_t(n)] + u[size_t(n)]);
      return s;
    }
    Vec3 slid(const FemModel& m, std::span<const Vec3> u) const {
      Vec3 y = -stick;
      for (const auto& [n, w] : share) y += w * (m.X_mm[size_t(n)] + u[size_t(n)]);
      return y - normal.dot(y) * normal;
    }
    /// Of its energy by y, with what lies across the normal alone.
    Mat3 stiffness(const FemModel& m, std::span<const Vec3> u) const {
      Mat3 K = fem::contact_push(clearance(m, u), k, soft).slope * normal * normal.transpose();
      if (!(hold > 0)) return K;
      const Vec3 y = slid(m, u);
      const double length = y.norm();
      const Mat3 across = Mat3::Identity() - normal * normal.transpose();
      if (length < hold / grip) return K + grip * across;
      return K + hold / length * (across - y * y.transpose() / (length * length));
    }
  };

  const FemModel& m;
  std::vector<Spring> springs;
  std::vector<ContactRow> contacts;
  std::vector<Vec3> weight;  // and loads, mN per node; empty: none
  fem::ReferenceCells cells;

  // Pattern of the 3n matrix: lower triangle, free nodes, scalar rows expanded.
  fem::ScalarMatrix graph;
  std::vector<int32_t> begin, row;
  struct
      Term {  // of a cell: `weight` times its block (a, b) goes to the block of unknowns (row, column), row >= column
    int8_t a = 0, b = 0;
    double weight = 1;
    int32_t row = 0, column = 0, entry = 0;
  };
  std::vector<std::vector<Term>> cell_terms;
  std::vector<std::vector<std::array<int32_t, 3>>> spring_entry;  // (i, j, scalar entry)
  std::vector<std::vector<std::array<int32_t, 3>>> contact_entry;
  std::vector<fem::SpringRow> spring_rows;
  mutable cholmod_common common;
  cholmod_factor* symbolic = nullptr;

  explicit Impl(const FemModel& model) : m(model), cells(model) {
    fem::keep_single_threaded();
    cholmod_start(&common);
  }
  ~Impl() {
    cholmod_free_factor(&symbolic, &common);
    cholmod_finish(&common);
  }

  void follow_masters(std::vector<Vec3>& u) const {
    for (const HangingNode& h : m.hanging) {
      Vec3 s = Vec3::Zero();
      for (size_t k = 0; k < size_t(h.count); ++k) s += double(h.weight[k]) * u[size_t(h.master[k])];
      u[size_t(h.node)] = s;
    }
  }

  void give_to_masters(std::vector<Vec3>& g) const {
    for (const HangingNode& h : m.hanging) {
      for (size_t k = 0; k < size_t(h.count); ++k) g[size_t(h.master[k])] += double(h.weight[k]) * g[size_t(h.node)];
      g[size_t(h.node)].setZero();
    }
  }

  double evaluate(std::span<const Vec3> u, std::vector<Vec3>* g, double* scale) const {
    std::vector<double> size;
    if (g) g->assign(m.X_mm.size(), Vec3::Zero());
    if (scale) size.assign(m.X_mm.size(), 0);
    double energy = 0;
    for (const HexCell& c : m.cells) {
      fem::ReferenceCells::Gradients force;
      energy += cells.energy(c, u, g ? &force : nullptr);
      if (!g) continue;
      for (int a = 0; a < 8; ++a) {
        (*g)[size_t(c.node[size_t(a)])] += force.row(a).transpose();
        if (scale) size[size_t(c.node[size_t(a)])] += force.row(a).norm();
      }
    }
    for (const Spring& s : springs) {
      const double k = s.k_N_per_mm * 1000;
      Vec3 r = -s.target_mm;
      auto visit = [&](auto&& f) {
        for (int side = 0; side < (s.to_world ? 1 : 2); ++side) {
          const std::span<const HeldPlace> end = side ? s.held_b() : s.held_a();
          double all = 0;
          for (const HeldPlace& p : end) all += p.share;
          for (const HeldPlace& p : end) {
            const double sum = std::accumulate(p.w.begin(), p.w.end(), 0.0);
            for (size_t i = 0; i < 8; ++i)
              if (p.w[i] != 0) f(size_t(p.node[i]), (side ? -1 : 1) * p.share * double(p.w[i]) / (sum * all));
          }
        }
      };
      visit([&](size_t n, double w) { r += w * (m.X_mm[n] + u[n]); });
      energy += 0.5 * k * r.squaredNorm();
      if (g)
        visit([&](size_t n, double w) {
          (*g)[n] += k * w * r;
          if (scale) size[n] += k * std::fabs(w) * r.norm();
        });
    }
    for (const ContactRow& c : contacts) {
      const fem::Push push = fem::contact_push(c.clearance(m, u), c.k, c.soft);
      energy += push.energy;
      if (g)
        for (const auto& [n, w] : c.share) {
          (*g)[size_t(n)] -= push.force * w * c.normal;
          if (scale) size[size_t(n)] += push.force * std::fabs(w);
        }
      if (!(c.hold > 0)) continue;
      const Vec3 y = c.slid(m, u);
      const fem::Push back = fem::friction_pull(y.norm(), c.grip, c.hold);
      energy += back.energy;
      if (g && y.norm() > 0)
        for (const auto& [n, w] : c.share) {
          (*g)[size_t(n)] += back.force / y.norm() * w * y;
          if (scale) size[size_t(n)] += back.force * std::fabs(w);
        }
    }
    for (size_t i = 0; i < weight.size(); ++i) {
      energy -= weight[i].dot(u[i]);
      if (g) (*g)[i] -= weight[i];
      if (scale) size[i] += weight[i].norm();
    }
    if (scale) {
      double sum = 0;
      for (size_t i = 0; i < size.size(); ++i)
        if (!m.fixed[i].all()) sum += size[i] * size[i];
      *scale = std::sqrt(sum);
    }
    return energy;
  }

  void build_pattern() {
    if (!begin.empty()) return;
    for (const Spring& s : springs) spring_rows.push_back(fem::spring_row(m, s));
    // A contact couples its nodes as a spring does: it enters the
    // pattern as one, and its values are added where it presses.
    std::vector<fem::SpringRow> coupled = spring_rows;
    for (const ContactRow& c : contacts) {
      fem::SpringRow r;
      for (const auto& [n, w] : c.share)
        if (!m.fixed[size_t(n)].all()) r.node.push_back(n), r.w.push_back(w);
      r.k_mN_per_mm = c.k;
      coupled.push_back(r);
    }
    graph = fem::assemble_scalar(m, coupled, 0, false);
    auto entry = [&](int32_t i, int32_t j) {
      const auto first = graph.row.begin() + graph.begin[size_t(j)],
                 last = graph.row.begin() + graph.begin[size_t(j) + 1];
      return int32_t(std::lower_bound(first, last, i) - graph.row.begin());
    };
    const std::vector<int32_t> hangs = fem::hanging_index(m);
    for (const HexCell& c : m.cells) {
      std::array<std::vector<std::pair<int32_t, double>>, 8> rows;  // corner -> unknowns that move it
      for (size_t a = 0; a < 8; ++a) {
        const size_t v = size_t(c.node[a]);
        if (hangs.empty() || hangs[v] < 0) {
          rows[a].push_back({graph.row_of_node[v], 1.0});
        } else {
          const HangingNode& h = m.hanging[size_t(hangs[v])];
          for (size_t k = 0; k < size_t(h.count); ++k)
            rows[a].push_back({graph.row_of_node[size_t(h.master[k])], double(h.weight[k])});
        }
      }
      std::vector<Term>& terms = cell_terms.emplace_back();
      for (int a = 0; a < 8; ++a)
        for (int b = 0; b < 8; ++b)
          for (auto [i, wi] : rows[size_t(a)])
            for (auto [j, wj] : rows[size_t(b)])
              if (i >= 0 && j >= 0 && i >= j) terms.push_back({int8_t(a), int8_t(b), wi * wj, i, j, entry(i, j)});
    }
    for (const ContactRow& c : contacts) {
      contact_entry.emplace_back();
      for (size_t a = 0; a < c.share.size(); ++a)
        for (size_t b = 0; b < c.share.size(); ++b) {
          const int32_t i = graph.row_of_node[size_t(c.share[a].first)],
                        j = graph.row_of_node[size_t(c.share[b].first)];
          if (i >= j && j >= 0) contact_entry.back().push_back({int32_t(a), int32_t(b), entry(i, j)});
        }
    }
    for (const fem::SpringRow& r : spring_rows) {
      spring_entry.emplace_back();
      for (size_t a = 0; a < r.node.size(); ++a)
        for (size_t b = 0; b < r.node.size(); ++b) {
          const int32_t i = graph.row_of_node[size_t(r.node[a])], j = graph.row_of_node[size_t(r.node[b])];
          if (i >= j) spring_entry.back().push_back({int32_t(a), int32_t(b), entry(i, j)});
        }
    }
    // Scalar column j becomes columns 3j..3j+2; the diagonal block keeps its lower triangle.
    begin.assign(1, 0);
    for (int32_t j = 0; j < graph.n(); ++j)
      for (int d = 0; d < 3; ++d) {
        for (int32_t e = graph.begin[size_t(j)]; e < graph.begin[size_t(j) + 1]; ++e)
          for (int k = e == graph.begin[size_t(j)] ? d : 0; k < 3; ++k) row.push_back(3 * graph.row[size_t(e)] + k);
        begin.push_back(int32_t(row.size()));
      }
  }

  cholmod_sparse matrix(double* value) const {
    cholmod_sparse S{};
    S.nrow = S.ncol = size_t(3 * graph.n());
    S.nzmax = row.size();
    S.p = const_cast<int32_t*>(begin.data()), S.i = const_cast<int32_t*>(row.data()), S.x = value;
    S.stype = -1, S.itype = CHOLMOD_INT, S.xtype = value ? CHOLMOD_REAL : CHOLMOD_PATTERN, S.dtype = CHOLMOD_DOUBLE;
    S.sorted = 1, S.packed = 1;
    return S;
  }

  void analyze() {
    if (symbolic) return;
    build_pattern();
    InlineWorkers workers;
    const fem::ScalarFactor scalar = fem::factorize(graph, workers);
    std::vector<int32_t> order;
    for (int32_t n : scalar.node_order)
      for (int k = 0; k < 3; ++k) order.push_back(3 * graph.row_of_node[size_t(n)] + k);
    common.supernodal = CHOLMOD_SUPERNODAL, common.nmethods = 1, common.method[0].ordering = CHOLMOD_GIVEN;
    common.postorder = 1, common.final_ll = 1, common.print = 0;
    cholmod_sparse S = matrix(nullptr);
    symbolic = cholmod_analyze_p(&S, order.data(), nullptr, 0, &common);
  }

  // Position of entry (3i+r, 3j+d) given the scalar entry e of column j.
  size_t place(int32_t j, int32_t e, int r, int d) const {
    const int32_t k = e - graph.begin[size_t(j)];
    const int32_t column = begin[size_t(3 * j + d)];
    return size_t(k == 0 ? column + r - d : column + (3 - d) + 3 * (k - 1) + r);
  }

  /// A component that is held alone becomes an equation of its own: rows and columns zero, one on the diagonal.
  void hold_axes(std::vector<double>& value) const {
    const auto held = [&](int32_t unknown) {
      return m.fixed[size_t(graph.node_of_row[size_t(unknown / 3)])].along(unknown % 3);
    };
    for (int32_t column = 0; column < 3 * graph.n(); ++column)
      for (int32_t e = begin[size_t(column)]; e < begin[size_t(column) + 1]; ++e)
        if (held(column) || held(row[size_t(e)])) value[size_t(e)] = row[size_t(e)] == column ? 1 : 0;
  }
  void drop_held(std::vector<Vec3>& g) const {
    for (size_t i = 0; i < g.size(); ++i)
      for (int k = 0; k < 3; ++k)
        if (m.fixed[i].along(k)) g[i][k] = 0;
  }

  /// Newton direction from the Hessian at u; false if it is not positive definite.
  bool direction(std::span<const Vec3> u, std::span<const Vec3> g, bool project, std::vector<Vec3>& d) const {
    std::vector<double> value(row.size(), 0);
    for (size_t c = 0; c < m.cells.size(); ++c) {
      const CellHessian H = cells.hessian(m.cells[c], u, project);
      for (const Term& t : cell_terms[c])
        for (int k = 0; k < 3; ++k)
          for (int r = t.row == t.column ? k : 0; r < 3; ++r)
            value[place(t.column, t.entry, r, k)] += t.weight * H(3 * t.a + r, 3 * t.b + k);
    }
    for (size_t s = 0; s < spring_rows.size(); ++s)
      for (auto [a, b, e] : spring_entry[s]) {
        const fem::SpringRow& r = spring_rows[s];
        const int32_t j = graph.row_of_node[size_t(r.node[size_t(b)])];
        for (int k = 0; k < 3; ++k) value[place(j, e, k, k)] += r.k_mN_per_mm * r.w[size_t(a)] * r.w[size_t(b)];
      }
    for (size_t c = 0; c < contacts.size(); ++c) {
      const auto& pressed = contacts[c];
      const Mat3 K = pressed.stiffness(m, u);
      if (K.isZero(0)) continue;
      for (auto [a, b, e] : contact_entry[c]) {
        const int32_t j = graph.row_of_node[size_t(pressed.share[size_t(b)].first)];
        const double w = pressed.share[size_t(a)].second * pressed.share[size_t(b)].second;
        for (int k = 0; k < 3; ++k)
          for (int r = a == b ? k : 0; r < 3; ++r) value[place(j, e, r, k)] += w * K(r, k);
      }
    }
    hold_axes(value);
    cholmod_sparse S = matrix(value.data());
    cholmod_factor* L = cholmod_copy_factor(symbolic, &common);
    common.status = CHOLMOD_OK;
    cholmod_factorize(&S, L, &common);
    const bool ok = common.status == CHOLMOD_OK && L->minor == L->n;
    if (ok) {
      cholmod_dense* b = cholmod_zeros(S.nrow, 1, CHOLMOD_REAL, &common);
      double* pb = static_cast<double*>(b->x);
      for (int32_t i = 0; i < graph.n(); ++i)
        for (int k = 0; k < 3; ++k) pb[3 * i + k] = -g[size_t(graph.node_of_row[size_t(i)])][k];
      cholmod_dense* x = cholmod_solve(CHOLMOD_A, L, b, &common);
      const double* px = static_cast<const double*>(x->x);
      d.assign(u.size(), Vec3::Zero());
      for (int32_t i = 0; i < graph.n(); ++i)
        d[size_t(graph.node_of_row[size_t(i)])] = Vec3(px[3 * i], px[3 * i + 1], px[3 * i + 2]);
      cholmod_free_dense(&b, &common);
      cholmod_free_dense(&x, &common);
    }
    cholmod_free_factor(&L, &common);
    return ok;
  }
};

ReferenceElasticity::ReferenceElasticity(const FemModel& model, std::span<const Spring> springs,
                                         std::span<const Contact> contacts, const Vec3& gravity_m_s2,
                                         std::span<const DeadLoad> loads)
    : impl_(std::make_unique<Impl>(model)) {
  Impl& p = *impl_;
  p.springs.assign(springs.begin(), springs.end());
  p.contacts.assign(contacts.begin(), contacts.end());
  if (!gravity_m_s2.isZero(0) || !loads.empty()) {
    for (size_t i = 0; i < model.X_mm.size(); ++i) p.weight.push_back(1000 * model.mass_kg[i] * gravity_m_s2);
    for (const DeadLoad& l : loads)
      for (const EmbeddedPoint& at : l.at) {
        const double sum = std::accumulate(at.w.begin(), at.w.end(), 0.0) * double(l.at.size());
        for (size_t i = 0; i < 8; ++i) p.weight[size_t(at.node[i])] += double(at.w[i]) / sum * l.force_mN;
      }
  }
  if (const std::vector<int32_t> hangs = fem::hanging_index(model); !hangs.empty())
    for (auto& c : p.contacts) c.give_to_masters(model, hangs);
}
ReferenceElasticity::~ReferenceElasticity() = default;

void ReferenceElasticity::prepare() const { impl_->analyze(); }

double ReferenceElasticity::energy(std::span<const Vec3> u) const { return impl_->evaluate(u, nullptr, nullptr); }
double ReferenceElasticity::gradient(std::span<const Vec3> u, std::vector<Vec3>& g) const {
  return impl_->evaluate(u, &g, nullptr);
}

Eigen::MatrixXd ReferenceElasticity::dense_hessian(std::span<const Vec3> u, bool project) const {
  const Impl& p = *impl_;
  const Eigen::Index n = Eigen::Index(3 * p.m.X_mm.size());
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(n, n);
  for (const HexCell& c : p.m.cells) {
    const CellHessian h = p.cells.hessian(c, u, project);
    for (int a = 0; a < 8; ++a)
      for (int b = 0; b < 8; ++b)
        H.block<3, 3>(3 * c.node[size_t(a)], 3 * c.node[size_t(b)]) += h.block<3, 3>(3 * a, 3 * b);
  }
  for (const Spring& s : p.springs) {
    const fem::SpringRow r = fem::spring_row(p.m, s);
    for (size_t a = 0; a < r.node.size(); ++a)
      for (size_t b = 0; b < r.node.size(); ++b)
        H.block<3, 3>(3 * r.node[a], 3 * r.node[b]) += r.k_mN_per_mm * r.w[a] * r.w[b] * Mat3::Identity();
  }
  for (const auto& c : p.contacts) {
    const Mat3 K = c.stiffness(p.m, u);
    for (const auto& [i, wi] : c.share)
      for (const auto& [j, wj] : c.share) H.block<3, 3>(3 * i, 3 * j) += wi * wj * K;
  }
  return H;
}

ReferenceElasticity::Result ReferenceElasticity::solve(std::span<const Vec3> start, const Settings& settings) const {
  Impl& p = *impl_;
  p.analyze();
  Result r;
  r.u.assign(start.begin(), start.end());
  p.follow_masters(r.u);
  std::vector<Vec3> g, d, trial(r.u.size());
  double scale = 0;
  for (;;) {
    r.energy_uJ = p.evaluate(r.u, &g, &scale);
    p.give_to_masters(g);
    p.drop_held(g);
    double norm = 0;
    for (const Vec3& f : g) norm += f.squaredNorm();
    norm = std::sqrt(norm);
    r.residual = scale > 0 ? norm / scale : 0;
    r.converged = r.residual <= settings.tolerance;
    if (r.converged || r.iterations >= settings.max_iterations) return r;
    bool ok = settings.adaptive && p.direction(r.u, g, false, d);
    if (!ok) {
      r.failed_factors += settings.adaptive;
      ok = p.direction(r.u, g, true, d);
    }
    if (!ok) return r;
    p.follow_masters(d);
    double slope = 0;
    for (size_t i = 0; i < g.size(); ++i) slope += g[i].dot(d[i]);
    double alpha = 1;
    bool moved = false;
    for (int h = 0; h < 40 && !moved; ++h, alpha *= moved ? 1 : 0.5) {
      for (size_t i = 0; i < d.size(); ++i) trial[i] = r.u[i] + alpha * d[i];
      const double e = p.evaluate(trial, nullptr, nullptr);
      moved = e <= r.energy_uJ + 1e-4 * alpha * slope + 1e-14 * std::fabs(r.energy_uJ);
    }
    if (!moved) return r;
    r.u.swap(trial);
    ++r.iterations;
    if (settings.on_iterate && settings.on_iterate(r.u)) return r;
  }
}

}  // namespace limberg
