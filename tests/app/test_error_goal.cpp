#include <gtest/gtest.h>

#include <cmath>

#include "app/result/error_goal.h"

namespace limberg {
namespace test_error_goal {

// Figures of a lattice of order p: f + c h^p.
struct Lattice {
  double force_N = 2, force_c = 0.01, ear_mm = 1, ear_c = 0.002, order = 2;
  SizedFigures run(double h) const {
    SizedFigures r;
    r.cell_mm = h;
    r.figures.closure_force_N = force_N + force_c * std::pow(h, order);
    r.figures.dog_ear_mm = ear_mm + ear_c * std::pow(h, order);
    return r;
  }
};

struct Course {
  std::vector<double> sizes_mm;
  ErrorGoal goal;
};
Course course_of(const Lattice& l, double share, double seconds_first = 1, double grows = 2, double limit_s = 1e9) {
  Course c{{}, {share, 3.5, limit_s}};
  std::vector<SizedFigures> runs;
  double took = seconds_first;
  for (bool more = true; more; took *= grows) {
    c.sizes_mm.push_back(c.goal.next_mm());
    runs.push_back(l.run(c.goal.next_mm()));
    more = c.goal.go_on(runs, took);
  }
  return c;
}

TEST(ErrorGoal, StopsAsSoonAsTheErrorIsSmallEnoughAndIsTrue) {
  const Lattice l;
  for (const double share : {0.1, 0.05, 0.02}) {
    const Course c = course_of(l, share);
    ASSERT_TRUE(c.goal.met()) << share << ": " << c.goal.why();
    EXPECT_NEAR(c.sizes_mm[0], 3.5 * std::sqrt(2), 1e-12);
    EXPECT_NEAR(c.sizes_mm[1], 3.5, 1e-12);
    const double h = c.sizes_mm.back(), off = l.force_c * h * h;
    EXPECT_LE(off, share * l.force_N);  // what was promised
    if (c.sizes_mm.size() > 3) {  // one size earlier it was not there yet, by order 1 at the most (2.7 times, spread)
      const double before = 2 * h * h;
      EXPECT_GT(3.5 * l.force_c * before, share * (l.force_N + l.force_c * before));
    }
  }
  EXPECT_GT(course_of(l, 0.01).sizes_mm.size(), course_of(l, 0.1).sizes_mm.size());
}

TEST(ErrorGoal, AFigureThatDoesNotSettleIsMissedAfterTheLastSize) {
  const Course c = course_of({2, -0.5, 1, 0.002, 0.3}, 0.01);
  EXPECT_FALSE(c.goal.met());
  EXPECT_EQ(c.sizes_mm.size(), size_t(kMostSizes));
  ASSERT_EQ(c.goal.rows().size(), 2u);
  EXPECT_FALSE(c.goal.rows()[0].met());
  EXPECT_TRUE(c.goal.rows()[1].met());  // a tenth of a millimetre is good enough for a length
}

TEST(ErrorGoal, TakesNoLongerThanIsAllowed) {
  // 10, 40 and 160 s; the next would take 640.
  const Course c = course_of({}, 0.001, 10, 4, 300);
  EXPECT_FALSE(c.goal.met());
  EXPECT_EQ(c.sizes_mm.size(), 3u);
  EXPECT_NE(c.goal.why().find("640 s"), std::string::npos) << c.goal.why();
}

TEST(ErrorGoal, AnOperationWithoutFiguresEnds) {
  const Course c = course_of({0, 0, 0, 0, 1}, 0.05);
  EXPECT_FALSE(c.goal.met());
  EXPECT_EQ(c.sizes_mm.size(), 3u);
}

TEST(ErrorGoal, SharesInWords) {
  EXPECT_EQ(parse_share("5%"), 0.05);
  EXPECT_EQ(parse_share("5 %"), 0.05);
  EXPECT_EQ(parse_share("0.1"), 0.1);
  for (const char* bad : {"", "%", "5", "0", "0.01%", "101%", "nan", "inf", "5%%", "5 percent", "-5%"})
    EXPECT_FALSE(parse_share(bad)) << bad;
}

}  // namespace test_error_goal
}  // namespace limberg
