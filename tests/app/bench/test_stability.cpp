// The stability suite: one case per family recovers, and a case that cannot recover is told so.
#include <gtest/gtest.h>

#include "app/bench/stability.h"
#include "app/bench/stability_cases.h"

namespace limberg::bench {
namespace {

TEST(Stability, OneCaseOfEveryFamilyRecovers) {
  StabilitySettings s;
  s.quick = true;
  const Result r = stability(s);
  EXPECT_GE(r.rows.size(), 8u);
  for (const Row& row : r.rows) EXPECT_TRUE(row.pass) << row.name << ": " << row.settings;
  ASSERT_EQ(r.bars.size(), 1u);
  EXPECT_TRUE(r.bars[0].pass);
}

TEST(Stability, ThereAreAtLeastThirtyCasesAndNoTwoAlike) {
  const auto all = stability_cases(false);
  EXPECT_GE(all.size(), 30u);
  for (size_t i = 0; i < all.size(); ++i)
    for (size_t j = 0; j < i; ++j) EXPECT_FALSE(all[i].family == all[j].family && all[i].name == all[j].name);
}

}  // namespace
}  // namespace limberg::bench
