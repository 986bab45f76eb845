// Starts from which nothing good can be expected: the solver must find the rest state, never a NaN.
#include <gtest/gtest.h>

#include "models.h"

namespace limberg {
namespace test_bad_starts {

enum class Start { scramble, collapse, mirror, flat };

class BadStart : public ::testing::TestWithParam<std::tuple<Start, double>> {};

TEST_P(BadStart, Recovers) {
  const auto [start, poisson] = GetParam();
  BoxSpec b;
  b.cells = {12, 12, 2}, b.size_mm = {60, 60, 10}, b.young_bottom_kPa = 18, b.poisson = poisson, b.fix_sides = true;
  const auto m = std::make_shared<FemModel>(box_model(b));
  test::Random r(17);
  std::vector<Vec3f> u(m->X_mm.size(), Vec3f::Zero());
  for (size_t i = 0; i < u.size(); ++i) {
    const Vec3 X = m->X_mm[i];
    Vec3 x = X;
    switch (start) {
      case Start::scramble:
        x = Vec3(30 * r.uniform(), 30 * r.uniform(), 5 + 5 * r.uniform());
        break;
      case Start::collapse:
        x = Vec3(0, 0, 5);
        break;
      case Start::mirror:
        x[2] = 10 - X[2];
        break;
      case Start::flat:
        x[2] = 5;
        break;
    }
    if (!m->fixed[i]) u[i] = (x - X).cast<float>();
  }
  InlineWorkers w;
  auto solver = make_solver(w);
  solver->set_model(m, {});
  solver->set_displacement_mm(u);
  StepSettings s;
  s.max_iterations = 50, s.tolerance = 1e-5;
  double worst = 1e9;
  int total = 0;
  for (int k = 0; k < 60 && worst > 1e-3; ++k) {
    const StepReport report = solver->step(s);
    total += report.iterations;
    EXPECT_TRUE(std::isfinite(report.residual) && std::isfinite(report.energy_uJ));
    worst = 0;
    for (const Vec3f& v : solver->displacement_mm()) {
      ASSERT_TRUE(v.allFinite());
      worst = std::max(worst, double(v.norm()));
    }
  }
  EXPECT_LT(worst, 1e-3) << total << " iterations";
  RecordProperty("iterations", total);
}
INSTANTIATE_TEST_SUITE_P(All, BadStart,
                         ::testing::Combine(::testing::Values(Start::scramble, Start::collapse, Start::mirror,
                                                              Start::flat),
                                            ::testing::Values(0.47, 0.49, 0.499)));

TEST(BadInput, NotANumberDoesNotStay) {
  BoxSpec b;
  b.fix_bottom = true;
  const auto m = std::make_shared<FemModel>(box_model(b));
  InlineWorkers w;
  auto solver = make_solver(w);
  solver->set_model(m, {});
  std::vector<Vec3f> u(m->X_mm.size(), Vec3f::Zero());
  u.back()[0] = std::numeric_limits<float>::quiet_NaN();
  solver->set_displacement_mm(u);
  StepSettings s;
  EXPECT_TRUE(std::isfinite(solver->step(s).residual));
  u.back()[0] = 1e30f;
  solver->set_displacement_mm(u);
  for (int k = 0; k < 3; ++k) solver->step(s);
  for (const Vec3f& v : solver->displacement_mm()) EXPECT_TRUE(v.allFinite());
}

}  // namespace test_bad_starts
}  // namespace limberg
