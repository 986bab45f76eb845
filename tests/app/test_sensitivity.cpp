// Sampled studies: points, distributions, and what is read from a design, against closed forms.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <set>

#include "app/study/sensitivity.h"
#include "app/study/uncertainty.h"
#include "sim/base/error.h"

namespace limberg::study {
namespace test_sensitivity {

using Function = std::function<double(const UnitPoint&)>;

Shares shares_of(const Function& y, SampleKind kind, size_t n, size_t d, uint64_t seed) {
  const Design design = design_of(kind, n, d, seed, true);
  const auto part = [&](size_t k) {
    std::vector<double> out;
    for (size_t j = 0; j < n; ++j) out.push_back(y(design.points[k * n + j]));
    return out;
  };
  std::vector<std::vector<double>> ab;
  for (size_t i = 0; i < d; ++i) ab.push_back(part(2 + i));
  return sensitivity(part(0), part(1), ab);
}

// sin x1 + 7 sin^2 x2 + 0.1 x3^4 sin x1, each uniform from -pi to pi (Ishigami and Homma 1990): its variances are
// closed forms.
double ishigami(const UnitPoint& u) {
  const auto x = [&](size_t i) { return std::numbers::pi * (2 * u[i] - 1); };
  return std::sin(x(0)) + 7 * std::pow(std::sin(x(1)), 2) + 0.1 * std::pow(x(2), 4) * std::sin(x(0));
}

void expect_ishigami(const Shares& s, double within) {
  constexpr double a = 7, b = 0.1, pi = std::numbers::pi;
  const double p4 = std::pow(pi, 4), p8 = p4 * p4;
  const double v1 = 0.5 * std::pow(1 + b * p4 / 5, 2), v2 = a * a / 8, v13 = b * b * p8 * (1. / 18 - 1. / 50);
  const double v = v1 + v2 + v13;
  const double first[] = {v1 / v, v2 / v, 0}, total[] = {(v1 + v13) / v, v2 / v, v13 / v};
  ASSERT_EQ(s.of.size(), 3u);
  EXPECT_NEAR(s.variance / v, 1, within);
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(s.of[i].first, first[i], within) << i;
    EXPECT_NEAR(s.of[i].total, total[i], within) << i;
  }
}

TEST(Sensitivity, OfIshigamisFunctionIsItsClosedForm) {
  expect_ishigami(shares_of(ishigami, SampleKind::sobol, 4096, 3, 1), 0.01);
  expect_ishigami(shares_of(ishigami, SampleKind::latin, 8192, 3, 1), 0.04);
}

// The product of (|4 x_i - 2| + a_i) / (1 + a_i) (Sobol's g): V_i = 1 / 3 (1 + a_i)^2, V + 1 = product of (1 + V_i).
TEST(Sensitivity, OfSobolsFunctionIsItsClosedForm) {
  const std::vector<double> a{0, 1, 4.5, 9, 99, 99};
  const auto g = [&](const UnitPoint& u) {
    double y = 1;
    for (size_t i = 0; i < a.size(); ++i) y *= (std::abs(4 * u[i] - 2) + a[i]) / (1 + a[i]);
    return y;
  };
  const Shares s = shares_of(g, SampleKind::sobol, 8192, a.size(), 2);
  std::vector<double> part;
  double product = 1;
  for (const double x : a) part.push_back(1 / (3 * (1 + x) * (1 + x))), product *= 1 + part.back();
  ASSERT_EQ(s.of.size(), a.size());
  for (size_t i = 0; i < a.size(); ++i) {
    EXPECT_NEAR(s.of[i].first, part[i] / (product - 1), 0.01) << i;
    EXPECT_NEAR(s.of[i].total, part[i] * product / (1 + part[i]) / (product - 1), 0.01) << i;
  }
}

// Of 40 designs of 128 points, the 95 % intervals must hold the truth in most; and they must not hold everything.
TEST(Sensitivity, IntervalsHoldTheTruthAsOftenAsTheySay) {
  const auto line = [](const UnitPoint& u) { return 2 * u[0] + u[1]; };  // shares 0.8 and 0.2
  int held = 0;
  double width = 0;
  for (uint64_t seed = 1; seed <= 40; ++seed) {
    const Shares s = shares_of(line, SampleKind::latin, 128, 2, seed);
    held += s.of[0].total_low <= 0.8 && 0.8 <= s.of[0].total_high;
    width += (s.of[0].total_high - s.of[0].total_low) / 40;
  }
  EXPECT_GE(held, 34);
  EXPECT_GT(width, 0.05);
  EXPECT_LT(width, 0.6);
}

TEST(Sensitivity, LeavesOutRowsOfWhichAMemberFailed) {
  const Design design = design_of(SampleKind::sobol, 64, 2, 1, true);
  std::vector<double> a, b, c, d;
  for (size_t j = 0; j < 64; ++j) {
    const auto y = [&](size_t k) { return design.points[k * 64 + j][0] + 3 * design.points[k * 64 + j][1]; };
    a.push_back(y(0)), b.push_back(y(1)), c.push_back(y(2)), d.push_back(y(3));
  }
  c[5] = std::numeric_limits<double>::quiet_NaN();
  const Shares s = sensitivity(a, b, {c, d});
  EXPECT_EQ(s.rows, 63u);
  EXPECT_NEAR(s.of[1].total, 0.9, 0.1);
  EXPECT_TRUE(std::isfinite(s.of[0].first_low) && std::isfinite(s.of[0].total_high));
  for (double& v : c) v = 1;
  for (double& v : a) v = 1;
  for (double& v : b) v = 1;
  EXPECT_TRUE(sensitivity(a, b, {c, c}).of.empty());  // nothing varies
  EXPECT_TRUE(sensitivity({1, 2}, {2, 3}, {{1, 2}}).of.empty());
}

TEST(Sampling, ALatinHypercubeHasAPointInEachPart) {
  const std::vector<UnitPoint> points = unit_points(SampleKind::latin, 50, 4, 3);
  for (size_t i = 0; i < 4; ++i) {
    std::set<int> parts;
    for (const UnitPoint& p : points) parts.insert(int(p[i] * 50));
    EXPECT_EQ(parts.size(), 50u) << i;
  }
  EXPECT_EQ(points, unit_points(SampleKind::latin, 50, 4, 3));
  EXPECT_NE(points, unit_points(SampleKind::latin, 50, 4, 4));
}

// A net: each of the 16 x 16 boxes of two coordinates has exactly one of 256 points, whatever the seed.
TEST(Sampling, SobolsPointsAreANet) {
  for (const uint64_t seed : {0u, 1u, 77u}) {
    std::set<std::pair<int, int>> boxes;
    for (const UnitPoint& p : unit_points(SampleKind::sobol, 256, 2, seed))
      boxes.insert({int(16 * p[0]), int(16 * p[1])});
    EXPECT_EQ(boxes.size(), 256u) << seed;
  }
}

TEST(Sampling, ADesignChangesOneCoordinateAtATime) {
  const Design d = design_of(SampleKind::sobol, 16, 3, 5, true);
  ASSERT_EQ(d.points.size(), 16u * 5);
  for (size_t j = 0; j < 16; ++j)
    for (size_t i = 0; i < 3; ++i)
      for (size_t k = 0; k < 3; ++k) EXPECT_EQ(d.points[d.of_ab(i, j)][k], d.points[k == i ? d.of_b(j) : j][k]);
}

constexpr const char* kRanges = R"(name = "skin"
study = "tissue"
[[parameter]]
name = "skin_kPa"
distribution = "log-normal"
low = 20
high = 180
source = "somewhere"
)";

