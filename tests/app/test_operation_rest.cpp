// An operation ends where more iterations cannot bring it nearer to rest, and says so.
#include <gtest/gtest.h>

#include "app/assembly/operation.h"
#include "tests/sim/patient/small_block.h"

namespace limberg {
namespace test_operation_rest {

OperationOutcome pulled(double residual) {
  InlineWorkers workers;
  WorldSpec spec =
      test::small_block({.thickness_mm = 8, .skin_cell_mm = 2.5, .cell_mm = 4, .along = 1.1, .across = 1.06});
  World world(spec, workers);
  Script script;
  script.name = "script";
  script.lines = {{1, SetHook{1, {0, 0}}}, {2, MoveHook{1, {3, 0, 2}, 0}}};
  OperationSettings set;
  set.rest_residual = set.final_residual = residual;
  set.rest_steps = set.final_steps = 400;
  return operate(world, 7, script, set);
}

TEST(Operation, EndsAtTheFloorOfSinglePrecision) {
  const OperationOutcome asked = pulled(1e-5), never = pulled(1e-12);
  EXPECT_LE(asked.last.residual, 1e-5);
  EXPECT_FALSE(asked.stalled);
  EXPECT_TRUE(never.last.at_floor);
  EXPECT_TRUE(never.stalled);
  EXPECT_LT(never.last.residual, 1e-5);
  EXPECT_LT(never.series.residual.size(), 200u) << "of three times 400 steps";
}

}  // namespace test_operation_rest
}  // namespace limberg
