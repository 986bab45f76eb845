// What the verdict on live runs sees: other figures, another end, acts that are missing, events that were lost.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/bench/live/live.h"

namespace limberg::bench {
namespace test_live {

LiveRun sound_run() {
  LiveRun r;
  r.status = 0, r.acts = 27;
  r.figures = {{"closure_force_N", 1.7}, {"scar_length_mm", 91}, {"wound_gape_max_mm", 0.8}};
  return r;
}

std::string missed(const LiveRun& run) {
  std::string names;
  for (const Bar& b : judge_live({{"rhomboid", 1, 55, {sound_run(), run}}}, {{"rhomboid", sound_run()}}).bars)
    if (!b.pass) names += b.name + "\n";
  return names;
}

TEST(Live, RunsLikeLockstepPass) {
  LiveRun near = sound_run();
  near.figures["closure_force_N"] = 1.7 * 1.04;
  near.figures["wound_gape_max_mm"] = 0.84;  // 5 % of itself, 4 % of its floor of a millimetre
  near.waited_s = 20;                        // a slow machine, told, and no worse
  EXPECT_EQ(missed(near), "");
}

TEST(Live, WhatComesOutOtherwiseIsSeen) {
  LiveRun other = sound_run();
  other.figures["closure_force_N"] = 1.7 * 1.06;
  EXPECT_NE(missed(other).find("difference"), std::string::npos);
  EXPECT_EQ(live_difference(other, sound_run()).second, "closure_force_N");
  other = sound_run();
  other.figures["scar_length_mm"] = NAN;
  EXPECT_NE(missed(other).find("difference"), std::string::npos);
  other = sound_run();
  other.figures.erase("scar_length_mm");
  EXPECT_NE(missed(other).find("difference"), std::string::npos);
  other = sound_run();
  other.status = 3;
  EXPECT_NE(missed(other).find("did not come out"), std::string::npos);
  other = sound_run();
  other.acts = 26;
  EXPECT_NE(missed(other).find("did not come out"), std::string::npos);
  other = sound_run();
  other.lost = 1;
  EXPECT_NE(missed(other).find("events lost"), std::string::npos);
}

}  // namespace test_live
}  // namespace limberg::bench
