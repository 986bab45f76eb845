// Even states: every cell in the same deformation, for which closed forms exist.
#include <Eigen/Dense>
#include <cmath>

#include "app/operating_point/cpu_clock.h"
#include "sim/fem/elements/material_points.h"
#include "sim/fem/materials/fibres.h"
#include "sim/fem/materials/isotropic.h"
#include "sim/fem/materials/stable_neo_hookean.h"
#include "sim/fem/model/box_model.h"
#include "sim/testing/tet_lattice.h"
#include "tests/bench/verification_parts.h"

namespace limberg::bench {
namespace {

/// One cell of 1 mm of a law, and its even states.
class OneCell {
 public:
  OneCell(const LawPtr& law, double lambda_kPa) : model_(make(law, lambda_kPa)), energy_(model_, {}) {}

  /// Nominal stress of the faces i (first column: force on the face x = 1, and so on) at F.
  Mat3 stress_kPa(const Mat3& F) const {
    std::vector<Vec3> g;
    energy_.gradient(field(F), g);
    Mat3 P = Mat3::Zero();
    for (size_t a = 0; a < g.size(); ++a)
      for (int i = 0; i < 3; ++i)
        if (model_.X_mm[a][i] > (i == 2 ? 0.5 : 0)) P.col(i) += g[a];
    return P;
  }

  /// Stretches along `free` axes found so that their faces carry nothing; the others stay as given.
  Vec3 relax(Vec3 stretch, const std::vector<int>& free) const {
    for (int k = 0; k < 60; ++k) {
      const Mat3 P = stress_kPa(stretch.asDiagonal());
      const Eigen::MatrixXd H = energy_.dense_hessian(field(stretch.asDiagonal()), false);
      Eigen::MatrixXd D = Eigen::MatrixXd::Zero(24, Eigen::Index(free.size()));
      Eigen::VectorXd r(Eigen::Index(free.size()));
      for (Eigen::Index f = 0; f < r.size(); ++f) {
        const int i = free[size_t(f)];
        r[f] = P(i, i);
        for (Eigen::Index a = 0; a < 8; ++a) D(3 * a + i, f) = model_.X_mm[size_t(a)][i];
      }
      const Eigen::VectorXd step = (D.transpose() * H * D).fullPivLu().solve(r);
      const double small =
          0.1 / std::max(0.1, step.cwiseAbs().maxCoeff());  // no stretch changes by more than a tenth at once
      for (Eigen::Index f = 0; f < r.size(); ++f) stretch[free[size_t(f)]] -= small * step[f];
      if (step.norm() < 1e-13) break;
    }
    return stretch;
  }

