// Elementary functions of our own: as exact as they say, and the same bits on every machine.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>

#include "sim/base/elementary.h"
#include "sim/base/hash.h"
#include "sim/geometry/rotation.h"

namespace limberg {
namespace test_elementary {

struct Case {
  const char* name;
  double (*ours)(double);
  long double (*exact)(long double);  // of more than 53 bits: its own error does not count
  double from, to;
  double most_ulp;  // as elementary.h says
};

double fourth_power(double x) { return elementary::pow(x, 4.25); }
long double exact_fourth_power(long double x) { return std::pow(x, 4.25L); }
double angle(double x) { return elementary::atan2(0.7, x); }
long double exact_angle(long double x) { return std::atan2((long double)(0.7), x); }
double length(double x) { return elementary::hypot(x, 1.3); }
long double exact_length(long double x) { return std::hypot(x, (long double)(1.3)); }

const Case cases[] = {
    {"exp", elementary::exp, std::exp, -700, 700, 1},
    {"exp, small", elementary::exp, std::exp, -1, 1, 1},
    {"expm1", elementary::expm1, std::expm1, -2, 2, 4},
    {"log", elementary::log, std::log, 1e-3, 1e3, 1},
    {"log near 1", elementary::log, std::log, 0.99, 1.01, 1},
    {"log10", elementary::log10, std::log10, 1e-3, 1e3, 2},
    {"sin", elementary::sin, std::sin, -10, 10, 1},
    {"sin, large", elementary::sin, std::sin, -1e6, 1e6, 1},
    {"cos", elementary::cos, std::cos, -10, 10, 1},
    {"tan", elementary::tan, std::tan, -1.6, 1.6, 3},
    {"atan", elementary::atan, std::atan, -20, 20, 3},
    {"atan2", angle, exact_angle, -4, 4, 3},
    {"asin", elementary::asin, std::asin, -1, 1, 4},
    {"acos", elementary::acos, std::acos, -1, 1, 4},
    {"tanh", elementary::tanh, std::tanh, -3, 3, 4},
    {"cbrt", elementary::cbrt, std::cbrt, -1e3, 1e3, 1},
    {"hypot", length, exact_length, -4, 4, 2},
    {"pow", fourth_power, exact_fourth_power, 0.3, 3, 11},  // 1 + 2 * 4.25 ln 3.3
};

/// Evenly over the range, with a step that no power of two divides.
double place(const Case& c, int i, int n) { return c.from + (c.to - c.from) * ((i + 0.318309886) / n); }

TEST(Elementary, AreAsExactAsTheySay) {
  for (const Case& c : cases) {
    SCOPED_TRACE(c.name);
    double worst = 0;
    for (int i = 0; i < 20000; ++i) {
      const double x = place(c, i, 20000);
      const long double want = c.exact(x);
      const double near = double(std::abs(want)), ulp = std::nextafter(near, 1e308) - near;
      worst = std::max(worst, double(std::abs(c.ours(x) - want)) / ulp);
    }
    EXPECT_LE(worst, c.most_ulp);
  }
}

// The number was found on x86_64 with g++ 12 on 2026-11-23; every other machine and compiler has to find it too.
TEST(Elementary, GiveTheSameBitsEverywhere) {
  Hash64 h;
  for (const Case& c : cases)
    for (int i = 0; i < 2000; ++i) h.add(c.ours(place(c, i, 2000)));
  EXPECT_EQ(h.value(), 14712213814268315075u);
}

TEST(Elementary, SpecialValues) {
  const double inf = std::numeric_limits<double>::infinity(), nan = std::nan("");
  EXPECT_EQ(elementary::exp(-inf), 0);
  EXPECT_EQ(elementary::exp(inf), inf);
  EXPECT_EQ(elementary::exp(0), 1);
  EXPECT_EQ(elementary::log(0), -inf);
  EXPECT_EQ(elementary::log(1), 0);
  EXPECT_TRUE(std::isnan(elementary::log(-1)));
  EXPECT_NEAR(elementary::log(5e-324), -744.4400719213812, 1e-12);
  EXPECT_EQ(elementary::pow(0, 0.5), 0);
  EXPECT_EQ(elementary::pow(0, 0), 1);
  EXPECT_EQ(elementary::pow(-2, 3), -8);
  EXPECT_EQ(elementary::pow(2, -3), 0.125);
  EXPECT_TRUE(std::isnan(elementary::pow(-2, 0.5)));
  EXPECT_EQ(elementary::cbrt(27), 3);
  EXPECT_EQ(elementary::cbrt(-0.001 * 0), 0);
  EXPECT_TRUE(std::isnan(elementary::sin(inf)));
  EXPECT_DOUBLE_EQ(elementary::hypot(3e200, 4e200), 5e200);
  EXPECT_EQ(elementary::hypot(3, 4), 5);
  for (const double bad : {nan}) {
    for (auto f : {elementary::exp, elementary::log, elementary::sin, elementary::cos, elementary::atan,
                   elementary::tanh, elementary::cbrt, elementary::asin})
      EXPECT_TRUE(std::isnan(f(bad)));
  }
  for (const double y : {0., -0., 1., -1., inf, -inf})
    for (const double x : {0., -0., 1., -1.}) {
      EXPECT_DOUBLE_EQ(elementary::atan2(y, x), std::atan2(y, x)) << y << " " << x;
      EXPECT_EQ(std::signbit(elementary::atan2(y, x)), std::signbit(std::atan2(y, x))) << y << " " << x;
    }
}

TEST(Rotation, IsEigensAndBack) {
  for (const double turn : {1e-9, 0.3, 1.5, 3.1}) {
    const Vec3 axis = Vec3(0.3, -0.8, 0.2).normalized();
    const Mat3 R = rotation(turn, axis);
    EXPECT_LT((R - Eigen::AngleAxisd(turn, axis).toRotationMatrix()).norm(), 1e-15);
    const AxisAngle back = axis_angle(R);
    EXPECT_NEAR(back.angle, turn, 1e-14);
    EXPECT_LT((back.axis * back.angle - axis * turn).norm(), 1e-14);
  }
  EXPECT_EQ(axis_angle(Mat3::Identity()).angle, 0);
}

TEST(Rotation, QuaternionsAndAnglesOfATracker) {
  const Vec3 axis = Vec3(0.3, -0.8, 0.2).normalized();
  for (const double turn : {-2.9, 1e-9, 0.3, 3.1}) {
    EXPECT_LT((turn_about(turn, axis).toRotationMatrix() - rotation(turn, axis)).norm(), 1e-15);
    const Eigen::Quaterniond a = turn_about(0.7, Vec3::UnitZ()), b = turn_about(turn, axis);
    EXPECT_LT((between(a, b, 0).toRotationMatrix() - a.toRotationMatrix()).norm(), 1e-14);
    EXPECT_LT((between(a, b, 1).toRotationMatrix() - b.toRotationMatrix()).norm(), 1e-14);
    EXPECT_LT((between(a, b, 0.3).toRotationMatrix() - a.slerp(0.3, b).toRotationMatrix()).norm(), 1e-14);
    const Vec3 angles = azimuth_elevation_roll(b.toRotationMatrix());
    EXPECT_LT(
        (rotation(angles[0], Vec3::UnitZ()) * rotation(angles[1], Vec3::UnitY()) * rotation(angles[2], Vec3::UnitX()) -
         b.toRotationMatrix())
            .norm(),
        1e-14);
  }
}

}  // namespace test_elementary
}  // namespace limberg
