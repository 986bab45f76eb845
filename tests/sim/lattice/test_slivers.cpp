// Slivers and debris: what blades that nearly coincide leave. No tissue gets lost, and the solver can hold what stays.
#include "sim/body/block.h"
#include "sim/body/skin.h"
#include "sim/fem/solver/elastic_solver.h"
#include "sim/lattice/fem_assembly.h"
#include "sim/lattice/grid_fit.h"
#include "tests/sim/lattice/lattice_scene.h"

namespace limberg::test {
namespace test_slivers {

constexpr double kDensity = 1.1e-6;  // kg/mm^3
constexpr double kDebris_mm3 = 1;    // as World sweeps
constexpr double kFloor = 1e-2;      // fem_assembly.cpp: stiffness of a sliver, as a share of its cell's

Body plain_block() {
  BlockSpec spec;
  spec.size_mm = {40, 30, 9};
  spec.skin_cell_mm = 2;
  Layer tissue{"tissue", 9, {}};
  tissue.material = {40, 0.45, kDensity, 1.12, 1.05};
  spec.layers = {tissue};
  return make_block(spec);
}

/// Through (0, 0), turned by `angle`, moved aside by `aside`, its foot at z = -depth.
Blade wall(const RestGrid& grid, double angle, double aside, double depth, double half_mm = 13) {
  const Vec2 way(std::cos(angle), std::sin(angle)), across(-way.y(), way.x());
  Blade b;
  for (int i = 0; i <= 18; ++i) {
    const Vec2 p = (2.0 * i / 18 - 1) * half_mm * way + aside * across;
    b.vertex.push_back(grid.to_grid({p.x(), p.y(), 1}));
    b.vertex.push_back(grid.to_grid({p.x(), p.y(), -depth}));
  }
  for (int32_t i = 0; i < 18; ++i) {
    b.tri.push_back({2 * i, 2 * i + 1, 2 * i + 3});
    b.tri.push_back({2 * i, 2 * i + 3, 2 * i + 2});
  }
  b.seed.assign(b.tri.size(), 1);
  return b;
}

double mass_kg(const FemModel& m) {
  double sum = 0;
  for (double v : m.mass_kg) sum += v;
  return sum;
}

struct Knife {
  std::shared_ptr<const Body> body = std::make_shared<const Body>(plain_block());
  Skin skin{body};
  LatticeGrid grid = fit_lattice(*body, 3.5);
  StencilTable table{skin, grid};
  Arrangement a{body->surface, body->grid};
  std::shared_ptr<const LatticeTopology> t = build_topology(grid, material_surface(a));
  std::shared_ptr<const FemModel> m = assemble_fem(table, *t);
  double whole_mm3 = a.volume_mm3(), swept_mm3 = 0;
  int swept = 0, slivers = 0;

  /// The cut and what it leaves loose, in two updates, as World follows them.
  void cut(const Blade& blade, uint64_t seed) {
    const CutResult r = a.cut(blade, seed);
    ASSERT_TRUE(r.ok()) << r.reason;
    follow();
    const DebrisResult d = a.sweep_debris(kDebris_mm3);
    swept += d.pieces, swept_mm3 += d.volume_mm3;
    if (d.pieces > 0) follow();
    ASSERT_EQ(a.check_all(), "");
    EXPECT_NEAR((a.volume_mm3() + swept_mm3) / whole_mm3, 1, 1e-12);
    // The lattice and the finite elements hold exactly what the surface encloses, whatever its share of a cell is.
    // (Doubles: some 2000 copies of 43 mm^3.)
    EXPECT_NEAR(t->volume_mm3 / a.volume_mm3(), 1, 1e-9);
    EXPECT_NEAR(mass_kg(*m) / (kDensity * a.volume_mm3()), 1, 1e-9);
    slivers = 0;
    for (size_t c = 0; c < t->cells.size(); ++c) {
      EXPECT_GT(t->cells[c].fraction, -1e-9);
      EXPECT_GE(m->cells[c].scale, float(kFloor));
      slivers += t->cells[c].fraction < 1e-3;
    }
    for (double v : m->mass_kg) EXPECT_GE(v, 0);
  }
  void follow() {
    const auto before = t;
    const auto model_before = m;
    t = update_topology(*before, material_surface(a));
    ASSERT_EQ(check_topology(*t), "");
    const EarlierModel earlier{*before, *model_before};
    m = assemble_fem(table, *t, &earlier);
    EXPECT_EQ(m->mass_kg, assemble_fem(table, *t)->mass_kg);
  }
};

/// Seven walls side by side, some hundredths of a millimetre apart and each deeper; or a star of six through one line.
void cut_all(Knife& k, bool star) {
  for (int i = 0; i < (star ? 6 : 7); ++i) {
    const double angle = star ? i * M_PI / 6 + 0.1 : 0.2 + 0.002 * i,
                 aside = star ? 0.004 * i : 0.03 * (i % 3) + 0.01 * i;
    ASSERT_NO_FATAL_FAILURE(k.cut(wall(k.body->grid, angle, aside, star ? 5 : 4 + 0.3 * i), uint64_t(i + 1)));
  }
}

TEST(Slivers, NoTissueIsLostAndWhatIsLooseIsBooked) {
  for (const bool star : {false, true}) {
    SCOPED_TRACE(star ? "star" : "side by side");
    Knife k;
    ASSERT_NO_FATAL_FAILURE(cut_all(k, star));
    EXPECT_GT(k.slivers, 0);  // else it shows nothing
    if (!star) {
      EXPECT_GT(k.swept, 0);
      EXPECT_GT(k.swept_mm3, 0);
    }
    EXPECT_EQ(k.a.pieces(), 1);
    EXPECT_EQ(k.a.find_debris(kDebris_mm3).pieces, 0);
    while (k.a.undo()) {
    }
    EXPECT_NEAR(k.a.volume_mm3() / k.whole_mm3, 1, 1e-12);
  }
}

TEST(Slivers, TheSolverHoldsThem) {
  InlineWorkers workers;
  const auto rest = [&](const Knife& k, std::vector<Vec3f>& u) {
    const auto solver = make_solver(workers);
    solver->set_model(k.m, {});
    StepSettings settings;
    settings.max_iterations = 20, settings.tolerance = 1e-4;
    StepReport r;
    for (int i = 0; i < 100 && !r.converged; ++i) r = solver->step(settings);
    EXPECT_TRUE(r.converged) << r.residual;
    u.assign(solver->displacement_mm().begin(), solver->displacement_mm().end());
  };
  Knife one;
  ASSERT_NO_FATAL_FAILURE(one.cut(wall(one.body->grid, 0.2, 0, 5), 1));
  std::vector<Vec3f> u;
  rest(one, u);
  float widest = 0;
  for (const Vec3f& v : u) widest = std::max(widest, v.norm());
  Knife many;
  ASSERT_NO_FATAL_FAILURE(cut_all(many, false));
  ASSERT_GT(many.slivers, 0);
  rest(many, u);
  // A sliver is in nobody's way: nothing is thrown farther than the banks of a plain cut gape, twice for the greater
  // depth and for the strips that hang free between the walls.
  for (size_t n = 0; n < u.size(); ++n) {
    ASSERT_TRUE(u[n].allFinite());
    EXPECT_LT(u[n].norm(), 2 * widest) << n;
  }
}

}  // namespace test_slivers
}  // namespace limberg::test
