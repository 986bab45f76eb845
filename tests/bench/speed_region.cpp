// Tissue far from the operation: kept whole, left out (fem/region_solver.h), or condensed.
//
// Condensed: far tissue that answers linearly can be eliminated exactly; what is
// left of it is a full matrix between the nodes of its border (its Schur
// complement). So the model below, whose far cells have the small-strain law of
// their tissue, gives the very answer that a condensed one would give, and what a
// condensed one takes is an absent one's time and the product with that matrix.
#include <fmt/format.h>

#include <cmath>

#include "app/operating_point/cpu_clock.h"
#include "sim/fem/elements/material_points.h"
#include "sim/fem/solver/lbfgs_solver.h"
#include "sim/fem/solver/region_solver.h"
#include "tests/bench/speed_parts.h"
#include "tests/bench/wound_block.h"

namespace limberg::bench {
namespace {

/// mu |sym G|^2 (mu: Lame's), or lambda/2 (tr G)^2, of G = F - I.
class SmallStrain final : public MaterialLaw {
 public:
  SmallStrain(double mu, double lambda) : mu_(mu), lambda_(lambda) {}
  Response at(const Mat3& F) const override {
    const Mat3 G = F - Mat3::Identity(), e = 0.5 * (G + G.transpose());
    return {mu_ * e.squaredNorm() + 0.5 * lambda_ * e.trace() * e.trace(),
            2 * mu_ * e + lambda_ * e.trace() * Mat3::Identity()};
  }
  Mat9 tangent_kPa(const Mat3&, bool) const override {
    Mat9 C = Mat9::Zero();
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        C(3 * j + i, 3 * j + i) += mu_, C(3 * j + i, 3 * i + j) += mu_;
        C(4 * i, 4 * j) += lambda_;
      }
    return C;
  }
  std::string describe() const override { return "small strains"; }

 private:
  double mu_, lambda_;
};

bool is_near(const FemModel& m, const HexCell& c, double half_mm) {
  const Vec3 middle = 0.5 * (m.X_mm[size_t(c.node[0])] + m.X_mm[size_t(c.node[7])]);
  return std::fabs(middle[0]) < half_mm && std::fabs(middle[1]) < half_mm;
}

/// Far cells absent, the nodes of no other cell held (as lattice/region.h leaves them).
std::shared_ptr<const FemModel> without_far(const FemModel& whole, double half_mm) {
  auto m = std::make_shared<FemModel>(whole);
  std::vector<uint8_t> far(whole.X_mm.size(), 0);  // touched by a far cell
  for (size_t c = 0; c < whole.cells.size(); ++c) {
    HexCell cell = whole.cells[c];
    if (is_near(whole, cell, half_mm)) continue;
    cell.scale = 0;
    m->cells.set(c, cell);
    for (int32_t v : cell.node) far[size_t(v)] = 1;
  }
  for (size_t v = 0; v < far.size(); ++v)
    if (far[v]) m->fixed.set(v, 1);
  return m;
}

/// Far cells linear: the stencil's K and volume term as laws of small strains. Returns how many nodes the border has.
std::shared_ptr<const FemModel> linear_far(const FemModel& whole, double half_mm, int& border) {
  auto m = std::make_shared<FemModel>(whole);
  const int32_t kinds = int32_t(whole.stencils.size());
  for (int32_t k = 0; k < kinds; ++k) {
    const Stencil from = whole.stencils[size_t(k)];
    const double mu = from.mu_kPa, lame = from.lambda_kPa - from.mu_kPa;  // reparametrised: lambda = Lame's + mu
    const int32_t law = int32_t(m->laws.size());
    m->laws.push_back(std::make_shared<SmallStrain>(mu, 0.0));
    m->laws.push_back(std::make_shared<SmallStrain>(0.0, lame));
    Stencil to = fem::law_stencil(whole.cell_mm, law, *m->laws[size_t(law)], 0, from.density_kg_mm3);
    MaterialPoint centre;
    centre.volume_mm3 = from.volume_mm3, centre.law = law + 1;
    to.points.push_back(centre);
    to.mu_kPa = mu;
    m->stencils.push_back(to);
  }
  std::vector<uint8_t> touched(whole.X_mm.size(), 0);
  for (size_t c = 0; c < whole.cells.size(); ++c) {
    HexCell cell = whole.cells[c];
    const bool here = is_near(whole, cell, half_mm);
    for (int32_t v : cell.node) touched[size_t(v)] |= here ? 1 : 2;
    if (here) continue;
    cell.stencil += kinds;
    m->cells.set(c, cell);
  }
  border = 0;
  for (size_t v = 0; v < touched.size(); ++v) border += touched[v] == 3 && !whole.fixed[v];
  return m;
}

struct RegionAnswer {
  std::vector<Vec3f> u;
  double force_N = 0, iteration_ms = 0;
  std::string size;
};

RegionAnswer pulled(const std::shared_ptr<const FemModel>& model, bool region, const Spring& hook) {
  InlineWorkers workers;
  std::unique_ptr<ElasticSolver> solver = std::make_unique<fem::LbfgsSolver>(workers);
  if (region) solver = std::make_unique<fem::RegionSolver>(std::move(solver));
  solver->set_model(model, {});
  solver->set_springs(std::span(&hook, 1));
  StepSettings s;
  s.max_iterations = 0;
  solver->step(s);
  RegionAnswer a;
  Times times;
  for (int part = 0; part < 5; ++part) {
    s.max_iterations = 20;
    const double start = cpu_ms();
    const StepReport r = solver->step(s);
    if (r.iterations > 0) times.add((cpu_ms() - start) / r.iterations);
  }
  s.max_iterations = 1500, s.tolerance = 3e-6;
  solver->step(s);
  a.u.assign(solver->displacement_mm().begin(), solver->displacement_mm().end());
  a.force_N = solver->spring_force_mN(hook.id).norm() * 1e-3, a.iteration_ms = times.best();
  size_t free = 0;
  const FemModel& m = region ? static_cast<const fem::RegionSolver&>(*solver).present() : solver->model();
  for (Held h : m.fixed) free += !h.all();
  a.size = std::to_string(free) + " free nodes";
  return a;
}

/// A full symmetric matrix of n rows of float times a vector, from wherever it lies in memory.
double product_ms(int n) {
  std::vector<float> S(size_t(n) * size_t(n), 1e-3f), x(size_t(n), 1.0f), y(size_t(n), 0.0f);
  Times t;
  for (int repeat = 0; repeat < 7; ++repeat) {
    const double start = cpu_ms();
    Eigen::Map<Eigen::VectorXf>(y.data(), n).noalias() =
        Eigen::Map<const Eigen::MatrixXf>(S.data(), n, n) * Eigen::Map<const Eigen::VectorXf>(x.data(), n);
    t.add(cpu_ms() - start);
    x[size_t(repeat)] += y[0] * 1e-9f;
  }
  return t.best();
}

}  // namespace

