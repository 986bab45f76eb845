#include "sim/base/error.h"
#include "sim/lattice/topology.h"
#include "tests/sim/lattice/lattice_scene.h"

namespace limberg::test {
namespace test_topology {

const std::vector<Vec2> kRhombus{{10, 0}, {0, 6}, {-10, 0}, {0, -6}};

class Slab : public ::testing::TestWithParam<double> {
 protected:
  LatticeScene s{wavy_slab(60, 12, 24, 0.8), grid_over(60, 12, GetParam())};
};
INSTANTIATE_TEST_SUITE_P(Cells, Slab, ::testing::Values(3.0, 4.1, 4.7));

TEST_P(Slab, Uncut) {
  EXPECT_EQ(s.t->pieces, 1);
  for (size_t c = 0; c < s.t->components.size(); ++c) EXPECT_LE(s.t->copies_of(int32_t(c)), 1);
}

TEST_P(Slab, CrossOfPartialIncisions) {
  const size_t cells = s.t->cells.size();
  ASSERT_TRUE(s.cut(strip({{-20, 0.3}, {20, 1.1}}, 3, -6)));
  EXPECT_TRUE(GetParam() > 3 || s.t->cells.size() > cells);
  ASSERT_TRUE(s.cut(strip({{1, -20}, {2, 20}}, 3, -4)));
  ASSERT_TRUE(s.cut(strip({{-15, -14}, {16, 15}}, 3, -8)));
  EXPECT_EQ(s.t->pieces, 1);
}

TEST_P(Slab, CrossThrough) {
  ASSERT_TRUE(s.cut(strip({{-40, 0.3}, {40, 1.1}}, 3, -20)));
  EXPECT_EQ(s.t->pieces, 2);
  ASSERT_TRUE(s.cut(strip({{1, -40}, {2, 40}}, 3, -20)));
  EXPECT_EQ(s.t->pieces, 4);
}

TEST_P(Slab, TeeIn) {
  ASSERT_TRUE(s.cut(strip({{-20, 0.3}, {20, 1.1}}, 3, -6)));
  ASSERT_TRUE(s.cut(strip({{1, -15}, {2, 0.9}}, 3, -4)));
  ASSERT_TRUE(s.cut(strip({{-8, 15}, {-7, 0.4}}, 3, -8)));
}

TEST_P(Slab, PlugAndWhatIsLeft) {
  ASSERT_TRUE(s.cut(open_box(kRhombus, 3, -6)));
  EXPECT_EQ(s.t->pieces, 2);
  ASSERT_TRUE(s.excise_smallest());
  EXPECT_EQ(s.t->pieces, 1);
}

TEST_P(Slab, PlugInOneUpdate) {
  const auto before = s.t;
  ASSERT_TRUE(s.a.cut(open_box({{14, 0}, {0, 9}, {-14, 0}, {0, -9}}, 3, -9), 5).ok());
  ASSERT_TRUE(s.a.excise(s.a.loose_component_near({0, 0, 0}, 5)).done);
  s.update();
  EXPECT_EQ(s.t->pieces, 1);
}

TEST_P(Slab, DrillThenSlit) {
  ASSERT_TRUE(s.cut(strip({{8, 0.1}, {0.2, 5}, {-8, 0}, {0, -5}}, 3, -20, true)));
  EXPECT_EQ(s.t->pieces, 2);
  ASSERT_TRUE(s.excise_smallest());
  ASSERT_TRUE(s.cut(strip({{20, 1.3}, {5, 0.4}}, 3, -5)));
}

TEST_P(Slab, ParallelCutsLeaveAThinSheet) {
  ASSERT_TRUE(s.cut(strip({{-40, 0.3}, {40, 1.1}}, 3, -20)));
  ASSERT_TRUE(s.cut(strip({{-40, 0.36}, {40, 1.16}}, 3, -20)));
  EXPECT_EQ(s.t->pieces, 3);
}

TEST_P(Slab, UndoGoesOnFromTheOldVersion) {
  const auto before = s.t;
  ASSERT_TRUE(s.cut(strip({{-20, 0.3}, {20, 1.1}}, 3, -6)));
  const uint64_t hash = s.t->hash();
  ASSERT_TRUE(s.a.undo());
  s.t = before;
  s.seed = 1;
  ASSERT_TRUE(s.cut(strip({{-20, 0.3}, {20, 1.1}}, 3, -6)));
  EXPECT_EQ(s.t->hash(), hash);
}

TEST_P(Slab, IdsOfWhatStaysAreKept) {
  const auto before = s.t;
  ASSERT_TRUE(s.cut(strip({{-20, 0.3}, {20, 1.1}}, 3, -6)));
  for (size_t c = 0; c < before->cells.size(); ++c) EXPECT_EQ(s.t->cell_parent[c], int32_t(c));
  for (size_t n = 0; n < before->nodes.size(); ++n) EXPECT_EQ(s.t->node_parent[n], int32_t(n));
  EXPECT_TRUE(GetParam() > 3 || s.t->nodes.size() > before->nodes.size());  // deeper than a cell
}

TEST(Topology, SurfaceBeyondTheLatticeIsRefused) {
  Arrangement a(wavy_slab(60, 12, 4, 0.8), grid());
  LatticeGrid g = grid_over(40, 12, 5);
  EXPECT_THROW(build_topology(g, material_surface(a)), InputError);
}

}  // namespace test_topology
}  // namespace limberg::test
