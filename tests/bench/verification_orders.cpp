// Orders of convergence, and what elements do to thin and nearly incompressible tissue.
#include <fmt/format.h>

#include <cmath>

#include "app/operating_point/cpu_clock.h"
#include "sim/fem/elements/material_points.h"
#include "sim/fem/materials/stable_neo_hookean.h"
#include "sim/fem/model/box_model.h"
#include "sim/testing/tet_lattice.h"
#include "tests/bench/verification_parts.h"

namespace limberg::bench {
namespace {

/// u = eps s(X) c with s = sin sin sin on the unit cube, and the body force b = -Div P of the scenes' energy. F = I + c
/// grad s^T has rank one beside I: J = 1 + c.grad s, cof F = J I - grad s c^T.
struct MadeUp {
  Vec3 c = 0.05 * Vec3(1, 2, -1);
  double mu = 1, lambda = 1;

  double s(const Vec3& X) const { return std::sin(M_PI * X[0]) * std::sin(M_PI * X[1]) * std::sin(M_PI * X[2]); }
  Vec3 grad(const Vec3& X) const {
    Vec3 g;
    for (int i = 0; i < 3; ++i)
      g[i] = M_PI * std::cos(M_PI * X[i]) * std::sin(M_PI * X[(i + 1) % 3]) * std::sin(M_PI * X[(i + 2) % 3]);
    return g;
  }
  Mat3 hessian(const Vec3& X) const {
    Mat3 H;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        if (i == j) {
          H(i, j) = -M_PI * M_PI * s(X);
        } else {
          const int k = 3 - i - j;
          H(i, j) = M_PI * M_PI * std::cos(M_PI * X[i]) * std::cos(M_PI * X[j]) * std::sin(M_PI * X[k]);
        }
      }
    return H;
  }
  Vec3 u(const Vec3& X) const { return s(X) * c; }
  Mat3 grad_u(const Vec3& X) const { return c * grad(X).transpose(); }
  Vec3 body_force(const Vec3& X) const {
    const Vec3 g = grad(X);
    const Mat3 cof = (1 + c.dot(g)) * Mat3::Identity() - g * c.transpose();  // Div cof F = 0
    const Mat3 H = hessian(X);
    return -(mu * H.trace() * c + lambda * cof * (H * c));
  }
};

struct Order {
  double L2 = 0, H1 = 0;
  bool converged = false;
  size_t nodes = 0;
};

Order solve(FemModel m, const MadeUp& exact, bool tets) {
  for (Vec3& X : m.X_mm) X += Vec3(0.5, 0.5, 0);  // box_model's cube is centred in x and y
  std::vector<Vec3> load(m.X_mm.size(), Vec3::Zero());
  const double gauss[3] = {0.5 - std::sqrt(0.15), 0.5, 0.5 + std::sqrt(0.15)},
               weight[3] = {5.0 / 18, 8.0 / 18, 5.0 / 18};
  const double a = (5 - std::sqrt(5)) / 20, b = (5 + 3 * std::sqrt(5)) / 20;  // 4 points in a tetrahedron
  // Calls f(cell, place, shape functions, gradients, volume) at quadrature points.
  const auto integrate = [&](const auto& f) {
    for (const HexCell& c : m.cells) {
      const Stencil& s = m.stencils[size_t(c.stencil)];
      std::array<double, 8> N{};
      for (int q = 0; q < (tets ? 4 : 27); ++q) {
        Vec3 X = Vec3::Zero();
        if (tets) {
          for (int i = 0; i < 4; ++i) N[size_t(i)] = i == q ? b : a;
          for (size_t i = 0; i < 4; ++i) X += N[i] * m.X_mm[size_t(c.node[i])];
          f(c, X, N, *s.points[0].gradients, s.volume_mm3 / 4);
        } else {
          const Vec3 at(gauss[q % 3], gauss[q / 3 % 3], gauss[q / 9]);
          for (int i = 0; i < 8; ++i) {
            N[size_t(i)] = 1;
            for (int d = 0; d < 3; ++d) N[size_t(i)] *= (i >> d & 1) ? at[d] : 1 - at[d];
            X += N[size_t(i)] * m.X_mm[size_t(c.node[size_t(i)])];
          }
          f(c, X, N, trilinear_gradients(s, at, m.cell_mm),
            s.volume_mm3 * weight[q % 3] * weight[q / 3 % 3] * weight[q / 9]);
        }
      }
    }
  };
  integrate([&](const HexCell& c, const Vec3& X, const std::array<double, 8>& N, const auto&, double v) {
    const Vec3 force = exact.body_force(X);
    for (size_t i = 0; i < 8; ++i) load[size_t(c.node[i])] += v * N[i] * force;
  });
  std::vector<Spring> springs;
  std::vector<Vec3> start(m.X_mm.size(), Vec3::Zero());
  const double k = 1e-6 * exact.mu * m.cell_mm[0];
  for (size_t i = 0; i < m.X_mm.size(); ++i) {
    const Vec3& X = m.X_mm[i];
    m.fixed[i] = (X.array() < 1e-9).any() || (X.array() > 1 - 1e-9).any();
    if (!m.fixed[i])
      springs.push_back(dead_load(m, int32_t(i), int32_t(i), load[i], k, exact.u(X))), start[i] = exact.u(X);
  }
  const ReferenceElasticity energy(m, springs);
  ReferenceElasticity::Settings set;
  set.max_iterations = 30, set.tolerance = 1e-9;
  const auto r = energy.solve(start, set);
  Order o;
  o.converged = r.residual < 1e-7, o.nodes = m.X_mm.size();
  integrate([&](const HexCell& c, const Vec3& X, const std::array<double, 8>& N, const auto& G, double v) {
    Vec3 u = Vec3::Zero();
    Mat3 grad = Mat3::Zero();
    for (size_t i = 0; i < 8; ++i)
      u += N[i] * r.u[size_t(c.node[i])], grad += r.u[size_t(c.node[i])] * G.row(Eigen::Index(i));
    o.L2 += v * (u - exact.u(X)).squaredNorm(), o.H1 += v * (grad - exact.grad_u(X)).squaredNorm();
  });
  o.L2 = std::sqrt(o.L2 * 8) / exact.c.norm();  // relative to |c| |s|, |s|^2 = 1/8
  o.H1 = std::sqrt(o.H1 * 8 / 3) / (M_PI * exact.c.norm());
  return o;
}

}  // namespace

