// A short slice of the fuzzer of what devices send; `limberg bench fuzz --devices` runs a million and more.
#include <gtest/gtest.h>

#include "tests/bench/devices/fuzz.h"

namespace limberg::bench {
namespace test_devices_fuzz {

TEST(DevicesFuzz, NothingBreaksAndWhatPassesIsAsComputed) {
  DevicesFuzzSettings s;
  s.cases = 60'000;
  s.seed = 11;
  const DevicesFuzzReport r = devices_fuzz(s);
  EXPECT_GE(r.cases(), s.cases);
  EXPECT_EQ(r.violations(), 0) << r.first_violation;
  for (const Bar& b : r.result().bars) EXPECT_TRUE(b.pass) << b.name << " " << b.value << " > " << b.bar;
  // The fuzzer hits: some records pass wrong, as the format lets them, and most damaged packets are refused.
  EXPECT_GT(r.replaced.wrong, r.replaced.cases / 5);
  EXPECT_LT(r.packet.taken, r.packet.cases / 100);
  EXPECT_GT(r.log.taken, 0);
}

}  // namespace test_devices_fuzz
}  // namespace limberg::bench
