// The update at the cost of the cut gives what the update from the whole lattice gives, to the last bit.
#include <random>

#include "sim/lattice/topology_parts.h"
#include "tests/sim/lattice/lattice_scene.h"

namespace limberg::test {
namespace {

void expect_same(const LatticeTopology& a, const LatticeTopology& b) {
  ASSERT_EQ(a.hash, b.hash);
  ASSERT_EQ(a.cells.size(), b.cells.size());
  for (size_t i = 0; i < a.cells.size(); ++i) {
    EXPECT_EQ(a.cells[i].cell, b.cells[i].cell) << i;
    EXPECT_EQ(a.cells[i].piece, b.cells[i].piece) << i;
    EXPECT_EQ(a.cells[i].fraction, b.cells[i].fraction) << i;
    EXPECT_EQ(a.cells[i].node, b.cells[i].node) << i;
    EXPECT_EQ(a.cells[i].parent, b.cells[i].parent) << i;
  }
  ASSERT_EQ(a.nodes.size(), b.nodes.size());
  for (size_t i = 0; i < a.nodes.size(); ++i) {
    EXPECT_EQ(a.nodes[i].lattice_node, b.nodes[i].lattice_node) << i;
    EXPECT_EQ(a.nodes[i].parent, b.nodes[i].parent) << i;
    EXPECT_EQ(a.nodes[i].at, b.nodes[i].at) << i;
  }
  EXPECT_EQ(a.copy_begin, b.copy_begin);
  EXPECT_EQ(a.copy_id, b.copy_id);
  EXPECT_TRUE(a.links == b.links);
  EXPECT_EQ(a.pieces, b.pieces);
  EXPECT_EQ(a.piece_volume_mm3, b.piece_volume_mm3);
  EXPECT_EQ(a.piece_fixed, b.piece_fixed);
  EXPECT_EQ(a.volume_mm3, b.volume_mm3);
  EXPECT_EQ(a.walks, b.walks);
  EXPECT_EQ(a.walks_unresolved, b.walks_unresolved);
}

TEST(LocalUpdate, IsTheWholeUpdateToTheLastBit) {
  std::mt19937 random(7);
  const auto uniform = [&](double from, double to) { return from + (to - from) * (random() * (1.0 / 4294967296.0)); };
  const LatticeGrid g = grid_over(60, 12, 4.3);
  int through = 0, local = 0;
  for (int scene = 0; scene < 3; ++scene) {
    Arrangement a(wavy_slab(60, 12, 24, 0.8), grid());
    std::vector<std::shared_ptr<const LatticeTopology>> history{build_topology(g, material_surface(a))};
    for (int i = 0; i < 14; ++i) {
      const Vec2 p(uniform(-25, 25), uniform(-25, 25)), q(uniform(-25, 25), uniform(-25, 25));
      const bool deep = i % 5 == 4;  // from end to end and through: a piece comes off
      const Vec2 d = (q - p).normalized() * 90;
      const Blade blade = deep ? strip({p - d, p + d}, 3, -14) : strip({p, q}, 3, -uniform(1, 11));
      if (!a.cut(blade, uint64_t(100 * scene + i)).ok()) continue;
      const MaterialSurface surface = material_surface(a);
      const auto whole = update_topology(*history.back(), surface, false);
      const auto fast = update_topology(*history.back(), surface, true);
      expect_same(*fast, *whole);
      ASSERT_EQ(check_topology(*fast), "");
      through += fast->pieces > history.back()->pieces;
      ++local;
      if (i % 6 == 5)
        a.undo();
      else
        history.push_back(fast);
    }
  }
  EXPECT_GT(through, 3);
  EXPECT_GT(local, 30);
}

}  // namespace
}  // namespace limberg::test
