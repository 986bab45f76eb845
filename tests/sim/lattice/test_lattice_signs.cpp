// The twelve signs of an edge about a cell, against integers into which the vanishing shift of the lattice is put as a
// small number, and against the signs found one by one.
#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "sim/lattice/lattice_signs.h"

namespace limberg {
namespace test_lattice_signs {

CellBounds bounds(const Int3& low, const Int3& high) {
  CellBounds b;
  for (int a = 0; a < 3; ++a) b.half[size_t(a)] = {double(low[a]), double(high[a])};
  for (int axis = 0; axis < 3; ++axis)
    for (int corner = 0; corner < 4; ++corner) {
      const int i = (axis + 1) % 3, j = (axis + 2) % 3;
      SubPoint& c = b.edge_corner[size_t(axis)][size_t(corner)];
      c[size_t(axis)] = int64_t(low[axis]) << kSubUnitBits;
      c[size_t(i)] = int64_t((corner & 1 ? high : low)[i]) << kSubUnitBits;
      c[size_t(j)] = int64_t((corner >> 1 ? high : low)[j]) << kSubUnitBits;
    }
  return b;
}

int parallel_to(const Int3& p, const Int3& q) {
  for (int a = 0; a < 3; ++a)
    if (p[(a + 1) % 3] == q[(a + 1) % 3] && p[(a + 2) % 3] == q[(a + 2) % 3]) return a;
  return -1;
}

// Half-units times 2^40, the lattice moved by (-2^24, -2^12, -1): coordinates below 2^8 leave each shift without weight
// beside the one before. The shift is in the determinant once, so small is as good as vanishing.
int by_integers(const Int3& p, const Int3& q, int axis, const Int3& corner) {
  constexpr int64_t shift[3] = {int64_t(1) << 24, int64_t(1) << 12, 1};
  const int i = (axis + 1) % 3, j = (axis + 2) % 3;
  const auto from = [&](const Int3& x, int k) { return int128(((int64_t(x[k]) - corner[k]) << 40) + shift[k]); };
  return sign_of(from(p, i) * from(q, j) - from(p, j) * from(q, i));
}

TEST(LatticeSigns, OfAnEdgeAboutACellAreThoseOfTheShiftedLattice) {
  std::mt19937 random(1);
  const Int3 low{3, 5, 7}, high{7, 9, 11};
  const CellBounds cell = bounds(low, high);
  std::uniform_int_distribution<int32_t> place(
      1, 13);  // few places: ties, edges along axes and through corners are common
  int ties = 0;
  for (int n = 0; n < 20000; ++n) {
    const Int3 p{place(random), place(random), place(random)}, q{place(random), place(random), place(random)};
    if (p == q) continue;
    const Vec3 P(p.x, p.y, p.z), Q(q.x, q.y, q.z);
    const EdgeSigns signs = edge_about_corners({&P, nullptr}, {&Q, nullptr}, parallel_to(p, q), cell);
    const EdgeSigns back = edge_about_corners({&Q, nullptr}, {&P, nullptr}, parallel_to(p, q), cell);
    bool misses = false;
    for (int axis = 0; axis < 3; ++axis) {
      int sum = 0;
      for (int corner = 0; corner < 4; ++corner) {
        const int i = (axis + 1) % 3, j = (axis + 2) % 3;
        std::array<int32_t, 3> at{low.x, low.y, low.z};
        at[size_t(i)] = (corner & 1 ? high : low)[i], at[size_t(j)] = (corner >> 1 ? high : low)[j];
        const Int3 c{at[0], at[1], at[2]};
        ASSERT_EQ(signs.of(axis, corner), by_integers(p, q, axis, c)) << n;
        ASSERT_EQ(back.of(axis, corner), -signs.of(axis, corner)) << n;
        const int64_t det = int64_t(p[i] - c[i]) * (q[j] - c[j]) - int64_t(p[j] - c[j]) * (q[i] - c[i]);
        ties += det == 0 && axis != parallel_to(p, q);
        sum += signs.of(axis, corner);
      }
      misses = misses || std::abs(sum) == 4;
    }
    ASSERT_EQ(signs.misses_all(), misses) << n;
  }
  EXPECT_GT(ties, 1000);
}

TEST(LatticeSigns, OfIntersectionsAreThoseFoundOneByOne) {
  std::mt19937 random(2);
  const Int3 low{300, 500, 700}, high{700, 900, 1100};
  const CellBounds cell = bounds(low, high);
  std::uniform_int_distribution<int32_t> place(1, 13);
  const auto point = [&] { return Int3{100 * place(random), 100 * place(random), 100 * place(random)}; };
  int seen = 0;
  for (int n = 0; n < 4000; ++n) {
    std::array<NarrowHomogeneous, 2> h;
    std::array<Vec3, 2> x;
    bool sound = true;
    for (size_t k = 0; k < 2; ++k) {  // where an edge meets a plane, be it on the planes of the cell
      const Int3 p = point(), q = point(), a = point(), b = point(), c = point();
      const Plane plane = plane_through(a, b, c);
      sound = sound && side_of_plane(plane, p) * side_of_plane(plane, q) < 0;
      if (!sound) break;
      h[k] = line_plane(p, q, plane);
      x[k] = approximate(h[k]);
    }
    if (!sound) continue;
    ++seen;
    const PointRef from{&x[0], &h[0]}, to{&x[1], &h[1]};
    const EdgeSigns signs = edge_about_corners(from, to, -1, cell), back = edge_about_corners(to, from, -1, cell);
    for (int axis = 0; axis < 3; ++axis)
      for (int corner = 0; corner < 4; ++corner) {
        ASSERT_EQ(signs.of(axis, corner),
                  edge_about_corner(from, to, axis, cell.edge_corner[size_t(axis)][size_t(corner)]))
            << n;
        ASSERT_EQ(back.of(axis, corner), -signs.of(axis, corner)) << n;
      }
  }
  EXPECT_GT(seen, 300);
}

}  // namespace test_lattice_signs
}  // namespace limberg
