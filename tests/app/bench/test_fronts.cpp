// A slit that ends inside cells, on lattices with and without divided fronts.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "app/bench/fronts.h"

namespace limberg::bench {
namespace {

SlitSpec small(double cell_mm, int levels) {
  SlitSpec s;
  s.block_mm = {36, 28, 8}, s.from_mm = -6.9, s.to_mm = 6.6, s.depth_mm = 5;
  s.cell_mm = cell_mm, s.front_levels = levels;
  return s;
}

double worst_closed(const SlitOpening& o, double cell_mm) {
  return std::max({o.closed_low_mm, o.closed_high_mm, o.closed_deep_mm}) / cell_mm;
}

double difference(const SlitOpening& a, const SlitOpening& b) {
  double sum = 0;
  for (size_t i = 0; i < a.width_mm.size(); ++i) sum += std::pow(a.width_mm[i] - b.width_mm[i], 2);
  return std::sqrt(sum / double(a.width_mm.size())) / b.widest_mm;
}

TEST(Fronts, ASlitOpensToWithinAQuarterCellOfItsEnd) {
  InlineWorkers w;
  const double cell = 4;
  const SlitOpening whole = open_slit(small(cell, 0), w), once = open_slit(small(cell, 1), w), twice = open_slit(small(cell, 2), w);
  const SlitOpening fine = open_slit(small(cell / 4, 0), w);
  for (const SlitOpening* o : {&whole, &once, &twice, &fine}) EXPECT_LT(o->reached, 4e-5);
  EXPECT_GT(worst_closed(whole, cell), 0.25);  // the study would show nothing otherwise
  EXPECT_LE(worst_closed(whole, cell), 1.02);
  EXPECT_LE(worst_closed(once, cell), 0.52);
  EXPECT_LE(worst_closed(twice, cell), 0.26);  // measured in steps of 0.01 mm, and a thousandth of the width is not closed
  EXPECT_LE(worst_closed(fine, cell), 0.26);
  // The width is nearer to that of the lattice that is as fine everywhere, at a fraction of its nodes. (Measured on
  // 2026-11-21: 0.095 of the greatest width against 0.182. Divided once, these ends happen to lie no better: 0.182.)
  EXPECT_LT(difference(twice, fine), 0.6 * difference(whole, fine));
  EXPECT_LT(twice.nodes, fine.nodes / 2);
  EXPECT_GT(twice.hanging, 20u);
  EXPECT_EQ(whole.hanging, 0u);
}

}  // namespace
}  // namespace limberg::bench