TEST(Ranges, HaveTheQuantilesThatTheyName) {
  const Family& family = find_family("tissue");
  const Distribution d = parse_ranges(kRanges, "r", family).parameters.at(0);
  EXPECT_NEAR(d.quantile(0.05), 20, 1e-6);
  EXPECT_NEAR(d.quantile(0.5), 60, 1e-6);
  EXPECT_NEAR(d.quantile(0.95), 180, 1e-5);
  Distribution whole = d;
  whole.spread = Spread::whole, whole.low = 1, whole.high = 3;
  std::set<double> values;
  for (double u = 0; u <= 1; u += 0.01) values.insert(whole.quantile(u));
  EXPECT_EQ(values, (std::set<double>{1, 2, 3}));
}

TEST(Ranges, ThatMakeNoSenseAreRefused) {
  const Family& family = find_family("tissue");
  const std::string sound = kRanges;
  for (const auto& [from, to] : std::vector<std::pair<std::string, std::string>>{{"skin_kPa", "skin"},
                                                                                 {"log-normal", "bell"},
                                                                                 {"low = 20", "low = 200"},
                                                                                 {"low = 20", "low = nan"},
                                                                                 {"high = 180", "high = 1e9"},
                                                                                 {"source", "reason"},
                                                                                 {"tissue", "disc"},
                                                                                 {"[[parameter]]", "[parameter]"},
                                                                                 {"name = \"skin\"\n", ""}}) {
    std::string text = sound;
    text.replace(text.find(from), from.size(), to);
    EXPECT_THROW(parse_ranges(text, "r", family), InputError) << text;
  }
  EXPECT_THROW(parse_ranges(sound + sound.substr(sound.find("[[")), "r", family), InputError);
  EXPECT_THROW(load_ranges("no-such-skin", family), InputError);
}

