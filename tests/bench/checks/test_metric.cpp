// The quick form of the metric rows: every bar that is not a time holds, and all is filled in.
#include <gtest/gtest.h>

#include "tests/bench/metric.h"

namespace limberg {
namespace test_metric {

TEST(BenchMetric, QuickRowsHold) {
  const bench::Result b = bench::cut_metric({true, {}});
  EXPECT_GE(b.rows.size(), 12u);
  EXPECT_EQ(b.bars.size(), 3u);
  for (const bench::Row& r : b.rows) EXPECT_TRUE(r.pass) << r.name << ": " << r.method;
  for (const Bar& x : b.bars) EXPECT_TRUE(x.pass) << x.name << ": " << x.value << " against " << x.bar;
}

}  // namespace test_metric
}  // namespace limberg