 private:
  static FemModel make(const LawPtr& law, double lambda) {
    BoxSpec b;
    b.cells = {1, 1, 1}, b.size_mm = {1, 1, 1};
    FemModel m = box_model(b);
    m.laws = {law};
    for (Stencil& s : m.stencils) s = fem::law_stencil(m.cell_mm, 0, *law, lambda);
    return m;
  }
  std::vector<Vec3> field(const Mat3& F) const {
    std::vector<Vec3> u;
    for (const Vec3& X : model_.X_mm) u.push_back((F - Mat3::Identity()) * X);
    return u;
  }
  FemModel model_;
  ReferenceElasticity energy_;
};

double worst(std::initializer_list<double> e) {
  double w = 0;
  for (double x : e) w = std::max(w, std::fabs(x));
  return w;
}

/// Incompressible laws: Cauchy stress and lateral stretches against closed forms; lambda 1e5 times the shear modulus.
void incompressible(Result& out) {
  const double nearly = 1e5, mu = 20;
  const auto row = [&](const char* name, const char* what, double error, const char* reference) {
    out.rows.push_back({"homogeneous states", name, what, 0, false, 100 * error, "%", reference, error < 0.01});
    at_most(out, std::string("homogeneous: ") + name + " (%)", 100 * error, 1, "issue 4: within 1 %");
  };
  const auto uniaxial = [&](const OneCell& cell, double l, double expected) {
    const Vec3 s = cell.relax(Vec3(l, 1 / std::sqrt(l), 1 / std::sqrt(l)), {1, 2});
    return cell.stress_kPa(s.asDiagonal())(0, 0) / (s[1] * s[2]) / expected - 1;
  };
  {
    const OneCell cell(neo_hookean(mu), nearly * mu);
    double e = 0;
    for (double l : {0.7, 1.2, 1.5, 2.0}) {
      e = std::max(e, std::fabs(uniaxial(cell, l, mu * (l * l - 1 / l))));
      const Vec3 biaxial = cell.relax(Vec3(l, l, 1 / (l * l)), {2});
      e = std::max(e, std::fabs(cell.stress_kPa(biaxial.asDiagonal())(0, 0) / (l * biaxial[2]) /
                                    (mu * (l * l - std::pow(l, -4))) -
                                1));
      const Vec3 planar = cell.relax(Vec3(l, 1, 1 / l), {2});
      e = std::max(
          e, std::fabs(cell.stress_kPa(planar.asDiagonal())(0, 0) / planar[2] / (mu * (l * l - 1 / (l * l))) - 1));
    }
    Mat3 shear = Mat3::Identity();
    shear(0, 1) = 0.8;
    const Mat3 sigma = cell.stress_kPa(shear) * shear.transpose();
    e = worst({e, sigma(0, 1) / (0.8 * mu) - 1, (sigma(0, 0) - sigma(1, 1)) / (0.64 * mu) - 1});
    row("neo-Hookean", "uniaxial, equibiaxial and planar tension .7 to 2, simple shear .8", e,
        "closed forms, incompressible");
  }
  {
    const OneCell cell(mooney_rivlin(6, 4), nearly * mu);
    double e = 0;
    for (double l : {0.7, 1.2, 1.5, 2.0})
      e = std::max(e, std::fabs(uniaxial(cell, l, 2 * (6 + 4 / l) * (l * l - 1 / l))));
    row("Mooney-Rivlin", "uniaxial tension .7 to 2", e, "closed form, incompressible");
  }
  {
    const OneCell cell(ogden({{3, 9}, {-1, -4}}), nearly * mu);
    double e = 0;
    for (double l : {0.8, 1.2, 1.4})
      e = std::max(e,
                   std::fabs(uniaxial(cell, l, 3 * (std::pow(l, 9) - std::pow(l, -4.5)) - (std::pow(l, -4) - l * l))));
    row("Ogden", "uniaxial tension .8 to 1.4, alpha 9 and -4", e, "closed form, incompressible");
  }
}

/// Laws that hold their volume part: stress and lateral stretch in uniaxial tension, nu 0.3.
void compressible(Result& out) {
  const double E = 60, nu = 0.3, mu = E / (2 * (1 + nu)), lame = 2 * mu * nu / (1 - 2 * nu), bulk = lame + 2 * mu / 3;
  struct Case {
    const char* name;
    LawPtr law;
    std::function<Vec2(double)> exact;  // nominal stress, lateral stretch
  };
  const auto root = [](double lo, double hi, const std::function<double(double)>& f) {  // f rises
    for (int k = 0; k < 200; ++k) {
      const double m = 0.5 * (lo + hi);
      (f(m) < 0 ? lo : hi) = m;
    }
    return 0.5 * (lo + hi);
  };
  const std::vector<Case> cases = {
      {"stable neo-Hookean, complete", stable_neo_hookean_full(mu, lame + mu, mu),
       [&](double l) {
         const double q2 =
             (1 + mu / (lame + mu) * (1 - 1 / l)) / l;  // lateral face free: (lambda (J - 1) - mu) l = -mu
         return Vec2(mu * l - mu / l * q2, std::sqrt(q2));
       }},
      {"neo-Hookean with ln J", neo_hookean_log_full(mu, lame),
       [&](double l) {
         const double q = root(0.2, 2, [&](double a) { return mu * (a * a - 1) + lame * std::log(l * a * a); });
         return Vec2((mu * (l * l - 1) + lame * std::log(l * q * q)) / l, q);
       }},
      {"neo-Hookean, isochoric", neo_hookean_isochoric_full(mu, bulk),
       [&](double l) {
         // sigma_lateral J = mu J^-2/3 (q^2 - I1/3) + K J (J - 1) = 0
         const auto stress = [&](double a, double s) {
           const double J = l * a * a, I = l * l + 2 * a * a;
           return mu * std::pow(J, -2.0 / 3) * (s * s - I / 3) + bulk * J * (J - 1);
         };
         const double q = root(0.2, 2, [&](double a) { return stress(a, a); });
         return Vec2(stress(q, l) / l, q);
       }},
      {"linear corotated", corotated_full(mu, lame), [&](double l) { return Vec2(E * (l - 1), 1 - nu * (l - 1)); }},
      {"Saint Venant-Kirchhoff", st_venant_kirchhoff_full(mu, lame), [&](double l) {
         const double strain = 0.5 * (l * l - 1);
         return Vec2(l * E * strain, std::sqrt(1 - 2 * nu * strain));
       }}};
  for (const Case& c : cases) {
    const OneCell cell(c.law, 0);
    double e = 0;
    for (double l : {0.8, 1.2, 1.5}) {
      const Vec2 want = c.exact(l);
      const Vec3 s = cell.relax(Vec3(l, want[1] + 0.01, want[1] - 0.01), {1, 2});
      e = worst({e, cell.stress_kPa(s.asDiagonal())(0, 0) / want[0] - 1, s[1] / want[1] - 1, s[2] / want[1] - 1});
    }
    out.rows.push_back({"homogeneous states", c.name, "uniaxial tension .8 to 1.5, nu .3", 0, false, 100 * e, "%",
                        "closed form", e < 0.01});
    at_most(out, std::string("homogeneous: ") + c.name + " (%)", 100 * e, 1, "issue 4: within 1 %");
  }
}

/// Gasser-Ogden-Holzapfel, incompressible: Cauchy stress (MPa) and lateral stretch.
void fibres(Result& out) {
  struct State {
    double stretch, sigma_MPa, lateral;
  };
  const auto check = [&](const char* name, const OneCell& cell, int axis, const std::vector<State>& table) {
    double e = 0;
    for (const State& t : table) {
      // The tabulated lateral stretch is that in the plane.
      const int in_plane = axis == 0 ? 1 : 0;
      Vec3 s;
      s[axis] = t.stretch, s[in_plane] = t.lateral, s[2] = 1 / (t.stretch * t.lateral);
      s = cell.relax(s, {in_plane, 2});
      const double sigma = cell.stress_kPa(s.asDiagonal())(axis, axis) / (s[in_plane] * s[2]);
      e = worst({e, sigma / (1000 * t.sigma_MPa) - 1, s[in_plane] / t.lateral - 1});
    }
    out.rows.push_back({"homogeneous states", name,
                        "stress and lateral stretch, " + std::to_string(table.size()) + " states", 0, false, 100 * e,
                        "%", "Gasser, Ogden, Holzapfel 2006, incompressible, by quadrature-free root finding",
                        e < 0.01});
    at_most(out, std::string("homogeneous: ") + name + " (%)", 100 * e, 1, "issue 4: within 1 %");
  };
  // G1: human back skin (Ni Annaidh et al. 2012), two families at 41 degrees to the Langer line.
  const double a = 41 * M_PI / 180;
  const LawPtr back_skin = sum_of(
      {neo_hookean(201.4),
       dispersed_fibres({24530, 0.1327, 0.1404}, {{{std::cos(a), std::sin(a), 0}}, {{std::cos(a), -std::sin(a), 0}}})});
  const OneCell g1(back_skin, 1e5 * 201.4);
  check("GOH set G1 along the fibres' mean", g1, 0,
        {{1.05, 0.084584, 0.92912}, {1.10, 0.343830, 0.84134}, {1.15, 1.348058, 0.76511}, {1.20, 3.291599, 0.72905}});
  check("GOH set G1 across", g1, 1,
        {{1.05, 0.036542, 0.95935}, {1.10, 0.087253, 0.91117}, {1.20, 0.386346, 0.78324}, {1.30, 2.637876, 0.67480}});
  const LawPtr one = sum_of({neo_hookean(10), dispersed_fibres({100, 1, 0.1}, {{{1, 0, 0}}})});
  const OneCell g2(one, 1e6 * 10);
  std::vector<State> along, across;
  for (auto [l, s] : std::vector<std::pair<double, double>>{
           {1.05, 0.01296555}, {1.1, 0.02988648}, {1.2, 0.08145616}, {1.3, 0.17582198}, {1.5, 0.78899019}})
    along.push_back({l, s, 1 / std::sqrt(l)});
  for (auto [l, s] : std::vector<std::pair<double, double>>{{1.1, 0.00300909}, {1.2, 0.00606667}, {1.3, 0.00920769}})
    across.push_back({l, s, 1 / std::sqrt(l)});
  check("GOH set G2 along the fibres", g2, 0, along);
  check("GOH set G2 across: fibres off", g2, 1, across);
}

double most(const std::vector<Vec3>& g) {
  double m = 0;
  for (const Vec3& v : g) m = std::max(m, v.norm());
  return m;
}

/// Inner nodes pushed about, the surface moved evenly: does every node find its place?
void patch_and_rotation(Result& out) {
  BoxSpec b;
  b.cells = {4, 4, 4}, b.size_mm = {8, 8, 8}, b.fix_bottom = true, b.fix_sides = true;
  const auto held = [](FemModel m) {
    for (size_t i = 0; i < m.X_mm.size(); ++i) m.fixed[i] = m.fixed[i] || m.X_mm[i][2] > 8 - 1e-9;
    return m;
  };
  Mat3 A;
  A << 1.2, 0.3, -0.1, 0.05, 0.9, 0.2, -0.2, 0.1, 1.1;
  for (const auto& [name, m] : {std::pair<const char*, FemModel>{"hexahedra, selective reduced", held(box_model(b))},
                                {"linear tetrahedra, body-centred", held(bcc_box_model(b))}}) {
    const ReferenceElasticity energy(m, {});
    std::vector<Vec3> u, start, g;
    uint32_t seed = 1;
    const auto random = [&] {
      return (seed = seed * 1664525u + 1013904223u), double(seed >> 8) / double(1 << 24) - 0.5;
    };
    for (size_t i = 0; i < m.X_mm.size(); ++i) {
      u.push_back((A - Mat3::Identity()) * m.X_mm[i]);
      start.push_back(m.fixed[i] ? u.back() : Vec3(u.back() + Vec3(random(), random(), random())));
    }
    const double before = cpu_ms();
    const auto found = energy.solve(start, {});
    double error = 0;
    for (size_t i = 0; i < u.size(); ++i) error = std::max(error, (found.u[i] - u[i]).norm());
    out.rows.push_back({"patch test", name, "largest nodal error", cpu_ms() - before, false, error, "mm",
                        "even deformation", error < 1e-8});
    at_most(out, std::string("patch test, ") + name + ": largest nodal error (mm)", error, 1e-8,
            "exact but for rounding; 8 mm cube");
    double force = 0;
    for (double angle : {M_PI / 2, M_PI}) {
      const Mat3 R = Eigen::AngleAxisd(angle, Vec3(1, 2, 3).normalized()).toRotationMatrix();
      for (size_t i = 0; i < u.size(); ++i) u[i] = R * m.X_mm[i] - m.X_mm[i];
      energy.gradient(u, g);
      force = std::max(force, most(g) / (elastic_from_young(60, 0.45).mu_kPa * 4));
    }
    out.rows.push_back(
        {"rigid rotation", name, "90 and 180 degrees", 0, false, force, "mu h2", "no force", force < 1e-10});
    at_most(out, std::string("rigid rotation, ") + name + ": largest force (mu h^2)", force, 1e-10,
            "exact but for rounding");
  }
}

}  // namespace

void even_states(Result& out, const VerificationSettings&) {
  patch_and_rotation(out);
  incompressible(out);
  compressible(out);
  fibres(out);
}

}  // namespace limberg::bench
