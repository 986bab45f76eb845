// A graded lattice: which cells are divided, that cuts go through it as through any other, and what its elements do.
#include <functional>
#include <limits>
#include <map>
#include <set>
#include <tuple>

#include "sim/base/error.h"
#include "sim/body/block.h"
#include "sim/fem/model/hanging_nodes.h"
#include "sim/lattice/fem_assembly.h"
#include "sim/lattice/grid_fit.h"
#include "sim/testing/reference_newton.h"
#include "tests/sim/lattice/lattice_scene.h"

namespace limberg::test {
namespace test_grading {

constexpr double kNoLimit = std::numeric_limits<double>::infinity();

GradedZone zone(const Vec3& from, const Vec3& to, double radius_mm, int level, double depth_mm = kNoLimit) {
  GradedZone z;
  z.from_mm = from, z.to_mm = to, z.radius_mm = radius_mm, z.level = level, z.depth_mm = depth_mm;
  return z;
}

LatticeScene graded(const Grading& grading, int front_levels = 0) {
  return {wavy_slab(60, 12, 24, 0.8), grid_over(60, 12, 4.0), front_levels, grading};
}

/// Level and place of every cell that holds material.
std::set<std::tuple<int, int32_t, int32_t, int32_t>> leaves(const LatticeTopology& t) {
  std::set<std::tuple<int, int32_t, int32_t, int32_t>> out;
  for (const CellCopy& c : t.cells) {
    const CellPlace p = t.tree.place(t.grid, c.cell);
    out.insert({p.level, p.at.x, p.at.y, p.at.z});
  }
  return out;
}

double distance(const Vec3& low, const Vec3& high, const Vec3& X) {
  return (X - X.cwiseMax(low).cwiseMin(high)).norm();
}

std::array<Vec3, 2> box_of(const LatticeTopology& t, int32_t cell) {
  const CellPlace p = t.tree.place(t.grid, cell);
  const LatticeGrid g = t.grid.at_level(p.level);
  return {g.node_mm(p.at), g.node_mm({p.at.x + 1, p.at.y + 1, p.at.z + 1})};
}

TEST(Grading, ZonesAreAsFineAsTheySay) {
  Grading grading;
  const Vec3 at(-14, 9, 0), from(6, -12, 0), to(20, -3, 0);
  grading.zones = {zone(at, at, 5, 3, 3), zone(from, to, 7, 1)};
  const LatticeScene s = graded(grading);
  size_t at_level[kLevels + 1] = {}, full_parts = 0;
  for (const CellCopy& c : s.t->cells) {
    const int level = s.t->tree.level(c.cell);
    ++at_level[level];
    full_parts += level > 0 && !s.t->components[size_t(c.cell)];
    const auto [low, high] = box_of(*s.t, c.cell);
    const double h = (high - low).x();
    // What is left of it, but for a sixteenth at each side.
    const Vec3 off = Vec3::Constant(h / 16), l = low + off, u = high - off;
    if (distance(l, u, at) < 4.99 && u.z() > -2.99) {
      EXPECT_EQ(level, 3) << low.transpose();
    }
    double near = 1e9;
    for (int i = 0; i <= 200; ++i) near = std::min(near, distance(l, u, from + i / 200.0 * (to - from)));
    if (near < 6.99) {
      EXPECT_GE(level, 1) << low.transpose();
    }
    // Beyond a zone there is what the grading needs: one cell of each size on the way, be it across a corner.
    if (distance(low, high, at) > 5.01 + std::sqrt(3) * (1 + 2)) {
      EXPECT_LE(level, 1) << low.transpose();
    }
    if (near > 7.01 + std::sqrt(3) * 4 && distance(low, high, at) > 5.01 + std::sqrt(3) * (1 + 2 + 4)) {
      EXPECT_EQ(level, 0) << low.transpose();
    }
  }
  EXPECT_GT(at_level[0], 500u);
  EXPECT_GT(at_level[1], 300u);
  EXPECT_GT(at_level[2], 100u);
  EXPECT_GT(at_level[3], 500u);
  EXPECT_GT(full_parts, 500u);
}

TEST(Grading, ARowThatEndsOnAPlaneIsNotLeftToRounding) {
  Grading grading;
  grading.zones = {zone({0, 0, 0}, {0, 0, 0}, 100, 2, 4)};
  for (const double off : {-1e-7, 0.0, 1e-7}) {
    EXPECT_EQ(zone_level(grading, {-2, -2, -4 + off}, {2, 2, off}), 2) << off;
    EXPECT_EQ(zone_level(grading, {-2, -2, -8 + off}, {2, 2, -4 + off}), 0) << off;
  }
}

// A wound takes its fine cells along as it grows, and leaves the rest alone.
TEST(Grading, FollowsTheWound) {
  for (const int level : {1, 2, 3}) {
    Grading grading;
    grading.wound_level = level;
    LatticeScene s = graded(grading);
    EXPECT_TRUE(s.t->tree.division.empty());
    ASSERT_TRUE(s.cut(strip({{-14.3, 0.3}, {1.2, 0.9}}, 3, -6)));
    const size_t first = s.t->tree.division.size();
    ASSERT_TRUE(s.cut(strip({{1.2, 0.9}, {12.2, 6.4}}, 3, -4)));
    EXPECT_GT(s.t->tree.division.size(), first);
    const MaterialSurface surface = material_surface(s.a);
    size_t wounded = 0, beside = 0, far = 0;
    for (const CellCopy& c : s.t->cells) {
      const auto& held = s.t->components[size_t(c.cell)];
      const CellPlace p = s.t->tree.place(s.t->grid, c.cell);
      const bool cut_through = held && std::any_of(held->face.begin(), held->face.end(), [&](int32_t f) {
                                 return surface.orig[size_t(surface.faces[size_t(f)].orig)].op > 0;
                               });
      if (cut_through) {
        ++wounded;
        EXPECT_EQ(p.level, level);
        for (int k = 0; k < 27; ++k) {
          const Int3 n{p.at.x + k % 3 - 1, p.at.y + k / 3 % 3 - 1, p.at.z + k / 9 - 1};
          const int32_t other = s.t->tree.find(s.t->grid, p.level, n);
          if (s.t->copies_of(other) == 0) continue;
          ++beside;
          EXPECT_EQ(s.t->tree.level(other), level) << "touches a cell that was cut";
        }
      }
      // Both strokes lie within these bounds; 4 + 2 + ... mm of smaller cells around, and the margin.
      const auto [low, high] = box_of(*s.t, c.cell);
      if (high.x() < -14.3 - 9 || low.x() > 12.2 + 9 || high.y() < 0.3 - 9 || low.y() > 6.4 + 9) {
        EXPECT_EQ(p.level, 0);
        ++far;
      }
    }
    EXPECT_GT(wounded, 20u);
    EXPECT_GT(beside, 100u);
    EXPECT_GT(far, 200u);
  }
}

TEST(Grading, AnUpdateThatDividesNothingLeavesItForLater) {
  Grading grading;
  grading.wound_level = 1;
  LatticeScene s = graded(grading);
  s.divide = Divide::nothing;
  ASSERT_TRUE(s.cut(strip({{-14.3, 0.3}, {11.2, 1.1}}, 3, -6)));
  ASSERT_TRUE(s.cut(sheet({-2, 0.1, -5}, {18, 0.1, 0}, {0.1, 13, 0.1}, 9, 7)));
  EXPECT_TRUE(s.t->tree.division.empty());
  s.divide = Divide::fronts;
  ASSERT_TRUE(s.cut(strip({{-20, -15}, {-10, -14}}, 3, -4)));
  EXPECT_FALSE(s.t->tree.division.empty());
}

// Updates divide the cells that a build from nothing divides.
TEST(Grading, StepByStepIsFromNothing) {
  Grading grading;
  grading.zones = {zone({-14, 9, 0}, {-14, 9, 0}, 5, 2), zone({6, -12, 0}, {20, -3, 0}, 6, 1)};
  grading.wound_level = 2;
  LatticeScene s = graded(grading);
  const std::vector<Blade> blades{strip({{-14.3, 0.3}, {11.2, 1.1}}, 3, -6), strip({{1, -13}, {2, 17}}, 3, -4),
                                  sheet({-2, 0.1, -5}, {18, 0.1, 0}, {0.1, 13, 0.1}, 9, 7),
                                  strip({{-20, 6}, {-9, 12}}, 3, -8)};
  for (const Blade& b : blades) {
    ASSERT_TRUE(s.cut(b));
    const auto fresh = build_topology(s.g, material_surface(s.a), 0, grading);
    EXPECT_EQ(check_topology(*fresh), "");
    EXPECT_TRUE(leaves(*fresh) == leaves(*s.t));
    EXPECT_EQ(fresh->pieces, s.t->pieces);
    EXPECT_EQ(fresh->nodes.size(), s.t->nodes.size());
    EXPECT_EQ(fresh->hanging.size(), s.t->hanging.size());
  }
}

const std::vector<Vec2> kPlug{{10, 0}, {0, 6}, {-10, 0}, {0, -6}};

TEST(Grading, PiecesAreThoseOfTheUniformLattice) {
  Grading grading;
  grading.zones = {zone({0, 0, 0}, {0, 0, 0}, 9, 2, 5)};
  grading.wound_level = 1;
  for (const int fronts : {0, kLevels}) {
    LatticeScene s = graded(grading, fronts), plain = graded({}, fronts);
    const std::vector<std::function<bool(LatticeScene&)>> steps{
        [](LatticeScene& x) { return x.cut(open_box(kPlug, 3, -6)); },
        [](LatticeScene& x) { return x.excise_smallest(); },
        [](LatticeScene& x) {
          return x.cut(strip({{0.1, 4}, {4, 16}, {14, 14}}, 3, -6));
        },
        [](LatticeScene& x) {
          return x.cut(sheet({-2, 4, -5}, {18, 0.1, 0}, {0.1, 13, 0.1}, 9, 7));
        },
        [](LatticeScene& x) {
          return x.cut(strip({{-70, -20}, {70, -21}}, 3, -14));
        },
    };
    for (const auto& step : steps) {
      ASSERT_TRUE(step(s) && step(plain));
      EXPECT_EQ(s.t->pieces, plain.t->pieces);
      EXPECT_NEAR(s.t->volume_mm3, plain.t->volume_mm3, 1e-9 * plain.t->volume_mm3);
    }
    EXPECT_EQ(s.t->pieces, 2);
  }
}

TEST(Grading, UndoGoesOnFromTheOldVersion) {
  Grading grading;
  grading.zones = {zone({8, 3, 0}, {8, 3, 0}, 6, 1)};
  grading.wound_level = 2;
  LatticeScene s = graded(grading, kLevels);
  const auto first = s.t;
  ASSERT_TRUE(s.cut(strip({{-20, 0.3}, {20, 1.1}}, 3, -6)));
  const uint64_t hash = s.t->hash();
  ASSERT_TRUE(s.a.undo());
  s.t = first, s.seed = 1;
  ASSERT_TRUE(s.cut(strip({{-20, 0.3}, {20, 1.1}}, 3, -6)));
  EXPECT_EQ(s.t->hash(), hash);
}

TEST(Grading, ThatIsNoneIsRefused) {
  const LatticeScene plain = graded({});
  const auto refused = [&](const Grading& grading, const LatticeGrid& grid) {
    EXPECT_THROW(build_topology(grid, material_surface(plain.a), 0, grading), InputError);
  };
  Grading grading;
  grading.wound_level = kLevels + 1;
  refused(grading, plain.g);
  grading.wound_level = 0;
  for (const GradedZone& bad : {zone({0, 0, 0}, {0, 0, 0}, 0, 1), zone({0, 0, 0}, {0, 0, NAN}, 3, 1),
                                zone({0, 0, 0}, {0, 0, 0}, 3, 4), zone({0, 0, 0}, {0, 0, 0}, 3, 1, 0)}) {
    grading.zones = {bad};
    refused(grading, plain.g);
  }
  LatticeGrid odd = plain.g;
  odd.pitch.x += 2;
  grading.zones = {zone({0, 0, 0}, {0, 0, 0}, 3, 1)};
  refused(grading, odd);
}

// --- Elements -----------------------------------------------------------------------------------------------------

struct BlockLattice {
  std::shared_ptr<const Body> body;
  Skin skin;
  StencilTable table;
  Arrangement a;
  std::shared_ptr<const LatticeTopology> t;
  std::shared_ptr<const FemModel> m;
  BlockLattice(std::shared_ptr<const Body> b, const LatticeGrid& grid, const Grading& grading)
      : body(std::move(b)),
        skin(body),
        table(skin, grid),
        a(body->surface, body->grid),
        t(build_topology(grid, material_surface(a), 0, grading)),
        m(assemble_fem(table, *t)) {
    EXPECT_EQ(fem::check_hanging(*m), "");
  }
};

std::shared_ptr<const Body> block(bool layered) {
  BlockSpec spec;
  spec.size_mm = {32, 28, 12};
  spec.skin_cell_mm = 2;
  Layer skin{"skin", 1.7, {}}, fat{"fat", 4.1, {}};
  skin.material = {120, 0.45, 1.1e-6, layered ? 1.1 : 1, 1};
  fat.material = {12, 0.47, 0.9e-6, layered ? 1.05 : 1, 1};
  spec.layers = layered ? std::vector<Layer>{skin, fat} : std::vector<Layer>{skin};
  return std::make_shared<const Body>(make_block(spec));
}

Grading two_zones() {
  Grading grading;
  grading.zones = {zone({-3, 2, 0}, {5, 2, 0}, 4, 3, 2), zone({2, -8, 0}, {2, -8, 0}, 5, 1)};
  return grading;
}

// The patch test: an even deformation, large and with shear, loads no node inside, across all sizes of cells.
TEST(Grading, AnEvenDeformationPassesThroughHangingNodes) {
  const auto body = block(false);
  const BlockLattice l(body, fit_lattice(*body, 4, kLevels), two_zones());
  EXPECT_GT(l.m->hanging.size(), 200u);
  Mat3 G;
  G << 0.2, 0.15, -0.03, -0.04, -0.16, 0.08, 0.02, 0.07, 0.13;
  std::vector<Vec3> u, g;
  for (const Vec3& X : l.m->X_mm) u.push_back(G * X);
  ReferenceElasticity(*l.m, {}).gradient(u, g);
  double typical = 0;
  for (const Vec3& f : g) typical = std::max(typical, f.norm());
  for (const HangingNode& h : l.m->hanging) {
    for (size_t k = 0; k < size_t(h.count); ++k) g[size_t(h.master[k])] += double(h.weight[k]) * g[size_t(h.node)];
    g[size_t(h.node)].setZero();
  }
  size_t inside = 0;
  for (size_t n = 0; n < g.size(); ++n) {
    const Int3 at = l.t->nodes[n].at;
    bool border = false;
    for (int a = 0; a < 3; ++a) border = border || at[a] == 0 || at[a] == kEighths * l.t->grid.count[a];
    if (border) continue;
    ++inside;
    EXPECT_LT(g[n].norm(), 1e-9 * typical) << n;
  }
  EXPECT_GT(inside, 500u);
}

// Every cell divided once is the lattice of half the size; but for the cells at a block's border, which miss it by
// some micrometres and count as full up to different fractions.
TEST(Grading, AllCellsAtLevelOneAreTheUniformLatticeOfHalfTheSize) {
  for (const bool box : {true, false}) {
    auto body = std::make_shared<Body>(*block(true));
    body->is_box = box;
    Grading all;
    all.zones = {zone({0, 0, 0}, {0, 0, 0}, 1000, 1)};
    const LatticeGrid grid = fit_lattice(*body, 4, kLevels);
    const BlockLattice graded_l(body, grid, all), uniform(body, grid.at_level(1), {});
    ASSERT_EQ(graded_l.m->X_mm.size(), uniform.m->X_mm.size());
    EXPECT_TRUE(graded_l.m->hanging.empty());
    std::map<std::array<int32_t, 3>, size_t> node;  // of the uniform lattice
    for (size_t n = 0; n < uniform.t->nodes.size(); ++n) {
      const Int3 at = uniform.t->nodes[n].at;
      node[{at.x / 2, at.y / 2, at.z / 2}] = n;
    }
    const auto solved = [](const BlockLattice& l) {
      std::vector<Vec3> start(l.m->X_mm.size(), Vec3::Zero());
      FemModel held = *l.m;  // the ends of the block are pulled
      double low = 1e9, high = -1e9;
      for (const Vec3& X : l.m->X_mm) low = std::min(low, X.x()), high = std::max(high, X.x());
      for (size_t n = 0; n < start.size(); ++n)
        if (const double x = l.m->X_mm[n].x(); x < low + 1e-6 || x > high - 1e-6)
          held.fixed.set(n, 1), start[n] = x > 0 ? Vec3(1, 0.3, 0.2) : Vec3(0, 0, 0);
      const auto r = ReferenceElasticity(held, {}).solve(start, {});
      EXPECT_TRUE(r.converged);
      return r.u;
    };
    const std::vector<Vec3> a = solved(graded_l), b = solved(uniform);
    double most = 0;
    for (size_t n = 0; n < a.size(); ++n) {
      const Int3 at = graded_l.t->nodes[n].at;
      const auto found = node.find({at.x, at.y, at.z});
      ASSERT_TRUE(found != node.end());
      most = std::max(most, (a[n] - b[found->second]).norm());
    }
    EXPECT_LT(most, box ? 2e-3 : 1e-9) << (box ? "block" : "closed surface");  // of 1 mm
  }
}

// Division changes neither mass nor volume.
TEST(Grading, MassAndVolumeAreThoseOfTheWhole) {
  for (const bool box : {true, false}) {
    auto body = std::make_shared<Body>(*block(true));
    body->is_box = box;
    const LatticeGrid grid = fit_lattice(*body, 4, kLevels);
    const BlockLattice fine(body, grid, two_zones()), whole(body, grid, {});
    double mass[2] = {0, 0};
    for (double x : whole.m->mass_kg) mass[0] += x;
    for (double x : fine.m->mass_kg) mass[1] += x;
    EXPECT_NEAR(mass[1], mass[0], 1e-12 * mass[0]);
    EXPECT_NEAR(fine.t->volume_mm3, whole.t->volume_mm3, 1e-11 * whole.t->volume_mm3);
    for (const HexCell& c : fine.m->cells) EXPECT_EQ(fine.m->stencils[size_t(c.stencil)].level, c.level);
  }
}

}  // namespace test_grading
}  // namespace limberg::test