void speed_region(const SpeedRun& run) {
  run.say("tissue far from the operation");
  const FemModel whole = wounded_block(sided_block(run.settings.quick ? 24 : 44, run.settings.quick ? 2 : 3), 0);
  const char* name = "far tissue, slit of 50 mm pulled open by 14 mm";
  const Spring hook = lip_hook(whole, 1);
  const RegionAnswer exact = pulled(std::make_shared<FemModel>(whole), false, hook);
  double largest = 0;
  for (const Vec3f& v : exact.u) largest = std::max(largest, double(v.norm()));
  std::string how = fmt::format("{}; hook {:.4f} N, moved by {:.2f} mm at most", exact.size, exact.force_N, largest);
  run.out.rows.push_back({name, "the whole block", how, exact.iteration_ms, false, 0, "mm", "itself", true});
  for (const double half_mm : {32.0, 40.0, 48.0}) {
    int border = 0;
    const auto linear = linear_far(whole, half_mm, border);
    const RegionAnswer absent = pulled(without_far(whole, half_mm), true, hook),
                       condensed = pulled(linear, false, hook);
    const auto error = [&](const RegionAnswer& a) {
      double e = 0;
      for (const HexCell& c : whole.cells)
        if (is_near(whole, c, half_mm))
          for (int32_t v : c.node) e = std::max(e, double((a.u[size_t(v)] - exact.u[size_t(v)]).norm()));
      return e;
    };
    const double product = product_ms(3 * border), evaluations = 4.0 / 3;
    how =
        fmt::format("beyond {:.0f} mm; {}, hook {:+.2f} %; x {:.2f} of the whole block's iteration", half_mm,
                    absent.size, 100 * (absent.force_N / exact.force_N - 1), absent.iteration_ms / exact.iteration_ms);
    run.out.rows.push_back(
        {name, "absent", how, absent.iteration_ms, false, error(absent), "mm", "the whole block, inside", true});
    const double time = absent.iteration_ms + evaluations * product;
    how = fmt::format(
        "beyond {:.0f} mm; border of {} nodes: {:.1f} MB, {:.3f} ms a product; hook {:+.2f} %; x {:.2f} of the whole "
        "block's iteration",
        half_mm, border, 36e-6 * border * border, product, 100 * (condensed.force_N / exact.force_N - 1),
        time / exact.iteration_ms);
    run.out.rows.push_back({name, "condensed, linear (time: absent + product)", how, time, false, error(condensed),
                            "mm", "the whole block, inside", true});
  }
  run.out.notes.push_back(
      "far tissue: absent is what the program has (a scene's region_mm): cheapest, and wrong by what held sides are "
      "wrong, so the region must reach well beyond the operation. Condensed and linear it would be far more exact at "
      "the same region, "
      "but its full matrix takes more than the cells it replaces as soon as the region is large, every cut near the "
      "border would change it, and the multilevel metric would need its own share of it: measured, not built");
}

}  // namespace limberg::bench
