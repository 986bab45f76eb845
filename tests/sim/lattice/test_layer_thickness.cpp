// How thick a layer acts, and where a body ends, against volumes and moves that are known without a lattice.
#include <gtest/gtest.h>

#include "sim/geometry/bvh.h"
#include "tests/sim/lattice/sheet_lattice.h"

namespace limberg::test {
namespace test_layer_thickness {

/// Volume of what is less than `depth_mm` below the skin, by a regular sample of step `step_mm` and distances to the
/// triangles: nothing of the lattice is in it.
template <class Inside>
double volume_above(const Body& b, double depth_mm, double step_mm, Inside&& inside) {
  const Skin skin(std::make_shared<Body>(b));
  size_t hits = 0;
  Bvh::Closest near;
  for (double z = b.box_min_mm.z() + step_mm / 2; z < b.box_max_mm.z(); z += step_mm)
    for (double y = b.box_min_mm.y() + step_mm / 2; y < b.box_max_mm.y(); y += step_mm)
      for (double x = b.box_min_mm.x() + step_mm / 2; x < b.box_max_mm.x(); x += step_mm)
        if (inside(x, y, z) && skin.depth_mm({x, y, z}, near) < depth_mm) ++hits;
  return double(hits) * step_mm * step_mm * step_mm;
}

constexpr double kSizes_mm[] = {5, 4, 3.5, 3, 2};

TEST(LayerThickness, OfABall) {
  const Body b = layered(ball_mesh(30, 5, {0.3, 0.7, -0.4}), kSkin_mm, true);
  const double exact = skin_of_ball_mm3(b.surface, kSkin_mm);
  for (double h : kSizes_mm) {
    const SheetLattice l(b, h);
    EXPECT_NEAR(skin_mass(l), exact, 0.02 * exact) << h;
  }
}

// In skin alone and in its stiffness within its plane.
TEST(LayerThickness, OfAFlatSlabWhereverItsBordersFall) {
  Sheet s;
  s.top = [](double, double) { return 0.0; };
  s.bottom = [](double, double) { return -11.5; };
  s.below = SurfaceTag::free;
  s.cells = 10;
  const Body b = layered(sheet_mesh(s), kSkin_mm, true);
  const double exact = 60 * 60 * kSkin_mm;
  const double mu = b.layers[0].material.mu_kPa(), fat = b.layers[1].material.mu_kPa();
  for (double h : kSizes_mm)
    for (double off : {0.0, 0.2, 0.4, 0.6, 0.8}) {
      const SheetLattice l(b, h, {0.5 * off, 0.3 * off, off});
      const double stiff = (2 * shear_energy(l) - 3600 * 11.5 * fat) / (mu - fat);
      EXPECT_NEAR(skin_mass(l), exact, 0.02 * exact) << h;
      EXPECT_NEAR(stiff, exact, 0.02 * exact) << h;
    }
}

/// Within 2 % of the volume by a sample of that step.
void expect_thickness(const Sheet& s, double step_mm) {
  const Body b = layered(sheet_mesh(s), kSkin_mm, true);
  const Bvh surface(b.surface.X_mm, b.surface.tri);
  const double exact = volume_above(b, kSkin_mm, step_mm, [&](double x, double y, double z) {
    return surface.line({x, y, z}, Vec3(0.0123, 0.0071, 1).normalized(), 0, 100).size() % 2 == 1;
  });
  for (double h : kSizes_mm) {
    const SheetLattice l(b, h);
    EXPECT_NEAR(skin_mass(l), exact, 0.02 * exact) << h;
  }
}

TEST(LayerThickness, OfASaddle) {
  Sheet s;
  s.top = [](double x, double y) { return (x * x - y * y) / 80; };
  s.bottom = [&](double x, double y) { return s.top(x, y) - 12; };
  expect_thickness(s, 0.31);
}

// Two skins 4 mm apart with a millimetre between them, bent like an auricle.
TEST(LayerThickness, OfAFoldThinnerThanACell) {
  Sheet s;
  s.size_mm = 40, s.cells = 40;
  s.top = [](double x, double y) { return 0.013 * x * x + 2 * std::sin(0.15 * y); };
  s.bottom = [&](double x, double y) { return s.top(x, y) - 4.2; };
  s.below = SurfaceTag::skin;
  expect_thickness(s, 0.2017);
}

// An even shear that vanishes where the body ends is in the lattice, with its energy, wherever its planes lie.
TEST(Held, ShearVanishesWhereTheBodyEnds) {
  Body b = slab(0);
  b.layers.resize(1);
  const double mu = b.layers[0].material.mu_kPa(), slope = 0.01, exact = 0.5 * mu * slope * slope * 3600 * 11.5;
  for (double h : {5.0, 3.5})
    for (double off : {0.0, 0.2, 0.4, 0.6, 0.8}) {
      const SheetLattice l(b, h, {0.5, 0.5, off});
      std::vector<Vec3> u;
      for (size_t n = 0; n < l.m->X_mm.size(); ++n)
        u.push_back(l.m->fixed[n] ? Vec3(0, 0, 0) : Vec3(slope * (l.m->X_mm[n].z() + 11.5), 0, 0));
      EXPECT_NEAR(ReferenceElasticity(*l.m, {}).energy(u), exact, 0.05 * exact) << h << ' ' << off;
    }
}

// Skin on fat, held below, under loads so small that all is linear; in mm per N along and per half a newton upwards. A
// patch is as wide as a cell or two, and as stiff as it lies among them: so all of these have its middle on a node.
// CalculiX 2.20 (20-node hexahedra on a quarter, graded towards the patch, refined to 55,725 nodes; 2026-11-24) has
// 1.820 and 1.769; block and OBJ are measured against each other, and along against that too (what is off upwards is
// the bending of 1.5 mm of skin in cells of 5 mm: docs/validation.md).
TEST(Held, SlabMovesAsTheSameBlockWhereverItsBordersFall) {
  const Vec3 pull(0.02, 0, 0), lift(0, 0, 0.01);
  for (double h : {5.0, 3.5}) {
    const SheetLattice block(as_block(slab(0)), h);
    const double bx = 50 * patch_move(block, pull).x(), bz = 50 * patch_move(block, lift).z();
    for (double off : {0.0, 0.2, 0.4, 0.6, 0.8}) {
      const SheetLattice general(slab(0), h, {0.5, 0.5, off});
      const double gx = 50 * patch_move(general, pull).x(), gz = 50 * patch_move(general, lift).z();
      EXPECT_NEAR(gx, bx, 0.1 * bx) << h << ' ' << off;
      EXPECT_NEAR(gx, 1.820, 0.1 * 1.820) << h << ' ' << off;
      EXPECT_NEAR(gz, bz, 0.2 * bz) << h << ' ' << off;
    }
  }
}

// A body under no load and without prestretch rests as it lies, however its surface and its layers cut the cells: the
// largest force that its cells exert, beside what one of them would under its rest pressure alone.
TEST(Held, BodyUnderNoLoadRests) {
  Sheet s;
  s.top = [](double x, double y) { return 6 * std::cos(0.08 * x) * std::cos(0.06 * y + 0.3); };
  s.bottom = [&](double x, double y) { return s.top(x, y) - 7 - 0.1 * x; };
  for (const TriMesh& surface : {sheet_mesh(s), ball_mesh(20, 4, {0.3, 0.1, 0.2})})
    for (double h : {5.0, 3.5}) {
      const SheetLattice l(layered(surface, kSkin_mm), h, {0.5, 0.3, 0.7});
      EXPECT_LT(force_at_rest(l, h), 1e-9) << h;
    }
}

}  // namespace test_layer_thickness
}  // namespace limberg::test