void manufactured(Result& out, const VerificationSettings& set) {
  for (const bool tets : {false, true}) {
    const char* method = tets ? "linear tetrahedra, body-centred" : "hexahedra, selective reduced";
    std::vector<Order> orders;
    for (int n : set.quick ? std::vector<int>{3, 6} : tets ? std::vector<int>{3, 6, 12} : std::vector<int>{4, 8, 16}) {
      const double before = cpu_ms();
      BoxSpec b;
      b.cells = {n, n, n}, b.size_mm = {1, 1, 1}, b.poisson = 0.3, b.young_bottom_kPa = b.young_top_kPa = 2.6;
      const Elastic e = elastic_from_young(2.6, 0.3);
      MadeUp exact;
      exact.mu = e.mu_kPa, exact.lambda = e.lambda_kPa;
      orders.push_back(solve(tets ? bcc_box_model(b) : box_model(b), exact, tets));
      const Order& o = orders.back();
      const std::string how = std::to_string(n) + " cells a side, " + std::to_string(o.nodes) + " nodes, ";
      out.rows.push_back({"manufactured solution", method, how + "L2 norm", cpu_ms() - before, false, 100 * o.L2, "%",
                          "exact", o.converged});
      out.rows.push_back(
          {"manufactured solution", method, how + "H1 seminorm", 0, false, 100 * o.H1, "%", "exact", o.converged});
    }
    if (set.quick) continue;
    const Order &c = orders[orders.size() - 2], &f = orders.back();
    if (!tets)
      at_most(out, std::string("manufactured solution, ") + method + ": L2 error, finest (%)", 100 * f.L2, 1,
              "issue 4: within 1 %");
    at_least(out, std::string("manufactured solution, ") + method + ": L2 order", observed_order(c.L2, f.L2, 2), 1.75,
             "theory: 2");
    at_least(out, std::string("manufactured solution, ") + method + ": H1 order", observed_order(c.H1, f.H1, 2), 0.75,
             "theory: 1");
  }
}

// A strip of 120 x 10 x 10 mm, one end held, the other moved up by 20 mm
// without turning. Strain energy against the scenes' element with 8 layers;
// the prototype's figures (for a strip of its own) stand in the notes.
void bent_strip(Result& out, const VerificationSettings& set) {
  enum Kind { selective, full, tet };
  const auto energy_of = [](Kind kind, int layers, double poisson, size_t& nodes, bool& converged) {
    BoxSpec b;
    b.cells = {12 * layers, layers, layers}, b.size_mm = {120, 10, 10}, b.poisson = poisson;
    FemModel m = kind == tet ? bcc_box_model(b) : box_model(b);
    if (kind == full) {
      const Elastic e = elastic_from_young(60, poisson);
      m.laws = {stable_neo_hookean_full(e.mu_kPa, e.lambda_kPa, e.mu_kPa)};
      for (Stencil& s : m.stencils) s = fem::law_stencil(m.cell_mm, 0, *m.laws[0], 0);
    }
    std::vector<Vec3> start;
    for (size_t i = 0; i < m.X_mm.size(); ++i) {
      const double t = (m.X_mm[i][0] + 60) / 120;
      m.fixed[i] = t < 1e-9 || t > 1 - 1e-9;
      start.push_back(Vec3(0, 0, 20 * t * t * (3 - 2 * t)));  // clamped-clamped beam
    }
    const ReferenceElasticity e(m, {});
    ReferenceElasticity::Settings s;
    s.max_iterations = 40, s.tolerance = 1e-8;
    const auto r = e.solve(start, s);
    nodes = m.X_mm.size(), converged = r.residual < 1e-5;
    return r.energy_uJ;
  };
  const char* names[] = {"hexahedra, selective reduced", "hexahedra, full integration",
                         "linear tetrahedra, body-centred"};
  for (double nu : set.quick ? std::vector<double>{0.49} : std::vector<double>{0.30, 0.45, 0.49}) {
    const std::string label = fmt::format("strip bent 20 mm, nu {:.2f}", nu);
    size_t nodes = 0;
    bool ok = false;
    const double truth = energy_of(selective, set.quick ? 4 : 8, nu, nodes, ok);
    for (Kind kind : {selective, full, tet})
      for (int layers : {2, 3, 5}) {
        if (set.quick && layers > 2) continue;
        const double before = cpu_ms();
        const double error = energy_of(kind, layers, nu, nodes, ok) / truth - 1;
        out.rows.push_back({label, names[kind],
                            std::to_string(layers) + " cells thick, " + std::to_string(nodes) + " nodes",
                            cpu_ms() - before, false, 100 * error, "%",
                            set.quick ? "selective reduced, 4 layers" : "selective reduced, 8 layers", ok});
        if (layers == 2 && kind == selective && nu > 0.48)
          at_most(out, "strip, 2 cells thick, nu .49: energy error of the scenes' element (%)", 100 * std::fabs(error),
                  3, "issue 4; the prototype's strip: -2.7 %, linear tetrahedra +22 %, full hexahedra +103 %");
      }
  }
}

}  // namespace limberg::bench
