// Divided cells at crack fronts: which cells, what their elements add up to, and that nothing moves when they are made.
#include <functional>
#include <map>
#include <set>

#include "sim/base/error.h"
#include "sim/body/block.h"
#include "sim/fem/model/hanging_nodes.h"
#include "sim/lattice/cell_builder.h"
#include "sim/lattice/embedding.h"
#include "sim/lattice/fem_assembly.h"
#include "sim/lattice/grid_fit.h"
#include "sim/testing/reference_newton.h"
#include "tests/sim/lattice/lattice_scene.h"

namespace limberg::test {
namespace test_fronts {

const std::vector<Vec2> kRhombus{{10, 0}, {0, 6}, {-10, 0}, {0, -6}};

struct Fronts : ::testing::Test {
  LatticeScene s{wavy_slab(60, 12, 24, 0.8), grid_over(60, 12, 4.0), kLevels};
};

/// Both ends of every crack edge that has one wall only.
std::vector<std::array<Vec3, 2>> front_edges(const Arrangement& a) {
  std::vector<std::array<Vec3, 2>> edges;
  for (size_t f = 0; f < a.faces().size(); ++f) {
    const Face& face = a.faces()[f];
    if (!face.live() || face.mat != 3) continue;
    for (int k = 0; k < 3; ++k)
      if (a.mate(sided_half_edge(sided_face(int32_t(f), 0), k)) == sided_half_edge(sided_face(int32_t(f), 1), k))
        edges.push_back({a.point_mm(face.v[size_t(k)]), a.point_mm(face.v[size_t(k + 1) % 3])});
  }
  return edges;
}

// Along every front the cell has been divided twice, and its neighbours are graded (check_topology); a third time where
// the crack runs farther through it than an edge of it, nowhere else.
TEST_F(Fronts, LieInTheSmallestCells) {
  ASSERT_TRUE(s.cut(strip({{-14.3, 0.3}, {11.2, 1.1}}, 3, -6)));
  ASSERT_TRUE(s.cut(strip({{1, -13}, {2, 17}}, 3, -4)));
  ASSERT_TRUE(s.cut(sheet({-2, 0.1, -5}, {18, 0.1, 0}, {0.1, 13, 0.1}, 9, 7)));
  for (const Vec2& at : {Vec2(-17, -15), Vec2(-19, 9), Vec2(9, -19), Vec2(13.4, 11), Vec2(-24, -4)})
    ASSERT_TRUE(s.cut(strip({at, at + Vec2(5.3, 5.1)}, 3, -5.2)));
  const auto edges = front_edges(s.a);
  EXPECT_GT(edges.size(), 40u);
  for (const auto& e : edges)
    for (double t : {0.01, 0.3, 0.5, 0.7, 0.99}) {
      const Vec3 X = e[0] + t * (e[1] - e[0]);
      if (X.z() > -0.1) continue;  // next to the skin: maybe outside
      EXPECT_GE(s.t->tree.level(cell_of(*s.t, X)), 2) << X.transpose();
    }
  int askew = 0, straight = 0;
  const MaterialSurface surface = material_surface(s.a);  // a builder looks at it
  CellBuilder small(s.g.at_level(2), surface);
  for (int32_t cell = s.g.count.x * s.g.count.y * s.g.count.z; cell < s.t->tree.ids(); ++cell) {
    const auto& held = s.t->components[size_t(cell)];
    const CellPlace place = s.t->tree.place(s.g, cell);
    if (place.level == kLevels) ++askew;
    if (place.level != 2 || !held || !small.holds_front(place.at, held->face)) continue;
    EXPECT_LE(small.front_reach(place.at, held->face), 1 + 1e-6);
    ++straight;
  }
  EXPECT_GT(askew, 30);
  EXPECT_GT(straight, 100);
  int whole = 0;
  for (const CellCopy& c : s.t->cells) whole += !s.t->tree.is_part(c.cell);
  EXPECT_GT(whole, 200);  // far from the fronts nothing is divided
}

TEST_F(Fronts, WithoutTheOptionNothingIsDivided) {
  LatticeScene plain(wavy_slab(60, 12, 24, 0.8), grid_over(60, 12, 4.0));
  ASSERT_TRUE(plain.cut(strip({{-14.3, 0.3}, {11.2, 1.1}}, 3, -6)));
  EXPECT_TRUE(plain.t->tree.division.empty());
  EXPECT_TRUE(plain.t->hanging.empty());
  EXPECT_TRUE(plain.t->born.empty());
  LatticeGrid odd = plain.g;
  odd.pitch.x += 2;
  EXPECT_THROW(build_topology(odd, material_surface(plain.a), kLevels), InputError);
}

// A pocket whose rim nobody looks at: it goes through divided cells, divides none, and a later cut divides as ever.
TEST_F(Fronts, AnUpdateMayDivideNothing) {
  const Blade slit = strip({{-14.3, 0.3}, {11.2, 1.1}}, 3, -6), across = strip({{16, -9}, {17, 12}}, 3, -4);
  const Blade pocket = sheet({-2, 0.1, -5}, {18, 0.1, 0}, {0.1, 13, 0.1}, 9, 7);
  ASSERT_TRUE(s.cut(slit));
  const size_t of_slit = s.t->tree.division.size();
  EXPECT_GT(of_slit, 0u);
  s.divide = Divide::nothing;
  ASSERT_TRUE(s.cut(pocket));
  EXPECT_EQ(s.t->tree.division.size(), of_slit);
  s.divide = Divide::fronts;
  ASSERT_TRUE(s.cut(across));
  const size_t with_across = s.t->tree.division.size();
  EXPECT_GT(with_across, of_slit);

  LatticeScene all(wavy_slab(60, 12, 24, 0.8), grid_over(60, 12, 4.0), kLevels);
  for (const Blade& b : {slit, pocket, across}) ASSERT_TRUE(all.cut(b));
  EXPECT_GT(all.t->tree.division.size(), with_across);
  EXPECT_EQ(s.a.hash(), all.a.hash());
  EXPECT_EQ(s.t->pieces, all.t->pieces);
}

TEST_F(Fronts, UndoGoesOnFromTheOldVersion) {
  const auto first = s.t;
  ASSERT_TRUE(s.cut(strip({{-20, 0.3}, {20, 1.1}}, 3, -6)));
  const auto second = s.t;
  ASSERT_TRUE(s.cut(strip({{1, -20}, {2, 20}}, 3, -8)));
  const uint64_t hash = s.t->hash();
  ASSERT_TRUE(s.a.undo());
  s.t = second;
  s.seed = 2;
  ASSERT_TRUE(s.cut(strip({{1, -20}, {2, 20}}, 3, -8)));
  EXPECT_EQ(s.t->hash(), hash);
  ASSERT_TRUE(s.a.undo());
  ASSERT_TRUE(s.a.undo());
  s.t = first;
  s.seed = 1;
  ASSERT_TRUE(s.cut(strip({{-20, 0.3}, {20, 1.1}}, 3, -6)));
  EXPECT_EQ(s.t->hash(), second->hash());
}

// A whole history under arbitrary displacements: no point of the surface moves when cells are cut and divided.
TEST_F(Fronts, NothingJumps) {
  SurfaceView view = s.a.surface_view();
  auto e = embed_surface(*s.t, material_surface(s.a), view);
  std::vector<Vec3> u;
  for (size_t n = 0; n < s.t->nodes.size(); ++n)
    u.push_back(Vec3(std::sin(1.0 * double(n)), std::cos(1.7 * double(n)), std::sin(0.3 * double(n))));
  auto at = [](const EmbeddedPoint& p, const std::vector<Vec3>& v) {
    Vec3 x = Vec3::Zero();
    for (size_t k = 0; k < 8; ++k) x += double(p.w[k]) * v[size_t(p.node[k])];
    return x;
  };
  const std::vector<std::function<bool()>> steps{[&] { return s.cut(open_box(kRhombus, 3, -6)); },
                                                 [&] { return s.excise_smallest(); },
                                                 [&] {
                                                   return s.cut(strip({{0.1, 4}, {4, 16}, {14, 14}}, 3, -6));
                                                 },
                                                 [&] {
                                                   return s.cut(sheet({-2, 4, -5}, {18, 0.1, 0}, {0.1, 13, 0.1}, 9, 7));
                                                 },
                                                 [&] {
                                                   return s.cut(strip({{8, 20}, {7, 8}}, 3, -3));
                                                 },
                                                 [&] {
                                                   return s.cut(strip({{-20, -12}, {20, -11}}, 3, -4));
                                                 },
                                                 [&] {
                                                   return s.cut(strip({{-3, -20}, {-4, -9}}, 3, -8));
                                                 }};
  double jump = 0;
  for (const auto& step : steps) {
    ASSERT_TRUE(step());
    std::map<std::pair<int32_t, int32_t>, Vec3> before;  // (sided face, point) -> position
    for (size_t f = 0; f < view.tri.size(); ++f)
      for (int32_t v : view.tri[f]) before[{view.sided_face[f], view.point[size_t(v)]}] = at(e[size_t(v)], u);
    u = s.carried(u);
    LatticeScene::follow(*s.t, u);
    view = s.a.surface_view();
    e = embed_surface(*s.t, material_surface(s.a), view);
    size_t same = 0;
    for (size_t f = 0; f < view.tri.size(); ++f)
      for (int32_t v : view.tri[f]) {
        const auto it = before.find({view.sided_face[f], view.point[size_t(v)]});
        if (it == before.end()) continue;
        ++same;
        jump = std::max(jump, (at(e[size_t(v)], u) - it->second).norm());
      }
    EXPECT_GT(same, view.tri.size());
  }
  EXPECT_GT(s.t->hanging.size(), 500u);
  EXPECT_LT(jump, 1e-6);  // displacements of 1 mm, weights in single precision
}

// Between levels, copies are joined exactly where they are in the lattice that is as fine everywhere, whose cell beside
// the finer one is a part of the coarser one.
TEST_F(Fronts, LinksBetweenLevelsAreThoseOfTheFineLattice) {
  size_t compared = 0, several = 0;
  auto compare = [&] {
    const LatticeTopology& t = *s.t;
    for (int level = 1; level <= kLevels; ++level) {
      const auto fine = build_topology(t.grid.at_level(level), material_surface(s.a));
      std::map<std::pair<int32_t, int32_t>, std::set<std::pair<int, int>>> links;  // (finer, coarser cell) -> classes
      for (const auto& l : t.links) {
        const int32_t low = l.cell_axis / 3;
        const int ll = t.tree.level(low), lh = t.tree.level(l.next);
        if (ll != lh && std::max(ll, lh) == level)
          ll > lh ? links[{low, l.next}].insert({l.low, l.high}) : links[{l.next, low}].insert({l.high, l.low});
      }
      for (int32_t cell = t.tree.grid_cells; cell < t.tree.ids(); ++cell) {
        if (t.copies_of(cell) == 0 || t.tree.level(cell) != level) continue;
        const Int3 at = t.tree.place(t.grid, cell).at;
        for (int side = 0; side < 6; ++side) {
          Int3 beside = at;
          (side / 2 == 0 ? beside.x : side / 2 == 1 ? beside.y : beside.z) += side % 2 ? 1 : -1;
          if (beside[side / 2] < 0 || beside[side / 2] >= fine->grid.count[side / 2]) continue;
          const int32_t coarse = t.tree.find(t.grid, level, beside);
          if (t.copies_of(coarse) == 0 || t.tree.level(coarse) != level - 1) continue;
          const int32_t f = fine->grid.cell_index(at), g = fine->grid.cell_index(beside);
          const auto &of_g = fine->components[size_t(g)], &of_coarse = t.components[size_t(coarse)];
          auto class_in_coarse = [&](int cls) -> int {
            if (!of_coarse) return 0;
            if (!of_g) return of_coarse->of_corner[size_t((beside.x & 1) | (beside.y & 1) << 1 | (beside.z & 1) << 2)];
            for (size_t i = 0; i < of_g->face.size(); ++i)
              for (int k = 0; k < 2; ++k)
                if (of_g->of_side[i][size_t(k)] == cls) return of_coarse->class_of(2 * of_g->face[i] + k);
            return -1;
          };
          std::set<std::pair<int, int>> expected;
          for (const auto& l : fine->links) {
            if (l.cell_axis % 3 != side / 2) continue;
            if (side % 2 && l.cell_axis / 3 == f && l.next == g) expected.insert({l.low, class_in_coarse(l.high)});
            if (side % 2 == 0 && l.cell_axis / 3 == g && l.next == f) expected.insert({l.high, class_in_coarse(l.low)});
          }
          auto found = links.find({cell, coarse});
          ASSERT_EQ(found == links.end() ? decltype(expected){} : found->second, expected) << "cell " << cell;
          ++compared, several += expected.size() > 1;
        }
      }
    }
  };
  ASSERT_TRUE(s.cut(strip({{-14.3, 0.3}, {11.2, 1.1}}, 3, -6)));
  compare();
  ASSERT_TRUE(s.cut(strip({{1, -13}, {2, 17}}, 3, -4)));
  ASSERT_TRUE(s.cut(sheet({-2, 0.1, -5}, {18, 0.1, 0}, {0.1, 13, 0.1}, 9, 7)));
  ASSERT_TRUE(s.cut(strip({{-12, -8}, {9, 9}}, 3, -7)));
  compare();
  EXPECT_GT(compared, 300u);
  EXPECT_GT(several, 20u);
}

// --- Elements -----------------------------------------------------------------------------------------------------

struct Model {
  std::shared_ptr<const Body> body;
  Skin skin;
  LatticeGrid grid;
  StencilTable table;
  Arrangement uncut;
  std::shared_ptr<const LatticeTopology> whole,
      divided;  // both of the uncut block; the one with the cells of a slit divided
  std::shared_ptr<const FemModel> w, d;

