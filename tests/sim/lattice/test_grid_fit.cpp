#include <gtest/gtest.h>

#include "sim/base/error.h"
#include "sim/body/block.h"
#include "sim/lattice/grid_fit.h"

namespace limberg::test {
namespace test_grid_fit {

Body block(const Vec3& size_mm) {
  BlockSpec spec;
  spec.size_mm = size_mm;
  spec.skin_cell_mm = 5;
  return make_block(spec);
}

void expect_covers(const LatticeGrid& g, const Body& body) {
  for (int a = 0; a < 3; ++a) {
    EXPECT_EQ(g.pitch[a] % 2, 0);
    EXPECT_NE(g.origin[a] % 2, 0);
    const int64_t top = int64_t(g.origin[a]) + int64_t(g.count[a]) * g.pitch[a];
    for (const Vec3& X : body.surface.X_mm) {
      const int32_t c = body.grid.to_grid(X)[a];
      ASSERT_LT(g.origin[a], c);
      ASSERT_GT(top, c);
    }
  }
}

TEST(GridFit, BlockIsFittedExactly) {
  for (double h : {0.9, 2.0, 3.5, 5.0, 9.9}) {
    const Body body = block({120, 70, 10});
    const LatticeGrid g = fit_lattice(body, h);
    expect_covers(g, body);
    const double size[3] = {120, 70, 10};
    for (int a = 0; a < 3; ++a) {
      EXPECT_EQ(g.count[a], std::max(1L, std::lround(size[a] / h)));
      // The lattice sticks out by less than one pair of half-units per cell in all.
      EXPECT_LE(g.cell_mm()[a] * g.count[a] - size[a], (2 * g.count[a] + 2) * g.rest.half_unit_mm());
    }
  }
}

TEST(GridFit, OtherBodiesGetCubes) {
  Body body = block({30, 20, 10});
  body.is_box = false;
  const LatticeGrid g = fit_lattice(body, 3);
  expect_covers(g, body);
  EXPECT_EQ(g.pitch.x, g.pitch.y);
  EXPECT_EQ(g.pitch.x, g.pitch.z);
  EXPECT_NEAR(g.cell_mm().x(), 3, g.rest.unit_mm);
}

TEST(GridFit, RefusesWhatCannotBe) {
  const Body body = block({30, 20, 10});
  for (double h : {0.0, -1.0, double(NAN), double(INFINITY), 10.1, 0.02})
    EXPECT_THROW(fit_lattice(body, h), InputError) << h;
}

}  // namespace test_grid_fit
}  // namespace limberg::test
