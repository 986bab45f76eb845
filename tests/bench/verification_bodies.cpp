// Bodies with published or closed-form answers: Cook's panel, the thick sphere, the elastica.
#include <fmt/format.h>

#include <cmath>
#include <map>

#include "app/operating_point/cpu_clock.h"
#include "sim/fem/elements/shaped_cells.h"
#include "sim/fem/materials/isotropic.h"
#include "sim/fem/materials/stable_neo_hookean.h"
#include "sim/fem/model/box_model.h"
#include "tests/bench/verification_parts.h"

namespace limberg::bench {
namespace {

std::string cells(int a) { return std::to_string(a) + " cells"; }

struct Panel {
  FemModel model;
  std::vector<Spring> load;
  size_t middle = 0, top = 0;  // nodes at (48, 52) and (48, 60)
};

Panel make_panel(int n, const LawPtr& shape, const LawPtr& volume, double force_mN) {
  ShapedModel s;
  const int32_t law = s.add_law(shape), vol = volume ? s.add_law(volume) : -1;
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) {
      const double x = 48.0 * i / n, low = 44 * x / 48, high = 44 + 16 * x / 48;
      s.add_node({x, low + (high - low) * j / n, 0}, i == 0);
    }
  const auto at = [n](int i, int j) { return int32_t(j * (n + 1) + i); };
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) s.add_quad({at(i, j), at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)}, 1, law, vol);
  Panel p;
  p.model = s.finish();
  for (int j = 0; j <= n; ++j)
    p.load.push_back(
        dead_load(p.model, j + 1, at(n, j), {0, force_mN / n * (j == 0 || j == n ? 0.5 : 1), 0}, 1e-4, {-10, 14, 0}));
  p.middle = size_t(at(n, n / 2)), p.top = size_t(at(n, n));
  return p;
}

}  // namespace

// 48 x 44/16 mm, plane strain, left side held, dead shear on the right (Cook;
// finite strain as in Miehe 1994, Pelteret and McBride 2016). The answer depends
// on the energy: each is compared with its own converged value, from quadratic
// elements of two independent codes (deal.II code gallery, CalculiX 2.20) or one.
void cook(Result& out, const VerificationSettings& set) {
  const double mu = 422.5, nu = 0.3, lame = 2 * mu * nu / (1 - 2 * nu), bulk = lame + 2 * mu / 3,
               stiff = 2 * mu * 0.4999 / (1 - 2 * 0.4999);
  struct Case {
    const char *name, *method;
    LawPtr shape, volume;
    double expected_mm;
    const char* source;
  };
  const std::vector<Case> cases = {
      {"Cook, isochoric neo-Hookean, nu .3", "quad, full integration", neo_hookean_isochoric_full(mu, bulk), nullptr,
       14.728, "quadratic elements, CalculiX and a code of its own: 14.728 mm"},
      {"Cook, neo-Hookean with ln J, nu .3", "quad, full integration", neo_hookean_log_full(mu, lame), nullptr, 14.514,
       "quadratic elements: 14.514 mm"},
      {"Cook, scenes' energy, nu .3", "quad, selective reduced", neo_hookean(mu),
       stable_neo_hookean_full(0, lame + mu, mu), 14.509, "quadratic elements: 14.509 mm"},
      {"Cook, Saint Venant-Kirchhoff, nu .3", "quad, full integration", st_venant_kirchhoff_full(mu, lame), nullptr,
       13.66, "quadratic elements: 13.66 mm"},
      {"Cook, scenes' energy, nu .4999", "quad, selective reduced", neo_hookean(mu),
       stable_neo_hookean_full(0, stiff + mu, mu), 11.992, "mixed quadratic elements: 11.992 mm"}};
  for (const Case& c : cases) {
    double error[3] = {}, before = cpu_ms();
    int last = 0;
    for (int k = 0; k < (set.quick ? 2 : 3); ++k) {
      const int n = 8 << (set.quick ? k : k + 1);
      const Panel p = make_panel(n, c.shape, c.volume, 1000);
      const ReferenceElasticity energy(p.model, p.load);
      ReferenceElasticity::Settings s;
      s.max_iterations = 200, s.tolerance = 1e-9;
      const auto r = energy.solve(std::vector<Vec3>(p.model.X_mm.size(), Vec3::Zero()), s);
      error[k] = r.u[p.middle][1] / c.expected_mm - 1;
      const std::string how =
          fmt::format("{} x {} cells, {} iterations, tip {:.4f} mm", n, n, r.iterations, r.u[p.middle][1]);
      out.rows.push_back(
          {c.name, c.method, how, cpu_ms() - before, false, 100 * error[k], "%", c.source, r.residual < 1e-7});
      before = cpu_ms(), last = k;
    }
    if (!set.quick) {
      at_most(out, std::string(c.name) + ": tip at 64 x 64 (%)", 100 * std::fabs(error[last]), 1, c.source);
      out.rows.push_back({c.name, c.method, "observed order", 0, false, observed_order(error[last - 1], error[last], 2),
                          "", "corner singularity: between 1 and 2", true});
    }
  }
}

