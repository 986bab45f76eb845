#include <gtest/gtest.h>

#include <cmath>

#include "tests/bench/graded.h"

namespace limberg {
namespace test_graded {

// A zone of small cells around the patch brings it nearer than the uniform cells outside it.
TEST(BenchGraded, AZoneBringsThePatchNearer) {
  const bench::Result r = bench::graded({.quick = true, .only = "patch", .progress = {}});
  double uniform = 0, graded = 0;
  for (const bench::Row& row : r.rows) {
    if (row.settings.find("5 mm:") == 0) uniform = std::max(uniform, std::fabs(row.error));
    if (row.method == "graded") graded = std::max(graded, std::fabs(row.error));
  }
  EXPECT_EQ(r.rows.size(), 6u);
  EXPECT_GT(uniform, 0);
  EXPECT_GT(graded, 0);
  EXPECT_LT(graded, uniform);
}

}  // namespace test_graded
}  // namespace limberg
