// The metric through random operations on a patient: after every act it belongs to the topology that is shown, and
// carried over it has the bits of one made afresh.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "sim/fem/solver/engine.h"
#include "sim/fem/solver/focus_solver.h"
#include "sim/patient/soft_tissue.h"
#include "sim/patient/world.h"
#include "tests/sim/patient/small_block.h"

namespace limberg {
namespace test_metric_history {

WorldSpec block(bool refined) {
  WorldSpec spec = test::small_block({.cell_mm = 4, .along = 1.1, .across = 1.06});
  spec.refine_fronts = refined;
  return spec;
}

class MetricHistory : public testing::TestWithParam<int> {};

TEST_P(MetricHistory, FollowsEveryActAndIsTheSameAfresh) {
  std::mt19937_64 rng{uint64_t(GetParam())};
  const auto real = [&](double lo, double hi) { return lo + (hi - lo) * double(rng() >> 11) / 9007199254740992.0; };
  const auto point = [&] { return ChartPoint{real(-22, 22), real(-22, 22)}; };
  InlineWorkers workers;
  World world(block(GetParam() % 2), workers);
  StepSettings two;
  two.max_iterations = 2;
  world.step(two);
  const auto& solver = dynamic_cast<const fem::FocusSolver&>(world.skin()->solver()).whole();
  int done = 0, compared = 0, rows = 0, made = 0;
  for (int k = 0; k < 16; ++k) {
    const ChartPoint p = point();
    Command act;
    switch (rng() % 8) {
      case 0:
        act = Excise{{p, p + Vec2(8, 1), p + Vec2(7, 8), p + Vec2(-1, 7)}, real(2, 5)};
        break;
      case 1:
        act = Undermine{{p, p + Vec2(12, 0), p + Vec2(12, 9), p + Vec2(0, 9)}, real(2, 5)};
        break;
      case 2:
        act = Suture{p, p + Vec2(real(-6, 6), real(-6, 6))};
        break;
      case 3:
        act = Undo{};
        break;
      case 4:
        act = Redo{};
        break;
      default:
        act = Incise{{p, point()}, real(2, 5), real(50, 130)};
    }
    if (!world.apply(act).done) continue;
    ++done;
    const StepReport r = world.step(two);
    EXPECT_TRUE(std::isfinite(r.energy_uJ));
    if (!r.metric_is_cycle) continue;
    const auto cycle = solver.metric().cycle();
    ASSERT_TRUE(cycle);
    EXPECT_TRUE(fem::same_model(cycle->model(), world.skin()->solver().model()));
    const auto afresh =
        fem::ScalarCycle::rebuild(*cycle, std::make_shared<FemModel>(cycle->model()), {},
                                  {cycle->springs().begin(), cycle->springs().end()}, cycle->mass_per_s2());
    ASSERT_EQ(afresh->made().rows, afresh->made().of_rows);
    ASSERT_TRUE(cycle->same_matrices(*afresh)) << "act " << k;
    ++compared, rows += cycle->made().of_rows, made += cycle->made().rows;

    const FemModel& m = cycle->model();
    const std::vector<uint8_t> free = fem::free_nodes(m);
    NodeArray a(free.size()), b(free.size()), za(free.size()), zb(free.size());
    for (size_t i = 0; i < free.size(); ++i) {
      if (!free[i]) continue;
      a[i] = {float(real(-1, 1)), float(real(-1, 1)), float(real(-1, 1)), 0};
      b[i] = {float(real(-1, 1)), float(real(-1, 1)), float(real(-1, 1)), 0};
    }
    InlineWorkers inline_workers;
    const fem::Engine engine(inline_workers);
    fem::ScalarCycle::Work work;
    cycle->apply(a, za, work, engine), cycle->apply(b, zb, work, engine);
    const double size = std::sqrt(engine.dot(a, za) * engine.dot(b, zb));
    EXPECT_GT(engine.dot(a, za), 0);
    EXPECT_NEAR(engine.dot(a, zb), engine.dot(b, za), 2e-5 * size);
  }
  EXPECT_GT(done, 6);
  EXPECT_GT(compared, 3);
  RecordProperty("rows", rows), RecordProperty("rows_made", made);
}

INSTANTIATE_TEST_SUITE_P(Seeds, MetricHistory, testing::Range(1, 9));

}  // namespace test_metric_history
}  // namespace limberg
