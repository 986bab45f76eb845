// Histograms: percentiles against sorted values, exact extremes, nothing outside.
#include "app/session/lanes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace limberg {
namespace {

TEST(Histogram, PercentilesWithinABucket) {
  std::mt19937_64 rng(7);
  std::lognormal_distribution<double> dist(std::log(20'000.0), 2.0);
  auto h = std::make_unique<Histogram>();
  std::vector<int64_t> all;
  for (int i = 0; i < 20'000; ++i) all.push_back(int64_t(dist(rng))), h->add(all.back());
  std::sort(all.begin(), all.end());
  for (const double p : {0.0, 0.5, 0.95, 0.99, 0.999}) {
    const double exact = double(all[size_t(p * double(all.size()))]);
    // A bucket spans 1/32 of its lower end: the upper end is reported.
    EXPECT_GE(double(h->percentile_ns(p)), exact) << p;
    EXPECT_LE(double(h->percentile_ns(p)), exact * (1 + 1.0 / 32) + 1) << p;
  }
  EXPECT_EQ(h->max_ns(), all.back());
  EXPECT_EQ(h->percentile_ns(1.0), all.back());
  EXPECT_EQ(h->total(), 20'000u);
}

TEST(Histogram, SmallAndExtremeValues) {
  Histogram h;
  EXPECT_EQ(h.percentile_ns(0.5), 0);
  h.add(-5);
  EXPECT_EQ(h.percentile_ns(0.5), 0);
  h.add(31), h.add(32), h.add(int64_t(1) << 60);
  EXPECT_EQ(h.percentile_ns(0.25), 31);
  EXPECT_EQ(h.percentile_ns(0.5), 32);
  EXPECT_EQ(h.max_ns(), int64_t(1) << 60);
}

}  // namespace
}  // namespace limberg
