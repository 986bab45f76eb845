// The fault harness: a sample of its cases, and that it finds what it is there to find.
#include <gtest/gtest.h>

#include "tests/bench/faults/harness.h"

namespace limberg::bench {
namespace test_faults {

#if defined(__SANITIZE_THREAD__) || defined(__SANITIZE_ADDRESS__)
constexpr bool kShimWorks = false;  // they stand where the shim would
#else
constexpr bool kShimWorks = true;
#endif

TEST(Faults, ASampleIsSurvivedInWordsAndLosesNothing) {
  if (!kShimWorks) GTEST_SKIP() << "under a sanitizer";
  faults::Settings s;
  s.cases = 60, s.seed = 24;
  int64_t reached = 0;
  for (const faults::Judgement& j : faults::run_cases(s)) {
    EXPECT_TRUE(j.sound()) << j.of.number << " " << faults::name_of(j.of.kind) << " in "
                           << faults::calls()[j.of.call].name << " (" << j.of.fault() << "): " << j.why << "\n"
                           << j.said;
    reached += j.reached;
  }
  EXPECT_GE(reached, 45);
}

// Memory that fails once, wherever the main thread asks for it, ends the emulation in words or changes nothing.
TEST(Faults, MemoryThatFailsOnceNeverMakesAnotherOperation) {
  if (!kShimWorks) GTEST_SKIP() << "under a sanitizer";
  faults::Settings s;
  faults::Case c;
  c.call = 2, c.kind = faults::Kind::no_memory;
  for (int percent = 2; percent < 100; percent += 4) c.at = -percent, c.number = percent, s.only.push_back(c);
  // While threads and patient are made nearly every one is of another place.
  for (int n = 1; n <= 60; ++n) c.at = n, c.number = 100 + n, s.only.push_back(c);
  int told = 0;
  for (const faults::Judgement& j : faults::run_cases(s)) {
    EXPECT_TRUE(j.sound()) << j.of.at << "th allocation: " << j.why << "\n" << j.said;
    told += j.status == 2;
  }
  EXPECT_GT(told, 50);
}

TEST(Faults, PlantedDefectsAreFound) {
  if (!kShimWorks) GTEST_SKIP() << "under a sanitizer";
  using faults::Kind;
  const auto planted = [](Kind kind, size_t call, int64_t percent) {
    faults::Case c;
    c.call = call, c.kind = kind, c.at = percent == 0 ? 1 : -percent;
    return c;
  };
  constexpr size_t kEmulate = 2;
  ASSERT_STREQ(faults::calls()[kEmulate].name, "emulate");
  faults::Settings s;
  s.only = {planted(Kind::plant_hold, kEmulate, 0), planted(Kind::plant_crash, kEmulate, 50)};
  const std::vector<faults::Judgement> found = faults::run_cases(s);
  ASSERT_EQ(found.size(), 2u);
  for (const faults::Judgement& j : found) {
    if (j.of.kind == Kind::plant_hold) {
      EXPECT_TRUE(j.wrong) << "a recording that never reaches the disk: " << j.why;
    } else {
      EXPECT_TRUE(j.crash) << j.why;
    }
  }
}

}  // namespace test_faults
}  // namespace limberg::bench
