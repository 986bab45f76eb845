// What a tool that presses is told of the patient: right against
// a lattice that resolves the tool, and nothing is changed by it.
#include <gtest/gtest.h>

#include <cmath>

#include "sim/base/error.h"
#include "sim/body/block.h"
#include "sim/patient/press.h"
#include "sim/patient/press_probe.h"
#include "sim/patient/soft_tissue.h"
#include "sim/patient/world.h"

namespace limberg {
namespace test_press {

constexpr double kTip_mm = 2;

WorldSpec block(double cell_mm, std::vector<Layer> layers, double prestretch = 1, double side_mm = 24) {
  BlockSpec b;
  b.size_mm = {side_mm, side_mm, 10};
  b.skin_cell_mm = std::min(1.5, cell_mm);
  for (Layer& l : layers) l.material.prestretch_along = l.material.prestretch_across = prestretch;
  b.layers = std::move(layers);
  WorldSpec spec;
  spec.body = std::make_shared<Body>(make_block(b));
  spec.cell_mm = cell_mm;
  return spec;
}

Layer layer(const char* name, double thickness_mm, double young_kPa) {
  Layer l{name, thickness_mm, {}};
  l.material.young_kPa = young_kPa, l.material.poisson = 0.45;
  return l;
}

/// A question about the skin at (x, y) of a block, which looks up.
PressQuestion at(const World& world, double x, double y, double depth_mm, double radius_mm = kTip_mm) {
  Snapshot s;
  world.fill(s);
  PressQuestion q;
  q.topology_version = s.topology_version;
  q.radius_mm = radius_mm, q.depth_mm = depth_mm;
  const SurfaceView& view = s.topology->view;
  double best = 1e9;
  for (size_t t = 0; t < view.tri.size(); ++t) {
    if (view.kind[t] != FaceKind::skin) continue;
    Vec3 middle = Vec3::Zero();
    for (int32_t v : view.tri[t]) middle += view.X_mm[size_t(v)] / 3;
    if (const double d = (middle - Vec3(x, y, middle.z())).norm(); d < best) best = d, q.triangle = int32_t(t);
  }
  q.bary = {1 / 3.0, 1 / 3.0, 1 / 3.0};
  return q;
}

double stiffness(World& world, double x, double y, double depth_mm = 0.5, double radius_mm = kTip_mm) {
  PressAnswer a;
  for (int i = 0; i < 12; ++i) a = world.press(at(world, x, y, depth_mm, radius_mm), 20);
  EXPECT_LE(a.residual, 1e-4);
  return a.stiffness_N_mm;
}

/// Where the lattice resolves the tip no springs are added: a reference that does not know the correction.
double resolved(std::vector<Layer> layers, double depth_mm = 0.5, double prestretch = 1) {
  InlineWorkers workers;
  World fine(block(0.75, std::move(layers), prestretch), workers);
  return stiffness(fine, 0, 0, depth_mm);
}

void settle(World& world) {
  StepSettings s;
  s.max_iterations = 20;
  for (int i = 0; i < 300 && world.step(s).residual > 1e-5; ++i) {
  }
}

TEST(Press, CompliancesOfLayersAddUp) {
  const std::vector<Layer> one{layer("skin", 10, 60)}, halves{layer("upper", 1.5, 60), layer("lower", 8.5, 60)},
      two{layer("skin", 1.5, 60), layer("fat", 8.5, 12)};
  const auto half_space = [](double radius_mm, double young_kPa) {
    return 1e3 * (1 - 0.45 * 0.45) / (2 * radius_mm * young_kPa);
  };
  for (const double a : {0.5, 2.0, 6.0}) {
    EXPECT_NEAR(compliance_mm_N(one, a), half_space(a, 60), 1e-12);
    EXPECT_NEAR(compliance_mm_N(halves, a), half_space(a, 60), 1e-12);
  }
  EXPECT_NEAR(compliance_mm_N(two, 0.05) / half_space(0.05, 60), 1, 1e-3);  // a needle meets skin only
  EXPECT_NEAR(compliance_mm_N(two, 200) / half_space(200, 12), 1, 0.01);    // a hand meets what is below
}

// A hand tells forces 7 to 10 % apart; twice that is what a
// coarse lattice may be off, wherever the place lies in its cell.
TEST(Press, ACoarseLatticeFeelsATipThatItCannotSee) {
  InlineWorkers workers;
  const std::vector<Layer> one{layer("skin", 10, 60)}, two{layer("skin", 2, 60), layer("fat", 8, 18)},
      thin{layer("skin", 1.5, 60), layer("fat", 8.5, 6)};
  for (const auto& layers : {one, two, thin}) {
    const double want = resolved(layers);
    for (const double cell : {3.0, 4.0}) {
      World coarse(block(cell, layers), workers);
      for (const double shift : {0.0, 0.25, 0.5}) {
        const double got = stiffness(coarse, shift * cell, shift * cell / 2);
        EXPECT_NEAR(got / want, 1, 0.2) << layers.size() << " layers, cells of " << cell << " mm, " << shift
                                        << " of one aside; " << want << " N/mm";
      }
    }
  }
}

TEST(Press, NothingOfThePatientChanges) {
  InlineWorkers workers;
  World asked(block(4, {layer("skin", 2, 60), layer("fat", 8, 18)}, 1.1), workers),
      other(asked.skin()->spec(), workers);
  for (World* w : {&asked, &other}) {
    ASSERT_TRUE(w->apply(Incise{{{-6, 0}, {6, 0}}, 3}).done);
    for (int i = 0; i < 20; ++i) {
      if (w == &asked) (void)w->press(at(*w, 1, 4, 0.1 * i), 5);
      w->step({});
      ASSERT_TRUE(w == &asked || w->full_hash() != 0);
    }
  }
  EXPECT_EQ(asked.full_hash(), other.full_hash());
}

TEST(Press, WhatIsCutBelowAndBesideIsFelt) {
  InlineWorkers workers;
  World world(block(2.5, {layer("skin", 3, 60), layer("fat", 7, 18)}, 1.05, 40), workers);
  settle(world);
  const double whole = stiffness(world, 0, 3);
  ASSERT_TRUE(world.apply(Incise{{{-10, 0}, {10, 0}}, 4}).done);
  settle(world);
  const double beside = stiffness(world, 0, 3);
  EXPECT_LT(beside, 0.97 * whole);
  Undermine under;
  under.outline = {{-9, 0}, {9, 0}, {9, 9}, {-9, 9}};
  under.depth_mm = 3.5;
  const Outcome o = world.apply(under);
  ASSERT_TRUE(o.done) << o.reason;
  settle(world);
  EXPECT_LT(stiffness(world, 0, 3), 0.8 * beside);  // nothing below holds it: contact is off in this scene
}

TEST(Press, AnOldSurfaceIsNotAnsweredForAndNonsenseIsRefused) {
  InlineWorkers workers;
  World world(block(4, {layer("skin", 10, 60)}), workers);
  const PressQuestion q = at(world, 0, 4, 1);
  EXPECT_GT(world.press(q).stiffness_N_mm, 0);
  ASSERT_TRUE(world.apply(Incise{{{-6, 0}, {6, 0}}, 3}).done);
  EXPECT_EQ(world.press(q).stiffness_N_mm, 0);
  PressQuestion bad = at(world, 0, 4, 1);
  EXPECT_GT(world.press(bad).stiffness_N_mm, 0);
  bad.triangle = 1 << 28;
  EXPECT_THROW(world.press(bad), InputError);
  bad = at(world, 0, 4, 1), bad.radius_mm = 0;
  EXPECT_THROW(world.press(bad), InputError);
  bad = at(world, 0, 4, 1), bad.normal.x() = std::nan("");
  EXPECT_THROW(world.press(bad), InputError);
}

// Softer deep than a linear law would say, or harder: the secant
// is that of the depth, and a stretched skin resists more.
TEST(Press, PrestretchIsFelt) {
  InlineWorkers workers;
  World slack(block(3, {layer("skin", 2, 60), layer("fat", 8, 6)}, 1, 30), workers),
      tense(block(3, {layer("skin", 2, 60), layer("fat", 8, 6)}, 1.3, 30), workers);
  settle(tense);
  EXPECT_GT(stiffness(tense, 0, 0, 2), 1.1 * stiffness(slack, 0, 0, 2));
}

}  // namespace test_press
}  // namespace limberg
