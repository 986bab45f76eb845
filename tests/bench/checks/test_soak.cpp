// What a soak's verdict sees: memory that grows, other hashes, slower steps, files and threads that are not given back.
#include <gtest/gtest.h>

#include "tests/bench/soak/acts.h"
#include "tests/bench/soak/soak.h"

namespace limberg::bench {
namespace test_soak {

/// Forty minutes of two scenes with two seeds, a round a minute, nothing wrong.
std::vector<SoakRound> sound_rounds() {
  std::vector<SoakRound> all;
  for (int k = 0; k < 40; ++k) {
    SoakRound r;
    r.part = "lockstep", r.scene = k % 2 ? "zplasty" : "rhomboid", r.seed = uint64_t(1 + k / 2 % 2);
    r.at_min = k + 1, r.hash = r.scene + std::to_string(r.seed);
    r.cpu_ms = (k % 2 ? 9 : 6) * (1 + 0.01 * (k % 3));
    r.after.trimmed_mb = (k % 2 ? 80 : 50) + 0.1 * (k % 4), r.after.allocated_mb = 20;
    r.after.files = 5, r.after.threads = 2;
    all.push_back(r);
  }
  return all;
}

std::string missed(const std::vector<SoakRound>& rounds) {
  std::string names;
  for (const Bar& b : judge_soak(rounds).bars)
    if (!b.pass) names += b.name + "\n";
  return names;
}

TEST(Soak, SoundRoundsPass) {
  EXPECT_EQ(missed(sound_rounds()), "");
  EXPECT_EQ(judge_soak(sound_rounds()).bars.size(), 8u);
}

TEST(Soak, MemoryThatGrowsIsSeen) {
  auto rounds = sound_rounds();
  for (SoakRound& r : rounds) r.after.trimmed_mb += 0.2 * r.at_min;  // 6 MB of 82 between minutes 10 and 40
  EXPECT_NE(missed(rounds).find("resident memory"), std::string::npos);
  EXPECT_EQ(missed(rounds).find("allocated"), std::string::npos);
  rounds = sound_rounds();
  rounds.back().after.allocated_mb *= 1.06;
  EXPECT_NE(missed(rounds).find("allocated memory"), std::string::npos);
}

TEST(Soak, OtherHashesSlowerStepsAndWhatIsLeftAreSeen) {
  auto rounds = sound_rounds();
  rounds[30].hash += "x";
  EXPECT_NE(missed(rounds).find("other hashes"), std::string::npos);
  rounds = sound_rounds();
  rounds[30].as_expected = false;
  EXPECT_NE(missed(rounds).find("rounds that failed"), std::string::npos);
  rounds = sound_rounds();
  for (SoakRound& r : rounds)
    if (r.at_min > 20) r.cpu_ms *= 1.2;
  EXPECT_NE(missed(rounds).find("CPU time"), std::string::npos);
  rounds = sound_rounds();
  rounds.back().after.files += 1;
  EXPECT_NE(missed(rounds).find("open files"), std::string::npos);
  rounds = sound_rounds();
  rounds.back().after.threads += 1;
  EXPECT_NE(missed(rounds).find("threads"), std::string::npos);
  rounds = sound_rounds();
  rounds[3].after.left = 1;
  EXPECT_NE(missed(rounds).find("temporary files"), std::string::npos);
}

TEST(Soak, ALongSessionGivesBackWhatItTakesBack) {
  SoakSettings set;
  set.acts = 60;
  set.stop = [] { return false; };
  const Result r = soak_acts(set);
  for (const Bar& b : r.bars) EXPECT_TRUE(b.pass) << b.name << ": " << b.value;
  ASSERT_EQ(r.rows.size(), 3u);
  EXPECT_TRUE(r.rows[0].pass && r.rows[1].pass) << "no act was done";
}

}  // namespace test_soak
}  // namespace limberg::bench