// A thick shell of inner radius A and outer radius 2 A, its inner wall moved out to 1.5 A; incompressible closed form
// P/mu = 2 (1/lb - 1/la) + (lb^-4 - la^-4)/2 with lb^3 = 1 + (la^3 - 1)(A/B)^3. lambda = 2000 mu here.
void thick_sphere(Result& out, const VerificationSettings& set) {
  const double A = 10, B = 20, mu = 20, lambda = 2000 * mu, la = 1.5;
  const double lb = std::cbrt(1 + (la * la * la - 1) / 8),
               expected = 2 * (1 / lb - 1 / la) + 0.5 * (std::pow(lb, -4) - std::pow(la, -4));
  std::vector<double> error, outer;
  const std::vector<int> sizes = set.quick ? std::vector<int>{2, 4} : std::vector<int>{3, 6, 12};
  for (int n : sizes) {
    const double before = cpu_ms();
    ShapedModel s;
    const int32_t shape = s.add_law(neo_hookean(mu)), volume = s.add_law(stable_neo_hookean_full(0, lambda, mu));
    std::map<std::array<int, 4>, int32_t> number;
    std::vector<uint8_t> inner;
    const auto node = [&](std::array<int, 3> c, int layer) {
      const auto [it, fresh] = number.try_emplace({c[0], c[1], c[2], layer}, 0);
      if (!fresh) return it->second;
      Vec3 d;
      for (int i = 0; i < 3; ++i) d[i] = std::tan(M_PI / 4 * (2.0 * c[size_t(i)] / n - 1));  // even angles
      return it->second = s.add_node(d.normalized() * (A + (B - A) * layer / n), layer == 0);
    };
    for (int axis = 0; axis < 3; ++axis)
      for (int high = 0; high < 2; ++high)
        for (int j = 0; j < n; ++j)
          for (int i = 0; i < n; ++i)
            for (int k = 0; k < n; ++k) {
              std::array<int32_t, 8> c;
              for (int a = 0; a < 8; ++a) {
                std::array<int, 3> p;
                p[size_t(axis)] = high ? n : 0;
                // Right-handed with the radius as the third axis.
                p[size_t((axis + 1) % 3)] = i + ((high ? a : a >> 1) & 1),
                                      p[size_t((axis + 2) % 3)] = j + ((high ? a >> 1 : a) & 1);
                c[size_t(a)] = node(p, k + (a >> 2));
              }
              s.add_hex(c, shape, volume);
            }
    const FemModel m = s.finish();
    std::vector<Vec3> start;
    for (const Vec3& X : m.X_mm) {
      const double r = X.norm();
      start.push_back(X * (std::cbrt(r * r * r + (la * la * la - 1) * A * A * A) / r - 1));
    }
    const ReferenceElasticity energy(m, {});
    ReferenceElasticity::Settings settings;
    settings.max_iterations = 40, settings.tolerance = 1e-10;
    const auto r = energy.solve(start, settings);
    std::vector<Vec3> g;
    energy.gradient(r.u, g);
    double push = 0, out_mean = 0;
    int outs = 0;
    for (size_t i = 0; i < g.size(); ++i) {
      if (m.fixed[i]) push += g[i].dot(m.X_mm[i].normalized());
      if (m.X_mm[i].norm() > B - 1e-9) out_mean += (m.X_mm[i] + r.u[i]).norm() / B, ++outs;
    }
    error.push_back(push / (4 * M_PI * la * la * A * A) / mu / expected - 1);
    outer.push_back(out_mean / outs / lb - 1);
    const std::string how =
        fmt::format("{} layers, {} cells, outer wall off by {:.3f} %", n, m.cells.size(), 100 * outer.back());
    out.rows.push_back({"thick sphere B/A = 2", "hexahedra, selective reduced, mapped", how, cpu_ms() - before, false,
                        100 * error.back(), "%", "closed form, P = 0.755433 mu at 1.5", r.converged});
  }
  if (set.quick) return;
  const double order = observed_order(error[1], error[2], 2);
  at_most(out, "thick sphere: pressure at 12 layers (%)", 100 * std::fabs(error.back()), 1,
          "closed form; lambda/mu = 2000 leaves about 0.04 %");
  at_least(out, "thick sphere: observed order", order, 1.75, "theory: 2");
}

