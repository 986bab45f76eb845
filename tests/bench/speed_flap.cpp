// The undermined flap, and why it takes twice the steps of a slit.
//
// The metric is scalar: it takes a sheet for a membrane, whose stiffness against a wave
// of number k is mu t k^2, and not for a plate, which gives way by bending as E t^3 k^4
// / 12. The quotient (t k)^2 / 4 is how far too stiff the metric is in the sheet's slow
// waves. Measured here: the extreme eigenvalues of metric^-1 times stiffness (Lanczos
// with full orthogonalisation; the stiffness by differences of the gradient in double,
// with the bulk modulus that the minimiser meets). Steps go with the root of their
// quotient, as for conjugate gradients, whatever the pull, and however long the history.
#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "app/operating_point/cpu_clock.h"
#include "sim/fem/preconditioner/cholesky.h"
#include "sim/fem/solver/lbfgs_solver.h"
#include "sim/testing/reference_newton.h"
#include "tests/bench/speed_parts.h"
#include "tests/bench/wound_block.h"

namespace limberg::bench {
namespace {

using Field = std::vector<Vec3>;
constexpr int modes_known = 20;

double dot(const Field& a, const Field& b) {
  double s = 0;
  for (size_t i = 0; i < a.size(); ++i) s += a[i].dot(b[i]);
  return s;
}

struct Spectrum {
  std::vector<double> value;      // of metric^-1 stiffness, as far as 100 Lanczos steps know it, ascending
  std::vector<KnownMode> lowest;  // what belongs to the first of them
};

Spectrum spectrum(const FemModel& m, const Field& u) {
  const ReferenceElasticity elastic(m, {});
  const fem::ScalarMatrix A = fem::assemble_scalar(m, {}, 0, false);
  InlineWorkers workers;
  const fem::ScalarFactor F = fem::factorize(A, workers);
  const fem::Engine engine(workers);
  const size_t n = m.X_mm.size();
  const auto stiffness = [&](const Field& v) {
    double largest = 0;
    for (const Vec3& x : v) largest = std::max(largest, x.norm());
    const double eps = 1e-4 / largest;
    Field plus = u, minus = u, g(n, Vec3::Zero()), a, b;
    for (size_t i = 0; i < n; ++i) plus[i] += eps * v[i], minus[i] -= eps * v[i];
    elastic.gradient(plus, a), elastic.gradient(minus, b);
    for (const int32_t i : F.node_order) g[size_t(i)] = (a[size_t(i)] - b[size_t(i)]) / (2 * eps);
    return g;
  };
  const auto metric = [&](const Field& r) {
    NodeArray y(F.node_order.size());
    for (size_t k = 0; k < y.size(); ++k) {
      const Vec3& v = r[size_t(F.node_order[k])];
      y[k] = {float(v[0]), float(v[1]), float(v[2]), 0};
    }
    F.panels.solve(y.data(), engine);
    Field z(n, Vec3::Zero());
    for (size_t k = 0; k < y.size(); ++k)
      z[size_t(F.node_order[k])] = Vec3(double(y[k].x), double(y[k].y), double(y[k].z));
    return z;
  };
  Field r(n, Vec3::Zero());
  for (const int32_t i : F.node_order)
    r[size_t(i)] = Vec3(std::sin(3.0 * i + 1), std::sin(5.0 * i + 2), std::sin(7.0 * i + 3));
  Field z = metric(r);
  const auto scale = [&](double by) {
    for (Vec3& x : r) x *= by;
    for (Vec3& x : z) x *= by;
  };
  scale(1 / std::sqrt(dot(r, z)));
  std::vector<Field> R, Z;
  constexpr int steps = 100;
  Eigen::MatrixXd T = Eigen::MatrixXd::Zero(steps, steps);
  for (int k = 0; k < steps; ++k) {
    R.push_back(r), Z.push_back(z);
    r = stiffness(z);
    T(k, k) = dot(r, z);
    for (int pass = 0; pass < 2; ++pass)
      for (size_t j = 0; j < R.size(); ++j) {
        const double c = dot(r, Z[j]);
        for (size_t i = 0; i < n; ++i) r[i] -= c * R[j][i];
      }
    z = metric(r);
    const double b = std::sqrt(std::max(1e-300, dot(r, z)));
    if (k + 1 < steps) T(k, k + 1) = T(k + 1, k) = b;
    scale(1 / b);
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eig(T);
  Spectrum out;
  for (int k = 0; k < steps; ++k) out.value.push_back(eig.eigenvalues()[k]);
  for (int k = 0; k < modes_known; ++k) {
    KnownMode& w = out.lowest.emplace_back();
    w.quotient = out.value[size_t(k)], w.w.assign(n, Vec3::Zero());
    for (int j = 0; j < steps; ++j)
      for (size_t i = 0; i < n; ++i) w.w[i] += eig.eigenvectors()(j, k) * Z[size_t(j)][i];
  }
  return out;
}

struct Steps {
  int to_1 = -1, to_01 = -1;  // percent of the pull's 10 mm and 1 mm: 1 and 0.1 mm at full pull
};

Steps steps(const std::shared_ptr<const FemModel>& model, double pulled_mm, int pairs) {
  InlineWorkers workers;
  const std::vector<Spring> hook{lip_hook(*model, pulled_mm)};
  std::vector<Vec3f> exact;
  std::vector<double> error;
  for (const bool reference : {true, false}) {
    fem::LbfgsSolver s(workers, true, {1 << 30}, {reference ? 0 : pairs, false});
    s.set_model(model, {});
    s.set_springs(hook);
    StepSettings set;
    set.max_iterations = reference ? 2500 : 1, set.tolerance = reference ? 2.5e-6 : 0;
    if (reference) {
      s.step(set);
      s.step(set);
      exact.assign(s.displacement_mm().begin(), s.displacement_mm().end());
      continue;
    }
    for (int k = 0; k < 300 && (k == 0 || error.back() > 0.03 * pulled_mm); ++k) {
      s.step(set);
      double e = 0;
      for (size_t i = 0; i < exact.size(); ++i) e = std::max(e, double((s.displacement_mm()[i] - exact[i]).norm()));
      error.push_back(e);
    }
  }
  Steps out;
  for (int k = int(error.size()); k-- > 0 && error[size_t(k)] <= 1.0 * pulled_mm;) out.to_1 = k + 1;
  for (int k = int(error.size()); k-- > 0 && error[size_t(k)] <= 0.1 * pulled_mm;) out.to_01 = k + 1;
  return out;
}

/// With the bulk modulus of the augmented energy as the plain one: what the minimiser meets between two updates.
FemModel as_met(const FemModel& model) {
  FemModel m = model;
  for (Stencil& s : m.stencils) s.lambda_kPa = fem::effective_bulk_kPa(s, true);
  return m;
}

}  // namespace

void speed_flap(const SpeedRun& run) {
  const FemModel block = sided_block(run.settings.quick ? 24 : 44, run.settings.quick ? 2 : 3);
  const char* size = run.settings.quick ? "2k" : "8k";
  double slit_condition = 0;
  int slit_steps = 0;
  for (const double flap_mm : {0.0, 20.0}) {
    run.say(flap_mm > 0 ? "the undermined flap" : "the slit alone");
    const auto model = std::make_shared<FemModel>(wounded_block(block, flap_mm));
    const std::string name = std::string(flap_mm > 0 ? "slit and flap of 20 mm, " : "slit, ") + size + " nodes";
    std::string how;
    const Steps full = steps(model, 1, 0), small = steps(model, 0.1, 0), longer = steps(model, 1, 40);
    how =
        fmt::format("{} to 1 mm; a tenth of the pull, same accuracy in parts of it: {}; with a history of 40 pairs: {}",
                    full.to_1, small.to_01, longer.to_01);
    run.out.rows.push_back({name, "exact factor of the shape at rest", how, 0, full.to_01 < 0, double(full.to_01),
                            "steps", "L-BFGS to residual 2.5e-6", true});
    const FemModel met = as_met(*model);
    std::vector<std::vector<KnownMode>> modes;  // at rest, pulled
    const auto shape = [&](const char* what, const Field& u) {
      const double start = cpu_ms();
      Spectrum found = spectrum(met, u);
      const double low = found.value.front(), high = found.value.back();
      how = fmt::format(
          "metric^-1 stiffness from {:.4f} to {:.2f}, {}; the 2nd, 6th, 11th and 21st from below {:.4f}, {:.4f}, "
          "{:.4f}, {:.4f}",
          low, high, what, found.value[1], found.value[5], found.value[10], found.value[20]);
      modes.push_back(std::move(found.lowest));
      run.out.rows.push_back(
          {name, "condition number", how, cpu_ms() - start, false, high / low, "", "Lanczos, 100 steps", true});
      return high / low;
    };
    const double at_rest = shape("at rest", Field(model->X_mm.size(), Vec3::Zero()));
    InlineWorkers workers;
    fem::LbfgsSolver pulled(workers, false, {1 << 30});
    pulled.set_model(std::make_shared<FemModel>(met), {});
    pulled.set_springs(std::vector<Spring>{lip_hook(met, 1)});
    StepSettings settle;
    settle.max_iterations = 1500, settle.tolerance = 3e-6;
    pulled.step(settle);
    Field u;
    for (const Vec3f& v : pulled.displacement_mm()) u.push_back(v.cast<double>());
    const double bent = shape("pulled", u);
    if (flap_mm == 0) {
      slit_condition = bent, slit_steps = full.to_01;
      continue;
    }
    const double more = double(full.to_01) / slit_steps, expected = std::sqrt(bent / slit_condition);
    how = fmt::format(
        "steps x {:.2f} of the slit's; root of the condition numbers' quotient, pulled: x {:.2f} (at rest, of the "
        "pulled slit's: x {:.2f})",
        more, expected, std::sqrt(at_rest / slit_condition));
    run.out.rows.push_back(
        {name, "why", how, 0, false, more / expected, "x", "steps over what the condition says", true});
    // Would it pay to tell the metric its softest modes? Plain L-BFGS in double on the energy as it is met. A hundredth
    // of the pull turns nothing: there the modes at rest are the right ones, and show what they are worth.
    const std::vector<Spring> slight{lip_hook(met, 0.01)};
    const std::vector<Vec3> nearly = equilibrium(std::make_shared<FemModel>(met), slight);
    int slight_plain = 0, slight_best = 1 << 20, best = 1 << 20;
    for (const int known : {0, 5, modes_known}) {
      how = fmt::format("a hundredth of the pull, steps to 0.1 mm of it at full size, {} softest modes known", known);
      const int taken = scalar_double_steps(met, slight, nearly, 0.001, std::span(modes[0]).first(size_t(known)));
      if (known == 0)
        slight_plain = taken;
      else if (taken > 0)
        slight_best = std::min(slight_best, taken);
      run.out.rows.push_back({name, "deflation", how, 0, taken < 0, double(taken), "steps", "", true});
    }
    const std::vector<Spring> hook{lip_hook(met, 1)};
    const std::vector<Vec3> exact = equilibrium(std::make_shared<FemModel>(met), hook);
    int plain = 0;
    for (const int known : {0, 5, 10, modes_known})
      for (const bool at_pulled : {false, true}) {
        if (known == 0 && at_pulled) continue;
        const int taken = scalar_double_steps(met, hook, exact, 0.1, std::span(modes[at_pulled]).first(size_t(known)));
        if (known == 0)
          plain = taken;
        else if (taken > 0 && !at_pulled)
          best = std::min(best, taken);
        how = known == 0
                  ? std::string("steps to 0.1 mm, scalar double, no mode known")
                  : fmt::format("steps to 0.1 mm, scalar double, metric told the {} softest modes of the shape {}",
                                known, at_pulled ? "as pulled, which nobody knows before" : "at rest");
        run.out.rows.push_back({name, "deflation", how, 0, taken < 0, double(taken), "steps",
                                "x " + std::to_string(double(taken) / plain).substr(0, 4) + " of without", true});
      }
    how = fmt::format(
        "{}: told the softest modes at rest, the metric takes {} instead of {} steps for a hundredth of the pull, but "
        "{} instead of {} for all of it: the flap turns on the way, and its soft modes with it. Not built.",
        name, slight_best, slight_plain, best, plain);
    run.out.notes.push_back(how);
    run.bar(name + ": steps to 0.1 mm", full.to_01, 120, false, "prototype: 120 to 147, not understood");
  }
}

}  // namespace limberg::bench
