// Random operations: every invariant after every step, and the voxel oracle on the cells that were cut.
#include <cstdlib>

#include "tests/sim/lattice/lattice_scene.h"
#include "tests/sim/lattice/voxel_oracle.h"

namespace limberg::test {
namespace test_cells_fuzz {

struct Random {
  uint64_t s;
  double operator()(double lo, double hi) {
    s = s * 6364136223846793005ull + 1442695040888963407ull;
    return lo + (hi - lo) * double(s >> 33) * 0x1p-31;
  }
  int below(int n) { return int((*this)(0, n)); }
};

Blade random_blade(Random& r) {
  const Vec2 c(r(-22, 22), r(-22, 22));
  const double turn = r(0, 6.28);
  const auto dir = [&](double a, double l) { return Vec2(l * std::cos(turn + a), l * std::sin(turn + a)); };
  switch (r.below(5)) {
    case 0:
      return strip({c - dir(0, r(3, 18)), c + dir(r(-0.3, 0.3), r(3, 18))}, 3, -r(1, 11));
    case 1:
      return strip({c - dir(0, r(3, 14)), c, c + dir(r(-1.5, 1.5), r(3, 14))}, 3, -r(1, 11));
    case 2:
      return strip({c - dir(0, 120), c + dir(0, 120)}, 3, -20, false, 6);
    case 3: {
      const Vec2 u = dir(0, r(6, 20)), v = dir(r(1.2, 1.9), r(6, 20));
      const double z = -r(1, 10), slope = r.below(2) ? 2 : 0;
      return sheet({c.x(), c.y(), z}, {u.x(), u.y(), slope * r(-1, 1)}, {v.x(), v.y(), slope * r(-1, 1)}, 6, 6);
    }
    default: {
      const double a = r(3, 9), b = r(3, 9);
      return open_box({c + dir(0, a), c + dir(1.5, b), c - dir(0, a), c - dir(1.5, b)}, 3, -r(2, 10));
    }
  }
}

// Moves whole coordinates of a blade next to lattice planes:
// walls one half-unit beside them, edges through lattice edges.
void press_onto_planes(Blade& b, const LatticeGrid& g, Random& r) {
  const bool axis_pressed[3] = {r.below(2) == 0, r.below(2) == 0, r.below(2) == 0};
  for (Int3& v : b.vertex) {
    int32_t* c[3] = {&v.x, &v.y, &v.z};
    for (int a = 0; a < 3; ++a) {
      const double k = std::round(double(*c[a] - g.origin[a]) / g.pitch[a]);
      if (!axis_pressed[a] || std::abs(*c[a] - g.origin[a] - k * g.pitch[a]) > 0.2 * g.pitch[a]) continue;
      *c[a] = g.origin[a] + int32_t(k) * g.pitch[a] + 1;
    }
  }
}

// LIMBERG_FUZZ_HISTORIES lengthens the run.
int histories() {
  const char* n = std::getenv("LIMBERG_FUZZ_HISTORIES");
  return n ? std::atoi(n) : 4;
}

class CellsFuzz : public ::testing::TestWithParam<int> {};  // how often cells at a front are divided
INSTANTIATE_TEST_SUITE_P(FrontLevels, CellsFuzz, ::testing::Values(0, 1, 2, 3));

TEST_P(CellsFuzz, EveryInvariantAfterEveryOperation) {
  for (int history = 0; history < histories(); ++history) {
    Random r{uint64_t(history) * 7919 + 17};
    const double cell = r(2.6, 7.5);
    LatticeScene s(wavy_slab(60, 12, 20, r(0, 1.5)), grid_over(60, 12, cell), GetParam());
    int done = 0;
    for (int op = 0; op < 14 && !::testing::Test::HasFailure(); ++op) {
      SCOPED_TRACE("history " + std::to_string(history) + " operation " + std::to_string(op));
      Blade b = random_blade(r);
      if (history % 2) press_onto_planes(b, s.g, r);
      if (s.cut(b, r.below(3) == 0)) ++done;
      if (s.t->pieces > 1 && r.below(2)) s.excise_smallest();
    }
    EXPECT_GT(done, 3);
    EXPECT_EQ(s.t->tree.division.empty(), GetParam() == 0);
  }
}

// Pieces of more than a thousandth of a cell: as many as the oracle finds, and as large.
TEST(CellsFuzz, AgreesWithVoxels) {
  int compared = 0, several = 0;
  for (int history = 0; history < histories(); ++history) {
    Random r{uint64_t(history) * 104729 + 23};
    LatticeScene s(wavy_slab(60, 12, 16, 1.2), grid_over(60, 12, r(4, 9)));
    for (int op = 0; op < 7; ++op) s.cut(random_blade(r));
    const VoxelOracle oracle(s.a);
    for (size_t cell = 0; cell < s.t->components.size(); ++cell) {
      const auto& comp = s.t->components[cell];
      if (!comp) continue;
      bool cut = false;
      for (int32_t f : comp->face) cut = cut || s.a.orig_tris()[size_t(s.a.faces()[size_t(f)].orig)].op > 0;
      if (!cut) continue;
      std::vector<double> exact;
      for (const CellClass& c : comp->classes) exact.push_back(c.fraction);
      std::sort(exact.rbegin(), exact.rend());
      bool same = false;
      std::string report;
      for (int n : {12, 24, 48, 96, 192, 384}) {  // what is thinner than a voxel may be missed or torn: look closer
        const std::vector<double> seen = oracle.pieces(s.g, int32_t(cell), n);
        // Every piece counts that is larger than a voxel row; smaller ones must be small on the other side, too.
        same = true;
        report.clear();
        for (size_t i = 0; i < std::max(exact.size(), seen.size()); ++i) {
          const double e = i < exact.size() ? exact[i] : 0, v = i < seen.size() ? seen[i] : 0;
          report += std::to_string(e) + "/" + std::to_string(v) + " ";
          same = same && std::abs(e - v) < std::max(1e-3, 0.5 / n * std::min(1.0, 20 * std::pow(e, 2.0 / 3) + 0.02));
        }
        if (same) break;
      }
      EXPECT_TRUE(same) << "history " << history << " cell " << cell << " exact/voxels: " << report;
      ++compared;
      several += exact.size() > 1;
    }
  }
  EXPECT_GT(compared, 40 * histories());
  EXPECT_GT(several, 10 * histories());
}

}  // namespace test_cells_fuzz
}  // namespace limberg::test
