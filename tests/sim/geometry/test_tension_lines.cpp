// Lines of tension by place: what a file says, what is between its places, and what the skin's frame makes of them.
#include <gtest/gtest.h>

#include <cmath>

#include "sim/base/error.h"
#include "sim/body/block.h"
#include "sim/body/skin.h"
#include "sim/body/tension_lines.h"

namespace limberg {
namespace test_tension_lines {

std::shared_ptr<Body> block() {
  BlockSpec s;
  s.size_mm = {60, 60, 10};
  s.skin_cell_mm = 2;
  s.layers = {{"skin", 1.5, {}}, {"fat", 8.5, {}}};
  auto b = std::make_shared<Body>(make_block(s));
  b->is_box = false;
  return b;
}

double angle_deg(const Vec3& a, const Vec3& b) {  // between lines: their sense means nothing
  return std::acos(std::min(1.0, std::abs(a.normalized().dot(b.normalized())))) * 180 / M_PI;
}

/// Round an axis at the origin, on rings; the sense of every third is turned.
TensionSpec rings() {
  TensionSpec s;
  for (int r = 1; r <= 8; ++r)
    for (int k = 0; k < 8 * r; ++k) {
      const double a = 2 * M_PI * k / (8 * r);
      const Vec3 along(-std::sin(a), std::cos(a), 0);
      s.places.push_back({{5.0 * r * std::cos(a), 5.0 * r * std::sin(a), 0}, k % 3 ? along : Vec3(-along)});
    }
  return s;
}

TEST(TensionLines, BetweenPlacesTheyTurnEvenlyWhateverTheirSense) {
  auto b = block();
  b->tension = tension_lines_of(rings(), *b);
  ASSERT_EQ(b->tension.size(), b->surface.X_mm.size());
  const Skin skin(b);
  double worst = 0;
  for (double r = 6; r < 28; r += 0.7)
    for (double a = 0; a < 6.3; a += 0.11) {
      const Vec3 X(r * std::cos(a), r * std::sin(a), 0);
      const Skin::Frame f = skin.frame(X);
      EXPECT_NEAR(f.along.norm(), 1, 1e-12);
      EXPECT_LT(std::abs(f.along.dot(f.normal)), 1e-9);
      worst = std::max(worst, angle_deg(f.along, {-std::sin(a), std::cos(a), 0}));
    }
  // Places are 5 mm apart; on the innermost ring that is 45 degrees, and half of it what lies between may be off.
  EXPECT_LT(worst, 9);
  // At a place it is that of the place, to what a triangle of 2 mm turns by.
  EXPECT_LT(angle_deg(skin.frame({20, 0, 0}).along, {0, 1, 0}), 2);
}

TEST(TensionLines, OneWayEverywhereIsThatWay) {
  auto by_place = block(), by_direction = block();
  const Vec3 d = Vec3(0.6, 0.8, 0);
  TensionSpec s;
  for (int i = 0; i < 12; ++i) s.places.push_back({{7.0 * i - 35, 3.0 * (i % 5) - 6, 1}, i % 2 ? d : Vec3(-d)});
  by_place->tension = tension_lines_of(s, *by_place);
  by_direction->tension_direction = d;
  const Skin a(by_place), b(by_direction);
  for (double x = -28; x < 28; x += 3.1)
    EXPECT_LT(angle_deg(a.frame({x, 0.3 * x, 0}).along, b.frame({x, 0.3 * x, 0}).along), 1e-3);
}

// What is given upright on the skin tells no way; where two ways cross, none is in the mean. Then the body's counts.
TEST(TensionLines, WhereNoWayIsToldTheBodysCounts) {
  auto b = block();
  b->tension_direction = Vec3(0, 1, 0);
  TensionSpec s;
  s.places = {{{0, 0, 0}, Vec3::UnitZ()}};
  b->tension = tension_lines_of(s, *b);
  EXPECT_LT(angle_deg(Skin(b).frame({3, 4, 0}).along, {0, 1, 0}), 1e-3);
  s.places = {{{-10, 0, 0}, Vec3::UnitX()}, {{10, 0, 0}, Vec3::UnitY()}};
  b->tension = tension_lines_of(s, *b);
  EXPECT_LT(angle_deg(Skin(b).frame({-9, 0, 0}).along, {1, 0, 0}), 1e-3);
  EXPECT_LT(angle_deg(Skin(b).frame({9, 0, 0}).along, {0, 1, 0}), 1e-3);
  EXPECT_LT(angle_deg(Skin(b).frame({0, 0, 0}).along, {0, 1, 0}), 1e-3);
}

TEST(TensionLines, FilesAreReadStrictly) {
  const auto read = parse_tension_lines("# a cheek\n1 2 3  0 0 2\n\n-4, 5, 6, 1, 1, 0 # and here\n", "f");
  ASSERT_EQ(read.size(), 2u);
  EXPECT_EQ(read[0].along, Vec3(0, 0, 1));
  EXPECT_LT((read[1].at_mm - Vec3(-4, 5, 6)).norm(), 1e-12);
  const auto refused = [](const char* text, int line, const char* words) {
    try {
      parse_tension_lines(text, "f");
      ADD_FAILURE() << text;
    } catch (const InputError& e) {
      EXPECT_EQ(e.line(), line) << text;
      EXPECT_NE(std::string(e.what()).find(words), std::string::npos) << e.what();
    }
  };
  refused("", 0, "no place");
  refused("# nothing\n", 0, "no place");
  refused("1 2 3 0 0 1\n1 2 3 0 0\n", 2, "5 numbers");
  refused("1 2 3 0 0 1 7\n", 1, "more than six");
  refused("1 2 3 0 0 0\n", 1, "nowhere");
  refused("1 2 x 0 0 1\n", 1, "no number");
  refused("1e9 2 3 0 0 1\n", 1, "10 m");
}

}  // namespace test_tension_lines
}  // namespace limberg
