// The kind of flap is read from its cuts, typed or drawn by a trembling hand.
#include <gtest/gtest.h>

#include <random>

#include "sim/measure/plan.h"
#include "tests/sim/commands/shipped_scripts.h"

namespace limberg {
namespace test_plan {

std::vector<ChartPoint> drawn(const std::vector<ChartPoint>& corners, bool closed, std::mt19937_64& rng) {
  std::uniform_real_distribution<double> u(-0.4, 0.4);
  std::vector<ChartPoint> p;
  const size_t n = corners.size() + (closed ? 1 : 0);
  for (size_t i = 1; i < n; ++i)
    for (int k = 0; k < 25; ++k) {
      const double t = k / 25.0;
      p.push_back((1 - t) * corners[i - 1] + t * corners[i % corners.size()] + Vec2(u(rng), u(rng)));
    }
  p.push_back(closed ? corners[0] : corners.back());
  return p;
}

TEST(Plan, FindsTheFlapOfTheShippedRhomboid) {
  std::mt19937_64 rng(1);
  for (bool by_hand : {false, true}) {
    auto script = test::shipped_commands("rhomboid");
    if (by_hand)
      for (Command& c : script) {
        if (auto* e = std::get_if<Excise>(&c)) e->outline = drawn(e->outline, true, rng);
        if (auto* i = std::get_if<Incise>(&c)) i->path = drawn(i->path, false, rng);
      }
    const std::vector<ChartPoint> corner{{-17.321, -10}, {0, 0}, {17.321, -10}, {0, -20}};  // C, D, E, F
    const auto f = find_transposition_flap(script);
    ASSERT_TRUE(f);
    EXPECT_LT((f->C - corner[0]).norm(), 1.0);
    EXPECT_LT((f->D - corner[1]).norm(), 1.0);
    EXPECT_LT((f->E - corner[2]).norm(), 1.0);
    EXPECT_LT((f->F - corner[3]).norm(), 1.0);
    EXPECT_FALSE(find_central_limb(script));
  }
}

TEST(Plan, FindsTheCentralLimbOfTheShippedZ) {
  std::mt19937_64 rng(2);
  for (bool by_hand : {false, true}) {
    auto script = test::shipped_commands("zplasty");
    if (by_hand)
      for (Command& c : script)
        if (auto* i = std::get_if<Incise>(&c)) i->path = drawn(i->path, false, rng);
    const auto z = find_central_limb(script);
    ASSERT_TRUE(z);
    EXPECT_LT((z->A - ChartPoint(0, 10)).norm(), 1.0);
    EXPECT_LT((z->B - ChartPoint(0, -10)).norm(), 1.0);
    EXPECT_FALSE(find_transposition_flap(script));
  }
}

TEST(Plan, OtherCutsAreNeither) {
  const std::vector<Command> u{Incise{{{-10, 0}, {-10, 20}, {10, 20}, {10, 0}}, 4, 90}};  // both limbs on one side
  EXPECT_FALSE(find_central_limb(u));
  const std::vector<Command> away{Excise{{{0, 0}, {10, 0}, {10, 10}, {0, 10}}, 4},
                                  Incise{{{30, 0}, {50, 0}, {50, 20}}, 4, 90}};
  EXPECT_FALSE(find_transposition_flap(away));
  EXPECT_TRUE(corners_of_path({}).empty());
  EXPECT_TRUE(corners_of_outline({}).empty());
  const std::vector<ChartPoint> same(50, ChartPoint(1, 1));
  EXPECT_EQ(corners_of_path(same).size(), 2u);
  EXPECT_EQ(corners_of_outline(same).size(), 1u);
}

}  // namespace test_plan
}  // namespace limberg
