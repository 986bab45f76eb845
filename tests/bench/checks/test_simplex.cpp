// The suite of simplex meshes: its rows and bars are there, and random operators keep every invariant.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/bench/simplex.h"

namespace limberg::bench {
namespace test_simplex {

TEST(BenchSimplex, QuickRunHasItsRowsAndBars) {
  SimplexSettings s;
  s.quick = true;
  int notes = 0;
  s.progress = [&](const std::string&) { ++notes; };
  const Result r = simplex_suite(s);
  EXPECT_GT(notes, 3);
  ASSERT_EQ(r.bars.size(), 4u);
  EXPECT_TRUE(r.bars[3].pass) << r.bars[3].name;  // operators; the others are times
  EXPECT_EQ(
      std::count_if(r.rows.begin(), r.rows.end(), [](const Row& x) { return x.method == "plain loop of scalars"; }), 3);
  for (const Row& x : r.rows) {
    EXPECT_TRUE(x.pass) << x.name;
    EXPECT_GT(x.time_ms, 0) << x.name;
  }
}

}  // namespace test_simplex
}  // namespace limberg::bench
