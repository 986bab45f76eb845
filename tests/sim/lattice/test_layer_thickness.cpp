// How thick a layer acts, and where a body ends, against volumes and moves that are known without a lattice.
#include "sim/cutting/arrangement/arrangement.h"
#include "sim/geometry/bvh.h"
#include "sim/lattice/embedding.h"
#include "sim/lattice/fem_assembly.h"
#include "sim/lattice/grid_fit.h"
#include "sim/testing/reference_newton.h"
#include "tests/sim/lattice/lattice_scene.h"
#include "tests/sim/lattice/sheet_bodies.h"

namespace limberg::test {
namespace test_layer_thickness {

/// `shift` (0 to 1, of a cell): how much higher its planes lie than where they were fitted.
LatticeGrid shifted(LatticeGrid g, const Vec3& shift) {
  if (shift == Vec3::Zero()) return g;
  const auto by = [&](int a) { return 2 * int32_t(std::lround((shift[a] - 1) * g.pitch[a] / 2)); };
  g.origin = {g.origin.x + by(0), g.origin.y + by(1), g.origin.z + by(2)};
  g.count = {g.count.x + 1, g.count.y + 1, g.count.z + 1};
  return g;
}

struct Lattice {
  std::shared_ptr<const Body> body;
  Skin skin;
  LatticeGrid grid;
  StencilTable table;
  Arrangement a;
  std::shared_ptr<const LatticeTopology> t;
  std::shared_ptr<const FemModel> m;
  Lattice(Body b, double h, const Vec3& shift = Vec3::Zero())
      : body(std::make_shared<Body>(std::move(b))),
        skin(body),
        grid(shifted(fit_lattice(*body, h), shift)),
        table(skin, grid),
        a(body->surface, body->grid),
        t(build_topology(grid, material_surface(a))),
        m(assemble_fem(table, *t)) {}
};

/// Volume (mm^3) that acts as skin: the mass, where fat weighs nothing.
double skin_mass(const Lattice& l) {
  double kg = 0;
  for (double m : l.m->mass_kg) kg += m;
  return kg / 1e-6;
}

/// The same from the stiffness: energy of an even shear in the plane of x and y, of which fat's share is known. uJ.
double shear_energy(const Lattice& l) {
  double e = 0;
  for (const HexCell& c : l.m->cells) {
    const Stencil& s = l.m->stencils[size_t(c.stencil)];
    Eigen::Matrix<double, 8, 1> u;
    for (int n = 0; n < 8; ++n) u[n] = (n >> 1 & 1) ? l.m->cell_mm.y() : 0;
    e += 0.5 * double(c.scale) * u.dot(s.K * u);
  }
  return e;
}

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
constexpr double kSkin_mm = 1.5;

TEST(LayerThickness, OfABall) {
  const Body b = layered(ball_mesh(30, 5, {0.3, 0.7, -0.4}), kSkin_mm, true);
  double volume = 0;  // of the polyhedron
  for (const Tri& t : b.surface.tri) {
    const Vec3 o = Vec3(0.3, 0.7, -0.4), p = b.surface.X_mm[size_t(t[0])] - o, q = b.surface.X_mm[size_t(t[1])] - o,
               r = b.surface.X_mm[size_t(t[2])] - o;
    volume += p.dot(q.cross(r)) / 6;
  }
  const double R = std::cbrt(volume / (4 * M_PI / 3)), in = R - kSkin_mm;
  const double exact = 4 * M_PI / 3 * (R * R * R - in * in * in);
  for (double h : kSizes_mm) {
    const Lattice l(b, h);
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
      const Lattice l(b, h, {0.5 * off, 0.3 * off, off});
      const double stiff = (2 * shear_energy(l) - 3600 * 11.5 * fat) / (mu - fat);
      EXPECT_NEAR(skin_mass(l), exact, 0.02 * exact) << h;
      EXPECT_NEAR(stiff, exact, 0.02 * exact) << h;
    }
}

TEST(LayerThickness, OfASaddle) {
  Sheet s;
  s.top = [](double x, double y) { return (x * x - y * y) / 80; };
  s.bottom = [&](double x, double y) { return s.top(x, y) - 12; };
  const Body b = layered(sheet_mesh(s), kSkin_mm, true);
  const Bvh surface(b.surface.X_mm, b.surface.tri);
  const double exact = volume_above(b, kSkin_mm, 0.31, [&](double x, double y, double z) {
    return surface.line({x, y, z}, Vec3(0.0123, 0.0071, 1).normalized(), 0, 100).size() % 2 == 1;
  });
  for (double h : kSizes_mm) {
    const Lattice l(b, h);
    EXPECT_NEAR(skin_mass(l), exact, 0.02 * exact) << h;
  }
}

// Two skins 4 mm apart with a millimetre between them, bent like an auricle.
TEST(LayerThickness, OfAFoldThinnerThanACell) {
  Sheet s;
  s.size_mm = 40, s.cells = 40;
  s.top = [](double x, double y) { return 0.013 * x * x + 2 * std::sin(0.15 * y); };
  s.bottom = [&](double x, double y) { return s.top(x, y) - 4.2; };
  s.below = SurfaceTag::skin;
  const Body b = layered(sheet_mesh(s), kSkin_mm, true);
  const Bvh surface(b.surface.X_mm, b.surface.tri);
  const double exact = volume_above(b, kSkin_mm, 0.2017, [&](double x, double y, double z) {
    return surface.line({x, y, z}, Vec3(0.0123, 0.0071, 1).normalized(), 0, 100).size() % 2 == 1;
  });
  for (double h : kSizes_mm) {
    const Lattice l(b, h);
    EXPECT_NEAR(skin_mass(l), exact, 0.02 * exact) << h;
  }
}

/// Mean move (mm) of a square of 6 x 6 mm in the middle of the skin under a force of `force_N` spread evenly on it.
Vec3 patch_move(const Lattice& l, const Vec3& force_N) {
  const double top = l.body->box_max_mm.z();
  std::vector<EmbeddedPoint> held;
  for (int j = 0; j < 12; ++j)
    for (int i = 0; i < 12; ++i) {
      const Vec3 X(-2.75 + 0.5 * i, -2.75 + 0.5 * j, top - 1e-6);
      const int32_t cell = cell_of(*l.t, X);
      held.push_back(embed_in_copy(*l.t, l.t->copy(cell, 0), X));
    }
  // A weak spring whose far end is so far away that its pull hardly changes.
  Spring s;
  s.a = held[0], s.a_wide = held, s.to_world = true;
  s.k_N_per_mm = 1e-5;
  Vec3 at = Vec3::Zero();
  const auto middle = [&](std::span<const Vec3> u) {
    Vec3 m = Vec3::Zero();
    for (const EmbeddedPoint& p : held)
      for (size_t k = 0; k < 8; ++k)
        m += double(p.w[k]) * (l.m->X_mm[size_t(p.node[k])] + (u.empty() ? Vec3(0, 0, 0) : u[size_t(p.node[k])]));
    return Vec3(m / double(held.size()));
  };
  at = middle({});
  s.target_mm = at + force_N / s.k_N_per_mm;
  const std::vector<Spring> springs{s};
  ReferenceElasticity e(*l.m, springs);
  std::vector<Vec3> start(l.m->X_mm.size(), Vec3::Zero());
  ReferenceElasticity::Settings settings;
  settings.tolerance = 1e-9;
  const auto r = e.solve(start, settings);
  EXPECT_TRUE(r.converged) << r.residual;
  return middle(r.u) - at;
}

Body slab(double off, double fat_mm = 10) {
  Sheet s;
  s.cells = 10;
  s.top = [=](double, double) { return off; };
  s.bottom = [=](double, double) { return off - kSkin_mm - fat_mm; };
  return layered(sheet_mesh(s), kSkin_mm);
}

Body as_block(Body b) {
  b.is_box = true;
  return b;
}

// An even shear that vanishes where the body ends is in the lattice, with its energy, wherever its planes lie.
TEST(Held, ShearVanishesWhereTheBodyEnds) {
  Body b = slab(0);
  b.layers.resize(1);
  const double mu = b.layers[0].material.mu_kPa(), slope = 0.01, exact = 0.5 * mu * slope * slope * 3600 * 11.5;
  for (double h : {5.0, 3.5})
    for (double off : {0.0, 0.2, 0.4, 0.6, 0.8}) {
      const Lattice l(b, h, {0.5, 0.5, off});
      std::vector<Vec3> u;
      for (size_t n = 0; n < l.m->X_mm.size(); ++n)
        u.push_back(l.m->fixed[n] ? Vec3(0, 0, 0) : Vec3(slope * (l.m->X_mm[n].z() + 11.5), 0, 0));
      EXPECT_NEAR(ReferenceElasticity(*l.m, {}).energy(u), exact, 0.05 * exact) << h << ' ' << off;
    }
}

// Skin on fat, held below, under loads so small that all is linear; in mm per N along and per half a newton upwards. A
// patch is as wide as a cell or two, and as stiff as it lies among them: so all of these have its middle on a node.
// CalculiX 2.20 (20-node hexahedra, 12 x 12 x 11 on a quarter, graded towards the patch; 2026-11-24) has 1.815 and
// 1.768; block and OBJ are measured against each other, and along against that too (what is off upwards is the
// bending of 1.5 mm of skin in cells of 5 mm: docs/validation.md).
TEST(Held, SlabMovesAsTheSameBlockWhereverItsBordersFall) {
  const Vec3 pull(0.02, 0, 0), lift(0, 0, 0.01);
  for (double h : {5.0, 3.5}) {
    const Lattice block(as_block(slab(0)), h);
    const double bx = 50 * patch_move(block, pull).x(), bz = 50 * patch_move(block, lift).z();
    for (double off : {0.0, 0.2, 0.4, 0.6, 0.8}) {
      const Lattice general(slab(0), h, {0.5, 0.5, off});
      const double gx = 50 * patch_move(general, pull).x(), gz = 50 * patch_move(general, lift).z();
      EXPECT_NEAR(gx, bx, 0.1 * bx) << h << ' ' << off;
      EXPECT_NEAR(gx, 1.815, 0.1 * 1.815) << h << ' ' << off;
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
      const Lattice l(layered(surface, kSkin_mm), h, {0.5, 0.3, 0.7});
      double scale = 0, force = 0;
      for (const Stencil& k : l.m->stencils) scale = std::max(scale, k.p0_kPa * k.volume_mm3 / h);
      const std::vector<Vec3> u(l.m->X_mm.size(), Vec3::Zero());
      std::vector<Vec3> f;
      ReferenceElasticity(*l.m, {}).gradient(u, f);
      for (size_t n = 0; n < f.size(); ++n)
        if (!l.m->fixed[n]) force = std::max(force, f[n].norm());
      EXPECT_LT(force, 1e-9 * scale) << h;
    }
}

}  // namespace test_layer_thickness
}  // namespace limberg::test
