// What a grip does along a way that is given: Coulomb's law, whatever the way; and on a patient, against a plate.
#include <gtest/gtest.h>

#include "sim/contact/contact_friction.h"
#include "sim/fem/forces/contact_law.h"

namespace limberg {
namespace test_friction {

constexpr double kMu = 0.2;

Contact pressing(double deep_mm) {
  Contact c;
  c.normal = Vec3f::UnitZ(), c.k_N_per_mm = 0.5f, c.soft_mm = 0.04f, c.gap_mm = float(deep_mm);
  return c;
}

/// What friction does to a pair that is drawn from place to place, a step of the solver each; mN, on the place.
std::vector<Vec3> along(std::span<const Vec3> way, double deep_mm) {
  Contact c = pressing(deep_mm);
  Grip g;
  std::vector<Vec3> out;
  for (const Vec3& x : way) {
    follow_grip(g, x, {kMu, true}, c);
    const Vec3 drawn = Vec3(x.x(), x.y(), 0) - Vec3(double(c.stick_mm[0]), double(c.stick_mm[1]), 0);
    const fem::Push p = fem::friction_pull(drawn.norm(), 1000 * double(c.grip_N_per_mm), double(c.hold_mN));
    out.push_back(drawn.norm() > 0 ? Vec3(-p.force / drawn.norm() * drawn) : Vec3(0, 0, 0));
  }
  return out;
}

TEST(Friction, SlidesUnderItsShareOfThePushAgainstTheWay) {
  const double push = fem::contact_push(-0.1, 500, double(0.04f)).force;
  std::vector<Vec3> way;
  for (int i = 0; i <= 40; ++i) way.push_back({0.05 * i, 0, 0});      // there,
  for (int i = 0; i <= 20; ++i) way.push_back({2 - 0.05 * i, 0, 0});  // back,
  for (int i = 0; i <= 40; ++i) way.push_back({1, 0.05 * i, 0});      // and aside
  const std::vector<Vec3> f = along(way, 0.1);
  EXPECT_EQ(f[0].norm(), 0) << "where it met nothing draws";
  for (size_t i = 4; i <= 40; ++i) EXPECT_NEAR(f[i].x(), -kMu * push, 1e-4 * push);
  for (size_t i = 45; i <= 61; ++i) EXPECT_NEAR(f[i].x(), kMu * push, 1e-4 * push);
  EXPECT_NEAR(f.back().y(), -kMu * push, 1e-3 * push);
  EXPECT_LT(std::abs(f.back().x()), 0.05 * kMu * push) << "what held it along x goes where it slides aside";
  for (const Vec3& one : f) EXPECT_LT(one.norm(), kMu * push * 1.0001);
}

// Drawn to and fro by less than it gives it is a spring: it comes back to nothing, and loses no energy.
TEST(Friction, HoldsWhatIsDrawnALittle) {
  std::vector<Vec3> way;
  for (int k = 0; k < 3; ++k)
    for (int i = 0; i < 8; ++i) way.push_back({0.01 * std::sin(i * M_PI / 4), 0, 0});
  way.push_back({0, 0, 0});
  const std::vector<Vec3> f = along(way, 0.1);
  EXPECT_EQ(f.back().norm(), 0);
  EXPECT_NEAR(f[2].x(), -0.01 * 125, 1e-4);
  double work_uJ = 0;
  for (size_t i = 1; i < way.size(); ++i) work_uJ -= 0.5 * (f[i] + f[i - 1]).dot(way[i] - way[i - 1]);
  EXPECT_NEAR(work_uJ, 0, 1e-6);
}

// Round a square of 1 mm: what friction takes is mu times the push times the way, but for its give.
TEST(Friction, TakesItsShareOfTheWayAndGivesNoneBack) {
  std::vector<Vec3> way;
  const Vec3 corner[] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  for (int k = 0; k < 8; ++k)
    for (int i = 0; i < 50; ++i) way.push_back(corner[k % 4] + i / 50.0 * (corner[(k + 1) % 4] - corner[k % 4]));
  const std::vector<Vec3> f = along(way, 0.1);
  double work_uJ = 0;
  for (size_t i = 1; i < way.size(); ++i) work_uJ -= 0.5 * (f[i] + f[i - 1]).dot(way[i] - way[i - 1]);
  const double push = fem::contact_push(-0.1, 500, double(0.04f)).force;
  EXPECT_LT(work_uJ, kMu * push * 8);
  EXPECT_GT(work_uJ, 0.9 * kMu * push * 8);
}

TEST(Friction, WhatComesApartIsHeldNoMore) {
  Contact c = pressing(0.1);
  Grip g;
  follow_grip(g, {0, 0, 0}, {kMu, true}, c);
  follow_grip(g, {0.5, 0, 0}, {kMu, true}, c);
  EXPECT_GT(c.hold_mN, 0);
  EXPECT_TRUE(follow_grip(g, {0.6, 0, 0.2}, {kMu, true}, c));
  EXPECT_EQ(c.hold_mN, 0);
  EXPECT_FALSE(follow_grip(g, {0.7, 0, 0.2}, {kMu, true}, c)) << "and stays so";
  EXPECT_TRUE(follow_grip(g, {0.8, 0, 0}, {kMu, true}, c));
  EXPECT_NEAR(c.stick_mm.x(), 0.8f, 1e-6f) << "it holds on where it meets again";
}

// Within a step of the solver what it holds on to stands still, or there would be no energy; a small change of the push
// is none.
TEST(Friction, StandsStillWithinAStep) {
  Contact c = pressing(0.1);
  Grip g;
  follow_grip(g, {0, 0, 0}, {kMu, true}, c);
  EXPECT_FALSE(follow_grip(g, {0.5, 0, 0.0002}, {kMu, false}, c));
  EXPECT_EQ(c.stick_mm.x(), 0);
  EXPECT_TRUE(follow_grip(g, {0.5, 0, -0.01}, {kMu, false}, c));
  EXPECT_EQ(c.stick_mm.x(), 0);
  EXPECT_NEAR(c.hold_mN, kMu * fem::contact_push(-0.11, 500, double(0.04f)).force, 1e-2);
  EXPECT_TRUE(follow_grip(g, {0.5, 0, -0.01}, {kMu, true}, c));
  EXPECT_GT(c.stick_mm.x(), 0.3f);
}

// Another foot: the way to it is no way that was slid. Another plane: what is drawn out of it is let go.
TEST(Friction, IsCarriedToAnotherFoot) {
  HeldContact from, to;
  from.normal = Vec3::UnitZ(), from.grip = {Vec3(1, 2, 3), 7};
  carry_grip(from, Vec3(1.02, 2, 3.4), to, Vec3(-5, 4, 0.1));
  EXPECT_EQ(to.grip.push_mN, 7);
  EXPECT_LT((Vec3(-5, 4, 0.1) - to.grip.stick_mm - Vec3(0.02, 0, 0)).norm(), 1e-12);
}

}  // namespace test_friction
}  // namespace limberg