  explicit Model(Body b)
      : body(std::make_shared<Body>(std::move(b))),
        skin(body),
        grid(fit_lattice(*body, 4, kLevels)),
        table(skin, grid),
        uncut(body->surface, body->grid) {
    Arrangement a(body->surface, body->grid);
    const auto before = build_topology(grid, material_surface(a), kLevels);
    EXPECT_TRUE(a.cut(strip({{-6.3, 0.4}, {5.2, 1.7}}, 3, -5), 1).ok());
    divided = build_topology_like(*update_topology(*before, material_surface(a)), material_surface(uncut));
    whole = build_topology(grid, material_surface(uncut));
    w = assemble_fem(table, *whole), d = assemble_fem(table, *divided);
  }
};

Body block(double stretch, bool layered) {
  BlockSpec spec;
  spec.size_mm = {32, 28, 12};
  spec.skin_cell_mm = 2;
  Layer skin{"skin", 1.7, {}}, fat{"fat", 4.1, {}}, deep{"deep", 1, {}};
  skin.material = {120, 0.45, 1.1e-6, stretch, 1 + 0.5 * (stretch - 1)};
  fat.material = {12, 0.47, 0.9e-6, 1 + 0.3 * (stretch - 1), 1};
  deep.material = {60, 0.4, 1e-6, 1, 1};
  spec.layers = {skin};
  if (layered) spec.layers = {skin, fat, deep};
  spec.tension_direction = {1, 0.4, 0};
  return make_block(spec);
}

/// Workers that go through the chunks of a loop from the last to the first, and count them.
class LastFirst final : public Workers {
 public:
  int count() const override { return 2; }
  void parallel_for(size_t n, size_t grain, const std::function<void(size_t, size_t)>& body) override {
    for (size_t k = (n + grain - 1) / grain; k-- > 0; ++chunks) body(k * grain, std::min(n, (k + 1) * grain));
  }
  std::shared_ptr<Job> submit(std::function<void()> job) override { return InlineWorkers().submit(std::move(job)); }
  int chunks = 0;
};

// Parts that were made beside each other, in whatever order, are those that one thread makes as it meets them, number
// by number. A slab with a round top, whose bottom is held.
TEST_F(Fronts, PartsMadeBesideEachOtherAreTheSame) {
  Body slab;
  slab.grid = grid();
  slab.surface = wavy_slab(60, 12, 24, 0.8);
  slab.layers.resize(2);
  slab.layers[0].thickness_mm = 2, slab.layers[1].thickness_mm = 5;
  slab.layers[0].material.prestretch_along = 1.1;
  slab.surface.tag.assign(slab.surface.tri.size(), SurfaceTag::skin);
  for (size_t t = 0; t < slab.surface.tri.size(); ++t) {
    const Tri& c = slab.surface.tri[t];
    if (std::all_of(c.begin(), c.end(), [&](int32_t v) { return slab.surface.X_mm[size_t(v)].z() < -11; }))
      slab.surface.tag[t] = SurfaceTag::fixed;
  }
  const Skin skin(std::make_shared<const Body>(std::move(slab)));
  ASSERT_TRUE(s.cut(strip({{-14.3, 0.3}, {11.2, 1.1}}, 3, -11.8)));
  ASSERT_TRUE(s.cut(strip({{1, -13}, {2, 17}}, 3, -4)));
  const StencilTable one(skin, s.t->grid), many(skin, s.t->grid);
  LastFirst workers;
  make_parts_ready(many, *s.t, nullptr, workers);
  EXPECT_GT(workers.chunks, 50);
  const auto a = assemble_fem(one, *s.t), b = assemble_fem(many, *s.t);
  ASSERT_EQ(a->cells.size(), b->cells.size());
  for (size_t c = 0; c < a->cells.size(); ++c) {
    ASSERT_EQ(a->cells[c].stencil, b->cells[c].stencil) << c;
    ASSERT_EQ(a->cells[c].scale, b->cells[c].scale) << c;
  }
  EXPECT_EQ(a->fixed, b->fixed);
  EXPECT_TRUE(one.any_held_corners());
  ASSERT_EQ(a->stencils.size(), b->stencils.size());
  for (size_t k = 0; k < a->stencils.size(); ++k) {
    EXPECT_EQ(a->stencils[k].K, b->stencils[k].K) << k;
    EXPECT_EQ(a->stencils[k].volume_mm3, b->stencils[k].volume_mm3) << k;
  }
  const int made = workers.chunks;
  make_parts_ready(many, *s.t, nullptr, workers);
  EXPECT_EQ(workers.chunks, made) << "nothing is made twice";
}

double largest_unknown(const FemModel& m, std::vector<Vec3> g) {
  for (const HangingNode& h : m.hanging) {
    for (size_t k = 0; k < size_t(h.count); ++k) g[size_t(h.master[k])] += double(h.weight[k]) * g[size_t(h.node)];
    g[size_t(h.node)].setZero();
  }
  double most = 0;
  for (size_t i = 0; i < g.size(); ++i)
    if (!m.fixed[i]) most = std::max(most, g[i].norm());
  return most;
}

// A flat block of prestretched layers rests on any lattice: parts see their own layers, and what hangs balances.
TEST(DividedElements, PrestretchedLayersRest) {
  const Model m(block(1.15, true));
  EXPECT_EQ(fem::check_hanging(*m.d), "");
  EXPECT_GT(m.d->hanging.size(), 100u);
  ReferenceElasticity whole(*m.w, {}), divided(*m.d, {});
  std::vector<Vec3> g;
  whole.gradient(std::vector<Vec3>(m.w->X_mm.size(), Vec3::Zero()), g);
  double scale = 0;
  for (const Vec3& f : g) scale = std::max(scale, f.norm());
  const double rest = largest_unknown(*m.w, g);
  divided.gradient(std::vector<Vec3>(m.d->X_mm.size(), Vec3::Zero()), g);
  EXPECT_LT(
      rest,
      2e-3 * scale);  // the planes of the lattice lie some micrometres outside the block: up to a thousandth of a cell
  EXPECT_LT(largest_unknown(*m.d, g), 2e-3 * scale);
}

TEST(DividedElements, MassVolumeAndEnergyAreThoseOfTheWhole) {
  const Model m(block(1.1, true));
  double mass[2] = {0, 0};
  for (double x : m.w->mass_kg) mass[0] += x;
  for (double x : m.d->mass_kg) mass[1] += x;
  EXPECT_NEAR(mass[1], mass[0], 1e-12 * mass[0]);
  EXPECT_NEAR(m.divided->volume_mm3, m.whole->volume_mm3, 1e-11 * m.whole->volume_mm3);
  EXPECT_EQ(m.divided->pieces, 1);
  // A linear field is in both spaces; in one layer the volume term is the same, too.
  const Model one(block(1.1, false));
  Mat3 G;
  G << 0.1, 0.05, -0.03, -0.04, -0.06, 0.08, 0.02, 0.07, 0.03;
  auto affine = [&](const FemModel& f) {
    std::vector<Vec3> u;
    for (const Vec3& X : f.X_mm) u.push_back(G * X);
    return u;
  };
  ReferenceElasticity whole(*one.w, {}), divided(*one.d, {});
  const double e = whole.energy(affine(*one.w));
  EXPECT_NEAR(divided.energy(affine(*one.d)), e, 2e-3 * std::abs(e));  // cells at the border count as full: micrometres
  EXPECT_EQ(one.d->cells.size(), one.divided->cells.size());
}

TEST(DividedElements, PartsOfOtherBodiesSeeTheirLayers) {
  Body b = block(1.15, true);
  b.is_box = false;
  const Model m(std::move(b));
  double mass[2] = {0, 0};
  for (double x : m.w->mass_kg) mass[0] += x;
  for (double x : m.d->mass_kg) mass[1] += x;
  EXPECT_NEAR(mass[1], mass[0], 1e-12 * mass[0]);
  for (const HexCell& c : m.d->cells) EXPECT_EQ(m.d->stencils[size_t(c.stencil)].level, c.level);
  EXPECT_EQ(fem::check_hanging(*m.d), "");
}

}  // namespace test_fronts
}  // namespace limberg::test
