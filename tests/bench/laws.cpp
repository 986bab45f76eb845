#include "tests/bench/laws.h"

#include <fmt/format.h>

#include <cmath>

#include "app/operating_point/cpu_clock.h"
#include "sim/fem/materials/catalogue.h"
#include "sim/fem/model/box_model.h"
#include "sim/fem/solver/elastic_solver.h"
#include "sim/lattice/stencil_integrals.h"

namespace limberg::bench {
namespace {

struct Case {
  const char* name;
  int side, layers;
  std::function<LawSpec(double mu_kPa, bool top)> law;  // of that shear modulus at small strain
};

std::vector<Case> cases(bool quick) {
  const auto one = [](const char* name, const char* key, double factor) {
    return [=](double mu, bool) { return LawSpec{name, {{key, {factor * mu}}}}; };
  };
  const int side = quick ? 24 : 44, layers = quick ? 2 : 3;
  return {{"stable neo-Hookean", side, layers, [](double, bool) { return LawSpec{}; }},
          {"fibres in the skin", side, layers,
           [](double mu, bool top) {
             return top ? LawSpec{"gasser-ogden-holzapfel",
                                  {{"mu_kPa", {mu}},
                                   {"k1_kPa", {5 * mu}},
                                   {"k2", {2}},
                                   {"kappa", {0.2}},
                                   {"fibre_angle_deg", {41}}}}
                        : LawSpec{};
           }},
          {"Mooney-Rivlin", 24, 2,
           [](double mu, bool) {
             return LawSpec{"mooney-rivlin", {{"c10_kPa", {0.3 * mu}}, {"c01_kPa", {0.2 * mu}}}};
           }},
          {"Ogden, alpha 9", 24, 2,
           [](double mu, bool) {
             return LawSpec{"ogden", {{"mu_kPa", {2 * mu / 9}}, {"alpha", {9}}}};
           }},
          {"corotated", 24, 2, one("corotated", "mu_kPa", 1)},
          {"Saint Venant-Kirchhoff", 24, 2, one("saint-venant-kirchhoff", "mu_kPa", 1)}};
}

/// The bench scene with the law of the case in its stencils: 0 below, 1 on top.
BenchScene scene_of(const Case& c, double nu) {
  BenchScene s = bench_scene(c.side, c.layers, nu);
  Body body;
  for (const double young : {18.0, 60.0}) {
    Layer l;
    l.material.young_kPa = young, l.material.poisson = nu;
    l.material.law = c.law(l.material.mu_kPa(), young > 30);
    body.layers.push_back(l);
  }
  const std::vector<LayerMatter> matter = layer_matter(body, s.model.laws);
  for (size_t i = 0; i < 2; ++i) {
    Stencil st;
    add_box(st, s.model.cell_mm, Vec3::Zero(), Vec3::Ones(), matter[i], {});
    finish_stencil(st);
    s.model.stencils[i] = st;
  }
  return s;
}

struct Count {
  int iterations = 0;
  double ms = 0, error_mm = 0;
  bool reached = false;
};

/// Iterations until every node stays within 0.1 mm of where the solver ends when it is let run.
Count count(const BenchScene& s) {
  InlineWorkers one;
  const auto model = std::make_shared<const FemModel>(s.model);
  std::vector<std::vector<Vec3f>> path;
  auto solver = make_solver(one);
  solver->set_model(model, {});
  solver->set_springs(s.springs);
  StepSettings step;
  step.max_iterations = 1;
  Count c;
  constexpr int limit = 300;
  const double start = cpu_ms();
  for (int i = 0; i < limit; ++i) {
    solver->step(step);
    path.emplace_back(solver->displacement_mm().begin(), solver->displacement_mm().end());
  }
  c.ms = (cpu_ms() - start) / limit;
  step.max_iterations = 700, step.tolerance = 5e-7;
  solver->step(step);
  const auto end = solver->displacement_mm();
  c.iterations = limit;
  for (size_t i = path.size(); i-- > 0;) {
    double error = 0;
    for (size_t n = 0; n < end.size(); ++n) error = std::max(error, double((path[i][n] - end[n]).norm()));
    if (i + 1 == path.size()) c.error_mm = error;
    if (error > 0.1) break;
    c.iterations = int(i) + 1, c.reached = true;
  }
  return c;
}

}  // namespace

Result laws(const LawsSettings& settings) {
  Result out;
  for (const Case& c : cases(settings.quick)) {
    int first = 0;
    for (const double nu : {0.3, 0.45, 0.49, 0.499}) {
      const std::string what = fmt::format("nu {:.3f}", nu);
      if (settings.progress) settings.progress(std::string(c.name) + ", " + what);
      const BenchScene s = scene_of(c, nu);
      const Count n = count(s);
      if (nu == 0.3) first = n.iterations;
      const std::string how = fmt::format("{} iterations to 0.1 mm{}, {} nodes", n.iterations,
                                          n.reached ? "" : " (not reached)", s.model.X_mm.size());
      out.rows.push_back(
          {c.name, what, how, n.ms * n.iterations, !n.reached, n.error_mm, "mm", "the same model, converged", true});
      if (nu < 0.485) continue;
      const double ratio = double(n.iterations) / first, wanted = nu < 0.495 ? 1.5 : 2;
      out.bars.push_back({std::string(c.name) + ": iterations at " + what + " / at .3", ratio, !n.reached, wanted,
                          false, n.reached && ratio <= wanted,
                          "issue: .49 at no more than 1.5 times, .499 at no more than twice those of .3"});
    }
  }
  const Result more = layers(settings);
  out.rows.insert(out.rows.end(), more.rows.begin(), more.rows.end());
  out.bars.insert(out.bars.end(), more.bars.begin(), more.bars.end());
  out.notes = more.notes;
  return out;
}

}  // namespace limberg::bench