TEST(Ranges, TheShippedOnesSayWhereEachComesFrom) {
  const Ranges r = load_ranges("facial-skin", find_family("tissue"));
  EXPECT_EQ(r.name, "facial skin");
  EXPECT_GE(r.parameters.size(), 5u);
  for (const Distribution& d : r.parameters) EXPECT_GT(d.source.size(), 20u) << d.parameter;
}

TEST(SampledStudy, DrawsWhatIsNotSetAndKnowsItsMembersAgain) {
  const Family& family = find_family("tissue");
  const Ranges ranges = load_ranges("facial-skin", family);
  const SampledStudy s =
      sampled_study(family, {"flap_angle=45,60", "poisson=0.45"}, ranges, SampleKind::sobol, 16, 1, true);
  EXPECT_EQ(s.ranges.parameters.size(), ranges.parameters.size() - 1);  // poisson stays as it was set
  EXPECT_EQ(s.design.points.size(), 16u * 7);
  ASSERT_EQ(s.cases.size(), 2u);
  EXPECT_EQ(s.cases[1].setting, "flap_angle 60");
  EXPECT_EQ(s.members.size(), 2 * 16u * 7);
  for (const Values& v : s.members) {
    EXPECT_EQ(v[4], 0.45);
    members(family, {});  // each is one that --set could name
    for (size_t i = 0; i < v.size(); ++i)
      EXPECT_TRUE(v[i] >= family.parameters[i].lo && v[i] <= family.parameters[i].hi);
  }
  EXPECT_THROW(sampled_study(family, {"flap=1"}, ranges, SampleKind::sobol, 16, 1, true), InputError);
  std::vector<std::string> all;
  for (const Distribution& d : ranges.parameters) all.push_back(d.parameter + "=" + std::to_string(int(d.high)));
  all[3] = "poisson=0.45";
  EXPECT_THROW(sampled_study(family, all, ranges, SampleKind::sobol, 16, 1, true), InputError);
}

TEST(SampledStudy, BandsAreOfTheMembersThatAreThere) {
  const Family& family = find_family("tissue");
  const SampledStudy s = sampled_study(family, {}, load_ranges("facial-skin", family), SampleKind::sobol, 64, 1, true);
  std::vector<Row> rows;
  std::vector<size_t> row_of;
  for (size_t m = 1; m < s.members.size(); ++m) {  // the first has failed
    Row r;
    for (const std::string& figure : family.outcomes) r.figures.emplace_back(figure, s.members[m][1]);  // the stiffness
    rows.push_back(r), row_of.push_back(m);
  }
  const ResultUncertainty u = uncertainty_of(s, family, rows, row_of);
  ASSERT_EQ(u.cases.size(), 1u);
  const ResultBand& b = u.cases[0].figures.at(0);
  EXPECT_EQ(b.figure, "closure_force_N");
  EXPECT_EQ(b.members, 127);
  EXPECT_EQ(b.rows, 63);
  EXPECT_NEAR(*b.median, 60, 3);
  EXPECT_NEAR(*b.low, 20, 3);
  EXPECT_NEAR(*b.high, 180, 25);
  for (const ResultShare& share : b.shares)
    EXPECT_NEAR(*share.total, share.parameter == "skin_kPa" ? 1 : 0, 0.1) << share.parameter;
  EXPECT_TRUE(std::isnan(quantile({}, 0.5)));
  EXPECT_EQ(quantile({3, 1, 2}, 0.5), 2);
}

}  // namespace test_sensitivity
}  // namespace limberg::study
