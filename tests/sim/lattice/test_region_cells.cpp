// What a region takes of the cells: as much as it holds, wherever it lies in them, in blocks and other bodies alike.
#include <gtest/gtest.h>

#include <numbers>

#include "sim/base/error.h"
#include "tests/sim/cutting/scenes.h"
#include "tests/sim/lattice/sheet_lattice.h"

namespace limberg::test {
namespace test_region_cells {

constexpr double kSize_mm = 60, kDeep_mm = 11.5;
constexpr double kLight = 1e-16, kHeavy = 1e-6;  // kg/mm^3: a mass is then a region's volume

Body body_with(std::vector<RegionSpec> regions, bool block) {
  Body b = slab(0);
  b.is_box = block;
  for (Layer& l : b.layers) l.material.density_kg_mm3 = kLight;
  for (RegionSpec& r : regions) b.regions.push_back(std::make_shared<Region>(std::move(r), b));
  return b;
}

RegionSpec of(const char* name, double young_kPa, double density = kHeavy) {
  RegionSpec r;
  r.name = name;
  r.material = {young_kPa, 0.45, density, 1, 1};
  return r;
}

RegionSpec ball(const Vec3& at, double radius_mm) {
  RegionSpec r = of("ball", 100);
  r.path_mm = {at}, r.radius_mm = radius_mm;
  return r;
}

RegionSpec plate(double x0, double x1, double y0, double y1, double from_mm, double to_mm) {
  RegionSpec r = of("plate", 500);
  r.outline_mm = {{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}};
  r.from_mm = from_mm, r.to_mm = to_mm;
  return r;
}

double mass(const FemModel& m) {
  double kg = 0;
  for (const double x : m.mass_kg) kg += x;
  return kg;
}

const Vec3 kShift(0.3, 0.6, 0.45);  // of the cells against the slab

TEST(RegionCells, ABallHasItsVolume) {
  for (const bool block : {true, false})
    for (const double cell : {5.0, 3.5, 2.5})
      for (const Vec3& at : {Vec3(0, 0, -5), Vec3(1.3, -2.2, -6.1), Vec3(-7.9, 3.4, -5.4)}) {
        SCOPED_TRACE(testing::Message() << (block ? "block " : "surface ") << cell << " mm, at " << at.transpose());
        const double r = 4, exact = 4 * std::numbers::pi / 3 * r * r * r;
        const SheetLattice l(body_with({ball(at, r)}, block), cell, block ? Vec3::Zero() : kShift);
        EXPECT_NEAR(mass(*l.m) / kHeavy, exact, 0.01 * exact);
      }
}

// A muscle at its origin: the held surface cuts off a cap of 2.5 mm.
TEST(RegionCells, ItEndsWhereTheBodyIsHeld) {
  for (const bool block : {true, false}) {
    SCOPED_TRACE(block ? "block" : "surface");
    const double r = 4, cap = 2.5, pi = std::numbers::pi;
    const double exact = 4 * pi / 3 * r * r * r - pi * cap * cap * (3 * r - cap) / 3;
    const SheetLattice l(body_with({ball({1.3, 2.1, -kDeep_mm + r - cap}, r)}, block), 3.5,
                         block ? Vec3::Zero() : kShift);
    EXPECT_NEAR(mass(*l.m) / kHeavy, exact, 0.01 * exact);
  }
}

TEST(RegionCells, APlateHasItsVolumeAndItsStiffness) {
  for (const bool block : {true, false}) {
    SCOPED_TRACE(block ? "block" : "surface");
    const double exact = 17.0 * 11 * 2.2;
    const SheetLattice l(body_with({plate(-8, 9, -4, 7, 3.1, 5.3)}, block), 3.5, block ? Vec3::Zero() : kShift),
        without(body_with({}, block), 3.5, block ? Vec3::Zero() : kShift);
    EXPECT_NEAR(mass(*l.m) / kHeavy, exact, 0.005 * exact);
    // mu/2 of an even shear, 500 kPa instead of the fat's 15; a surface loses .8 % at its rim, with and without
    const double more = exact * 0.5 * (500 - 15) / (2 * 1.45);
    EXPECT_NEAR(shear_energy(l) - shear_energy(without), more, 0.01 * more);
  }
}

TEST(RegionCells, APlateMayBeThinnerThanACell) {
  for (const bool block : {true, false})
    for (const double thick : {0.1, 0.5, 1.0}) {
      SCOPED_TRACE(testing::Message() << (block ? "block " : "surface ") << thick << " mm");
      const double exact = 17.0 * 11 * thick;
      const SheetLattice l(body_with({plate(-8, 9, -4, 7, 3.1, 3.1 + thick)}, block), 3.5,
                           block ? Vec3::Zero() : kShift);
      EXPECT_NEAR(mass(*l.m) / kHeavy, exact, 0.005 * exact);
    }
}

// Later regions lie over earlier ones.
TEST(RegionCells, WhatTwoHoldIsTheLater) {
  RegionSpec over = plate(-8, 8, -8, 8, 3, 5);
  over.name = "over", over.material.density_kg_mm3 = 3 * kHeavy;
  const SheetLattice l(body_with({plate(-12, 24, -12, 12, 2, 6), over}, true), 3.5);
  const double exact = 36.0 * 24 * 4 + 2 * 16.0 * 16 * 2;  // three instead of one where `over` is
  EXPECT_NEAR(mass(*l.m) / kHeavy, exact, 0.005 * exact);
}

// A region that has all of a body makes of it what a body of that tissue is.
TEST(RegionCells, AllOfABodyIsABodyOfThatTissue) {
  for (const bool block : {true, false}) {
    SCOPED_TRACE(block ? "block" : "surface");
    Sheet free;  // what holds a cell is looked at in another way where a region is
    free.cells = 10, free.below = SurfaceTag::free;
    free.top = [](double, double) { return 0.0; };
    free.bottom = [](double, double) { return -kDeep_mm; };
    RegionSpec all = plate(-40, 40, -40, 40, 0, 1000);
    all.material.prestretch_along = 1.1, all.material.density_kg_mm3 = kHeavy;
    Body one = layered(sheet_mesh(free), kSkin_mm);
    one.is_box = block;
    Body of_region = one;
    of_region.regions.push_back(std::make_shared<Region>(all, of_region));
    one.layers = {{"one", 100, all.material}};
    const Vec3 shift = block ? Vec3::Zero() : kShift;
    const SheetLattice a(std::move(of_region), 3.5, shift), b(std::move(one), 3.5, shift);
    ASSERT_EQ(a.m->cells.size(), b.m->cells.size());
    EXPECT_NEAR(shear_energy(a), shear_energy(b), (block ? 5e-5 : 5e-3) * shear_energy(b));
    for (size_t c = 0; block && c < a.m->cells.size(); ++c) {  // far from its skin a surface takes whole cells
      const Stencil &p = a.m->stencils[size_t(a.m->cells[c].stencil)],
                    &q = b.m->stencils[size_t(b.m->cells[c].stencil)];
      const double scale = q.K.cwiseAbs().maxCoeff();
      // Boxes that a layer's border crosses are integrated with a rule of degree two instead of four.
      ASSERT_LT((p.K - q.K).cwiseAbs().maxCoeff(), 1e-5 * scale) << c;
      ASSERT_NEAR(p.p0_kPa, q.p0_kPa, 1e-9 * q.p0_kPa);
      ASSERT_NEAR(p.lambda_kPa, q.lambda_kPa, 1e-9 * q.lambda_kPa);
    }
  }
}

// Fibres run along the path: they pull there and nowhere else.
TEST(RegionCells, ABundleIsStiffAlongItsPath) {
  RegionSpec muscle = of("muscle", 0);
  muscle.material.young_kPa = 14.5;
  muscle.material.law = {"muscle", {{"mu_kPa", {5}}, {"k1_kPa", {50}}, {"k2", {1}}}};
  const Vec3 along = Vec3(1, 1, 0).normalized();
  muscle.path_mm = {-15 * along - 5 * Vec3::UnitZ(), 15 * along - 5 * Vec3::UnitZ()}, muscle.radius_mm = 3;
  const SheetLattice l(body_with({muscle}, true), 3.5);
  size_t points = 0;
  double volume = 0;
  for (const HexCell& c : l.m->cells)
    for (const MaterialPoint& p : l.m->stencils[size_t(c.stencil)].points) {
      ++points, volume += double(c.scale) * p.volume_mm3;
      EXPECT_LT((p.M.col(0) - along).norm(), 1e-9);
      EXPECT_GT(p.M.col(2).z(), 0.999);
      const Mat3 longer = Vec3(1.1, 1, 1).asDiagonal();
      EXPECT_GT(l.m->laws[size_t(p.law)]->at(longer).energy_kPa, 0);
    }
  const double exact = std::numbers::pi * 9 * 30 + 4 * std::numbers::pi / 3 * 27;  // round ends
  EXPECT_GT(points, 50u);
  EXPECT_NEAR(volume, exact, 0.01 * exact);
}

// What a cut parts, the pieces have together.
TEST(RegionCells, ACutPartsARegion) {
  for (const bool block : {true, false}) {
    SCOPED_TRACE(block ? "block" : "surface");
    SheetLattice l(body_with({ball({1, 2, -5}, 4)}, block), 3.5, block ? Vec3::Zero() : kShift);
    const double before = mass(*l.m);
    ASSERT_TRUE(l.a.cut(sheet({-35, -35, -4.2}, {70, 0, 0.001}, {0, 70, 0}, 14, 14), 1).ok());
    const MaterialSurface surface = material_surface(l.a);
    const auto next = update_topology(*l.t, surface);
    const EarlierModel earlier{*l.t, *l.m};
    const auto m = assemble_fem(l.table, *next, &earlier, &surface);
    EXPECT_NEAR(mass(*m), before, 0.01 * before);  // shares of layers are rounded to 1/256
  }
}

TEST(RegionCells, SmallerCellsHaveTheSameRegion) {
  Grading fine;
  fine.zones.push_back({Vec3(-12, 0, 0), Vec3(12, 0, 0), -Vec3::UnitZ(), 10, 20, 2});
  for (const bool block : {true, false}) {
    SCOPED_TRACE(block ? "block" : "surface");
    const double exact = 4 * std::numbers::pi / 3 * 64;
    const SheetLattice l(body_with({ball({0, 0, -5}, 4)}, block), 5, Vec3::Zero(), fine);
    double volume = 0;  // masses are the undivided cells' (fem_assembly.h)
    for (const HexCell& c : l.m->cells) {
      const Stencil& s = l.m->stencils[size_t(c.stencil)];
      volume += double(c.scale) * s.volume_mm3 * s.density_kg_mm3 / kHeavy;
    }
    EXPECT_NEAR(volume, exact, 0.01 * exact);
  }
}

TEST(RegionCells, OneThatIsNowhereIsRefused) {
  const auto lattice = [](RegionSpec r) { SheetLattice l(body_with({std::move(r)}, true), 5); };
  EXPECT_THROW(lattice(ball({0, 0, 30}, 4)), InputError);
  EXPECT_THROW(lattice(plate(-4, 4, -4, 4, 20, 30)), InputError);
  EXPECT_NO_THROW(lattice(ball({0, 0, 3}, 4)));
}

}  // namespace test_region_cells
}  // namespace limberg::test
