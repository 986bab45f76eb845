#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "sim/base/error.h"
#include "sim/measure/extrapolation.h"

namespace limberg {
namespace test_extrapolation {

// A sequence made with a known order, at sizes of unequal ratio, is seen through.
TEST(Extrapolation, FindsOrderAndLimitOfAMadeUpSequence) {
  for (double order : {0.7, 1.0, 1.7, 2.0, 3.0})
    for (double c : {0.3, -0.01}) {
      const std::vector<double> h = {2.5, 5, 3.5};
      std::vector<double> f;
      for (double x : h) f.push_back(4 + c * std::pow(x, order));
      const Extrapolation e = extrapolate(h, f);
      ASSERT_TRUE(e.asymptotic) << e.says;
      EXPECT_NEAR(*e.order, order, 1e-6);
      EXPECT_NEAR(*e.extrapolated, 4, 1e-9);
      EXPECT_NEAR(*e.error, 1.25 * std::fabs(f[0] - 4), 1e-9);
      EXPECT_EQ(e.value, f[0]);
    }
}

// With a second term of higher order the error named still covers the true one.
TEST(Extrapolation, TheErrorCoversATrueOne) {
  for (double d : {-0.005, 0.005}) {
    std::vector<double> h = {5, 3.5, 2.5}, f;
    for (double x : h) f.push_back(2 + 0.1 * x + d * x * x);
    const Extrapolation e = extrapolate(h, f);
    EXPECT_GT(*e.error, std::fabs(f[2] - 2)) << e.says;
  }
}

TEST(Extrapolation, SaysWhenItDoesNotKnow) {
  const std::vector<double> h = {5, 3.5, 2.5};
  const auto of = [&](std::vector<double> f, double noise = 0) { return extrapolate(h, f, noise); };
  const Extrapolation swings = of({1, 2, 1.5}), grows = of({1, 1.01, 1.2}), steep = of({1e6, 1, 0.9999}),
                      still = of({1, 1.001, 0.9995}, 0.01);
  for (const Extrapolation& e : {swings, grows, steep}) {
    EXPECT_FALSE(e.asymptotic);
    EXPECT_FALSE(e.extrapolated);
    EXPECT_NE(e.says.find("not in the asymptotic range"), std::string::npos) << e.says;
  }
  EXPECT_NEAR(*swings.error, 3, 1e-12);
  EXPECT_EQ(*still.error, 0.01);
  const Extrapolation two = extrapolate(std::vector<double>{5, 2.5}, std::vector<double>{1.2, 1.1});
  EXPECT_NEAR(*two.error, 0.3, 1e-12);
  EXPECT_FALSE(extrapolate(std::vector<double>{5}, std::vector<double>{1}).error);
  EXPECT_THROW(extrapolate(std::vector<double>{5, 5}, std::vector<double>{1, 2}), InputError);
  EXPECT_THROW(extrapolate({}, {}), InputError);
}

}  // namespace test_extrapolation
}  // namespace limberg