// A slender bar, L/h = 50, nu = 0, clamped at one end, dead load across the
// other (Mattiasson 1981, elliptic integrals). Cubic cells bend exactly at nu
// = 0: of u_x = x z the full part of the energy, mu/2 |grad u|^2, holds mu/2
// (z^2 + x^2), just what E z^2 / 2 should be. Their error is what the bar's
// thickness makes of a line. Cells twice as long as high show the order.
void elastica(Result& out, const VerificationSettings& set) {
  struct Tip {
    double alpha, w, u;
  };
  const std::vector<Tip> table = {
      {0.25, .082746, .004118}, {0.5, .162144, .015919}, {1, .301721, .056433}, {2, .493457, .160642}};
  const double L = 100, h = 2, E = 1000, EI = E * h * h * h * h / 12;
  std::vector<double> error;
  struct Mesh {
    int layers, aspect;
  };
  for (const auto [layers, aspect] :
       set.quick ? std::vector<Mesh>{{2, 2}, {4, 2}} : std::vector<Mesh>{{2, 1}, {4, 1}, {2, 2}, {4, 2}, {8, 2}}) {
    const double before = cpu_ms();
    BoxSpec b;
    b.cells = {int(L / h) * layers / aspect, 1, layers}, b.size_mm = {L, h, h};
    b.young_bottom_kPa = b.young_top_kPa = E, b.poisson = 0;
    FemModel m = box_model(b);
    std::vector<size_t> tip;
    for (size_t i = 0; i < m.X_mm.size(); ++i) {
      m.fixed[i] = m.X_mm[i][0] < -L / 2 + 1e-9;
      if (m.X_mm[i][0] > L / 2 - 1e-9) tip.push_back(i);
    }
    std::vector<Vec3> u(m.X_mm.size(), Vec3::Zero());
    double worst = 0;
    int iterations = 0;
    bool converged = true;
    for (const Tip& t : table) {
      const double P = t.alpha * EI / (L * L);
      std::vector<Spring> load;
      for (size_t i = 0; i < tip.size(); ++i) {
        const double z = m.X_mm[tip[i]][2], share = (z < 1e-9 || z > h - 1e-9 ? 0.5 : 1) / (2.0 * layers);
        load.push_back(
            dead_load(m, int(i) + 1, int32_t(tip[i]), {0, 0, -P * share}, 1e-9 * P, {-t.u * L, 0, -t.w * L}));
      }
      const ReferenceElasticity energy(m, load);
      ReferenceElasticity::Settings s;
      s.max_iterations = 60, s.tolerance = 1e-9;
      const auto r = energy.solve(u, s);
      u = r.u, iterations += r.iterations, converged = converged && r.residual < 1e-6;
      Vec3 mean = Vec3::Zero();
      for (size_t i : tip) mean += u[i] / double(tip.size());
      worst = std::max(worst, std::fabs(-mean[2] / (t.w * L) - 1));
    }
    error.push_back(worst);
    out.rows.push_back({"elastica, dead tip load", "hexahedra, selective reduced",
                        std::to_string(layers) + " layers, " + (aspect == 1 ? "cubic, " : "twice as long as high, ") +
                            cells(int(m.cells.size())) + ", alpha .25 to 2, " + std::to_string(iterations) +
                            " iterations",
                        cpu_ms() - before, false, 100 * worst, "%", "elliptic integrals (Mattiasson 1981)", converged});
  }
  if (set.quick) return;
  at_most(out, "elastica: tip deflection, 4 layers of cubic cells (%)", 100 * error[1], 1, "elliptic integrals");
  at_least(out, "elastica: observed order, cells twice as long as high", observed_order(error[3], error[4], 2), 1.75,
           "theory: 2");
}

}  // namespace limberg::bench
