#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "sim/base/error.h"
#include "sim/measure/extrapolation.h"

namespace limberg {
namespace test_extrapolation {

// A sequence made with a known order, at sizes of unequal ratio, is seen through.
TEST(Extrapolation, FindsOrderAndLimitOfAMadeUpSequence) {
  for (double order : {0.7, 1.0, 1.7, 2.0})
    for (double c : {0.3, -0.01}) {
      const std::vector<double> h = {2.5, 5, 3.5};
      std::vector<double> f;
      for (double x : h) f.push_back(4 + c * std::pow(x, order));
      const Extrapolation e = extrapolate(h, f);
      ASSERT_TRUE(e.asymptotic) << e.says;
      EXPECT_NEAR(*e.order, order, 1e-6);
      EXPECT_NEAR(*e.extrapolated, 4, 1e-9);
      const double rest = std::fabs(f[0] - 4);
      EXPECT_GE(*e.error, 1.25 * rest - 1e-9);
      // Above order 1 a fit with it counts too: at order 2 about 2.7 times the rest and the spread.
      EXPECT_LE(*e.error, order <= 1 ? 1.25 * rest + 1e-9 : 3.5 * rest);
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

// Steeper than the method: by hand, of the two finest of three that lie on c h^2 but for the coarsest.
TEST(Extrapolation, AnOrderThatTheMethodDoesNotHaveIsNotBelieved) {
  const std::vector<double> h = {4, 2, 1};
  std::vector<double> f;
  for (double x : h) f.push_back(7 + std::pow(x, 6));
  const Extrapolation e = extrapolate(h, f);
  EXPECT_FALSE(e.asymptotic);
  EXPECT_NEAR(*e.order, 6, 1e-5);
  EXPECT_GT(*e.error, 3 * 1.25 * std::fabs(f[2] - 7));
  EXPECT_NE(e.says.find("observed order 6"), std::string::npos) << e.says;
}

// Five sizes whose values scatter, as a lattice's do that meets the surface elsewhere each time. Eca and Hoekstra aim
// at 95 % of truths within the error; 371 of these 400 are (2026-11-26), 330 without the fit of order 1.
TEST(Extrapolation, CoversWhatScatters) {
  std::mt19937 random(7);
  const auto uniform = [&](double lo, double hi) { return lo + (hi - lo) * double(random()) / 4294967295.0; };
  int covered = 0, least_digits = 0;
  constexpr int times = 400;
  for (int k = 0; k < times; ++k) {
    const double order = uniform(0.8, 2), c = uniform(0.02, 0.1), scatter = uniform(0, 0.2);
    std::vector<double> h = {7, 5, 3.5, 2.5, 1.75}, f;
    for (double x : h) f.push_back(2 + c * std::pow(x / 3.5, order) * (1 + scatter * uniform(-1, 1)));
    const Extrapolation e = extrapolate(h, f);
    covered += *e.error >= std::fabs(f.back() - 2);
    least_digits += *e.error > 10 * std::fabs(f.back() - 2);  // says nothing
  }
  EXPECT_GE(covered, times * 92 / 100);
  EXPECT_LE(least_digits, times / 10);
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
  EXPECT_GT(*swings.error, 1);  // the largest change
  EXPECT_GT(*grows.error, 3 * (1.2 - 1.01));
  EXPECT_FALSE(swings.order);
  EXPECT_EQ(*still.error, 0.01);
  const Extrapolation two = extrapolate(std::vector<double>{5, 2.5}, std::vector<double>{1.2, 1.1});
  EXPECT_NEAR(*two.error, 0.3, 1e-12);
  EXPECT_FALSE(extrapolate(std::vector<double>{5}, std::vector<double>{1}).error);
  EXPECT_THROW(extrapolate(std::vector<double>{5, 5}, std::vector<double>{1, 2}), InputError);
  EXPECT_THROW(extrapolate({}, {}), InputError);
}

}  // namespace test_extrapolation
}  // namespace limberg
