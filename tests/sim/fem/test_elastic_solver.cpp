// The minimiser against the full Newton reference, and what a frame may rely on.
#include <gtest/gtest.h>

#include "sim/fem/box_model.h"
#include "sim/fem/elastic_solver.h"
#include "sim/fem/reference_newton.h"

namespace limberg {
namespace {

BenchScene pulled_scene(double poisson) {
  BenchScene s = bench_scene(20, 2, poisson);
  s.springs.back().target_mm += Vec3(-10, -10, 26);
  return s;
}

double largest_difference(std::span<const Vec3f> a, std::span<const Vec3> b) {
  double m = 0;
  for (size_t i = 0; i < a.size(); ++i) m = std::max(m, (a[i].cast<double>() - b[i]).norm());
  return m;
}

class AgainstNewton : public ::testing::TestWithParam<double> {};

// Covers the primal path (nu 0.3) and the augmented one, whose fixed point must be the primal solution.
TEST_P(AgainstNewton, SameEquilibriumAfterA30mmPull) {
  const BenchScene s = pulled_scene(GetParam());
  InlineWorkers workers;
  auto solver = make_solver(workers);
  solver->set_model(std::make_shared<FemModel>(s.model), {});
  solver->set_springs(s.springs);
  StepSettings settings;
  settings.max_iterations = 400, settings.tolerance = 3e-6;
  const StepReport r = solver->step(settings);
  EXPECT_TRUE(r.converged);
  ReferenceElasticity reference(s.model, s.springs);
  const auto q = reference.solve(std::vector<Vec3>(s.model.X_mm.size(), Vec3::Zero()), {});
  EXPECT_TRUE(q.converged);
  EXPECT_LT(largest_difference(solver->displacement_mm(), q.u), 1e-3);
}
INSTANTIATE_TEST_SUITE_P(Poisson, AgainstNewton, ::testing::Values(0.3, 0.45, 0.49));

}  // namespace
}  // namespace limberg
