// A slit that ends inside cells, on lattices with and without divided fronts.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sim/lattice/lattice.h"
#include "tests/bench/fronts.h"

namespace limberg::bench {
namespace test_fronts {

SlitSpec small(double cell_mm, int levels) {
  SlitSpec s;
  s.block_mm = {36, 28, 8}, s.from_mm = -6.9, s.to_mm = 6.6, s.depth_mm = 5;
  s.cell_mm = cell_mm, s.front_levels = levels;
  return s;
}

double worst_closed(const SlitOpening& o, double cell_mm) {
  return std::max({o.closed_low_mm, o.closed_high_mm, o.closed_deep_mm}) / cell_mm;
}
double worst_closed(const SlitOpening& o) {  // in cells as they have been fitted to the block
  return std::max(std::max(o.closed_low_mm, o.closed_high_mm) / o.cell_mm.x(), o.closed_deep_mm / o.cell_mm.z());
}

double difference(const SlitOpening& a, const SlitOpening& b) {
  double sum = 0;
  for (size_t i = 0; i < a.width_mm.size(); ++i) sum += std::pow(a.width_mm[i] - b.width_mm[i], 2);
  return std::sqrt(sum / double(a.width_mm.size())) / b.widest_mm;
}

TEST(Fronts, ASlitOpensToWithinAQuarterCellOfItsEnd) {
  InlineWorkers w;
  const double cell = 4;
  const SlitOpening whole = open_slit(small(cell, 0), w), once = open_slit(small(cell, 1), w),
                    divided = open_slit(small(cell, kLevels), w);
  const SlitOpening fine = open_slit(small(cell / 4, 0), w);
  for (const SlitOpening* o : {&whole, &once, &divided, &fine}) EXPECT_LT(o->reached, 4e-5);
  EXPECT_GT(worst_closed(whole, cell), 0.25);  // the study would show nothing otherwise
  EXPECT_LE(worst_closed(whole, cell), 1.02);
  EXPECT_LE(worst_closed(once, cell), 0.52);
  EXPECT_LE(worst_closed(divided, cell),
            0.26);  // measured in steps of 0.01 mm, and a thousandth of the width is not closed
  EXPECT_LE(worst_closed(fine, cell), 0.26);
  // The width is nearer to that of the lattice that is as fine everywhere, at a fraction of its nodes. (Measured on
  // 2026-11-21: 0.095 of the greatest width against 0.182. Divided once, these ends happen to lie no better: 0.182.)
  EXPECT_LT(difference(divided, fine), 0.6 * difference(whole, fine));
  EXPECT_LT(divided.nodes, fine.nodes / 2);
  EXPECT_GT(divided.hanging, 20u);
  EXPECT_EQ(whole.hanging, 0u);
}

// At any angle to the cells, with ends anywhere in one: what the lattice cannot open is at most a quarter of a cell.
// Two divisions alone leave up to a quarter of the cell's diagonal.
TEST(Fronts, AtAnyAngleAQuarterCellStaysClosedAtMost) {
  double most_twice = 0;
  size_t nodes = 0, nodes_twice = 0;
  for (const double cell : {4.3, 3.5, 2.9})
    for (double angle = 0; angle <= 90; angle += 7.5) {
      SlitSpec s = small(cell, kLevels);
      s.block_mm = {30, 30, 8}, s.skin_cell_mm = 1.5, s.angle_deg = angle;
      s.from_mm -= 0.011 * angle, s.to_mm += 0.017 * angle, s.y_mm += 0.013 * angle, s.depth_mm -= 0.01 * angle;
      const SlitOpening o = slit_in_lattice(s);
      EXPECT_LE(worst_closed(o), 0.25 + 0.01 / o.cell_mm.minCoeff())
          << cell << " mm, " << angle << " degrees";  // steps of 0.01 mm
      nodes += o.nodes;
      s.front_levels = 2;
      const SlitOpening twice = slit_in_lattice(s);
      most_twice = std::max(most_twice, worst_closed(twice));
      nodes_twice += twice.nodes;
      if (angle == 0 || angle == 90) {  // along the lattice two divisions are enough
        EXPECT_EQ(o.nodes, twice.nodes);
      }
    }
  EXPECT_GT(most_twice, 0.28);  // the test would show nothing otherwise
  EXPECT_LE(most_twice, 0.36);
  std::printf("nodes %zu, with two divisions %zu; closed with two %.3f\n", nodes, nodes_twice, most_twice);
}

}  // namespace test_fronts
}  // namespace limberg::bench
