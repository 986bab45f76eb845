// Wide integers and predicates against arbitrary-precision integers, with extreme coordinates for the bit budgets.
#include <gtest/gtest.h>

#include <boost/multiprecision/cpp_int.hpp>
#include <random>

#include "sim/cutting/arrangement/tri_tests.h"
#include "sim/geometry/exact/predicates.h"
#include "sim/geometry/rest_grid.h"

namespace limberg::test {
namespace test_exact {

using Big = boost::multiprecision::cpp_int;

template <int N>
Big big(const WideInt<N>& v) {
  const bool negative = v.negative();
  const WideInt<N> m = negative ? -v : v;
  Big r = 0;
  for (int i = N - 1; i >= 0; --i) r = (r << 64) + m.limb[size_t(i)];
  return negative ? Big(-r) : r;
}

template <int N>
WideInt<N> random_wide(std::mt19937_64& random, int bits) {
  WideInt<N> w;
  for (int i = 0; i < N; ++i) {
    const int left = bits - 64 * i;
    if (left > 0) w.limb[size_t(i)] = random() >> (left >= 64 ? 0 : 64 - left);
  }
  return random() & 1 ? -w : w;
}

TEST(WideInt, AgreesWithArbitraryPrecision) {
  std::mt19937_64 random(1);
  for (int round = 0; round < 20000; ++round) {
    const auto a = random_wide<4>(random, int(random() % 254)), b = random_wide<4>(random, int(random() % 254));
    ASSERT_EQ(big(a + b), Big(big(a) + big(b)));
    ASSERT_EQ(big(a - b), Big(big(a) - big(b)));
    ASSERT_EQ(big(-a), Big(-big(a)));
    ASSERT_EQ(big(multiply<8>(a, b)), Big(big(a) * big(b)));
    ASSERT_EQ(a.sign(), big(a).sign());
    ASSERT_EQ(a < b, big(a) < big(b));
    const Big m = abs(big(a));
    ASSERT_EQ(a.bit_length(), m == 0 ? 0 : int(msb(m)) + 1);
    const double exact = a.sign() != 0 ? big(a).convert_to<double>() : 1, rounded = a.sign() != 0 ? a.to_double() : 1;
    ASSERT_NEAR(rounded / exact, 1.0, 0x1p-51);
    constexpr uint64_t p = (uint64_t(1) << 61) - 1;
    Big r = big(a) % p;
    if (r < 0) r += p;
    ASSERT_EQ(Big(a.mod(p)), r);
  }
}

TEST(WideInt, FromBuiltIn) {
  for (const int64_t v : {int64_t(0), int64_t(1), int64_t(-1), INT64_MAX, INT64_MIN}) {
    EXPECT_EQ(big(WideInt<4>(v)), Big(v));
    EXPECT_EQ(big(WideInt<2>(int128(v) * 3)), Big(Big(v) * 3));
    EXPECT_EQ(big(WideInt<8>(WideInt<2>(int128(v) * 5))), Big(Big(v) * 5));
  }
}

// --- Predicates against the same formulas in arbitrary precision
// ------------------------------------------------------

using BigPoint = std::array<Big, 4>;  // homogeneous

struct Sample {
  Vec3 approx;
  Homogeneous h;
  bool implicit = false;
  PointRef ref() const { return {&approx, nullptr, implicit ? &h : nullptr}; }
  BigPoint exact() const { return {big(h.x[0]), big(h.x[1]), big(h.x[2]), big(h.w)}; }
};

Int3 random_point(std::mt19937_64& random, int32_t limit) {
  const auto c = [&] {
    // Extremes are common.
    const int32_t r = int32_t(random() % uint64_t(limit + 1));
    const int32_t v = random() % 3 == 0 ? limit : r;
    return (random() & 1 ? v : -v) / 2 * 2;
  };
  return {c(), c(), c()};
}

Plane random_plane(std::mt19937_64& random, int32_t limit) {
  for (;;) {
    const Plane p =
        plane_through(random_point(random, limit), random_point(random, limit), random_point(random, limit));
    if (p.n[0] != 0 || p.n[1] != 0 || p.n[2] != 0) return p;
  }
}

int big_side(const Plane& p, const BigPoint& x) {
  const Big d = (Big(int64_t(p.d >> 64)) << 64) + Big(uint64_t(p.d));
  return Big(x[0] * p.n[0] + x[1] * p.n[1] + x[2] * p.n[2] - x[3] * d).sign();
}

TEST(Predicates, PlaneSideAndOrderAndBudgets) {
  std::mt19937_64 random(2);
  int widest_w = 0, widest_x = 0;
  for (const int32_t limit : {RestGrid::kMaxCoordinate, 2000, 8}) {
    for (int round = 0; round < 4000; ++round) {
      const Plane a = random_plane(random, limit), b = random_plane(random, limit), c = random_plane(random, limit),
                  d = random_plane(random, limit);
      Sample p, q;
      p.h = three_planes(a, b, c);
      if (p.h.w.sign() == 0) continue;
      widest_w = std::max(widest_w, p.h.w.bit_length());
      for (const Int256& x : p.h.x) widest_x = std::max(widest_x, x.bit_length());
      ASSERT_GT(p.h.w.sign(), 0);
      p.implicit = true;
      p.approx = approximate(p.h);
      if (p.approx.cwiseAbs().maxCoeff() > 2 * limit) continue;  // points lie within the domain
      for (const Plane* plane : {&a, &b, &c}) ASSERT_EQ(side_of_plane(*plane, p.ref()), 0);
      ASSERT_EQ(side_of_plane(d, p.ref()), big_side(d, p.exact()));
      const Int3 u = random_point(random, limit), v = random_point(random, limit);
      const Plane e = random_plane(random, limit);
      const int su = side_of_plane(e, u), sv = side_of_plane(e, v);
      if (su * sv >= 0) continue;
      const NarrowHomogeneous narrow = line_plane(u, v, e);
      q.h = widened(narrow);
      q.implicit = true;
      q.approx = approximate(narrow);
      ASSERT_EQ(q.approx, approximate(q.h));
      ASSERT_EQ(side_of_plane(d, PointRef{&q.approx, &narrow}), side_of_plane(d, q.ref()));
      ASSERT_LE(q.h.w.bit_length(), 69);
      ASSERT_EQ(side_of_plane(e, q.ref()), 0);
      ASSERT_EQ(side_of_plane(d, q.ref()), big_side(d, q.exact()));
      for (int axis = 0; axis < 3; ++axis) {
        const BigPoint x = p.exact(), y = q.exact();
        ASSERT_EQ(compare_coordinate(axis, p.ref(), q.ref()),
                  Big(x[size_t(axis)] * y[3] - y[size_t(axis)] * x[3]).sign());
        ASSERT_NEAR(q.approx[axis], (Big(y[size_t(axis)] * 1024 / y[3])).convert_to<double>() / 1024,
                    0x1p-10 + kApproximationError);
      }
    }
  }
  EXPECT_LE(widest_w, 138);
  EXPECT_LE(widest_x, 162);
  EXPECT_GT(widest_w, 125);  // the extremes really were reached for
}

TEST(Predicates, Orient2d) {
  std::mt19937_64 random(3);
  int zeros = 0, signs = 0;
  for (const int32_t limit : {RestGrid::kMaxCoordinate, 64, 6}) {
    for (int round = 0; round < 4000; ++round) {
      const Plane f = random_plane(random, limit);
      std::array<Sample, 3> s;
      bool ok = true;
      std::array<Plane, 3> other;
      for (Plane& p : other) p = random_plane(random, limit);
      const Plane common = random_plane(random, limit);
      for (size_t i = 0; i < 3 && ok; ++i) {
        // Every third case has all three points on one line of the plane: an exact zero.
        s[i].h = three_planes(f, other[i], round % 3 == 0 ? common : other[(i + 1) % 3]);
        ok = s[i].h.w.sign() != 0;
        s[i].implicit = true;
        if (ok) s[i].approx = approximate(s[i].h);
        ok = ok && s[i].approx.cwiseAbs().maxCoeff() <= 2 * limit;
      }
      if (!ok) continue;
      const int drop = projection_axis(f), i = (drop + 1) % 3, j = (drop + 2) % 3;
      std::array<BigPoint, 3> x;
      for (size_t k = 0; k < 3; ++k) x[k] = s[k].exact();
      Big det = 0;
      for (size_t k = 0; k < 3; ++k) {
        const auto &a = x[k], &b = x[(k + 1) % 3], &c = x[(k + 2) % 3];
        det += a[size_t(i)] * (b[size_t(j)] * c[3] - b[3] * c[size_t(j)]);
      }
      const int expected = det.sign() * (f.n[size_t(drop)] > 0 ? 1 : -1);
      ASSERT_EQ(orient2d(f, s[0].ref(), s[1].ref(), s[2].ref()), expected);
      (expected == 0 ? zeros : signs)++;
    }
  }
  EXPECT_GT(zeros, 100);
  EXPECT_GT(signs, 1000);
}

TEST(Predicates, Orient3dAndPlaneAgree) {
  std::mt19937_64 random(4);
  for (int round = 0; round < 20000; ++round) {
    const int32_t limit = round % 2 ? 6 : RestGrid::kMaxCoordinate;
    const Int3 a = random_point(random, limit), b = random_point(random, limit), c = random_point(random, limit),
               d = random_point(random, limit);
    const Big ux = Big(b.x) - a.x, uy = Big(b.y) - a.y, uz = Big(b.z) - a.z, vx = Big(c.x) - a.x, vy = Big(c.y) - a.y,
              vz = Big(c.z) - a.z, wx = Big(d.x) - a.x, wy = Big(d.y) - a.y, wz = Big(d.z) - a.z;
    const int expected = Big((uy * vz - uz * vy) * wx + (uz * vx - ux * vz) * wy + (ux * vy - uy * vx) * wz).sign();
    ASSERT_EQ(orient3d(a, b, c, d), expected);
    ASSERT_EQ(side_of_plane(plane_through(a, b, c), d), expected);
  }
}

// --- Triangles
// ----------------------------------------------------------------------------------------------------------

IntTriangle triangle(std::array<Int3, 3> p, std::array<int32_t, 3> id) { return {p, id}; }

TEST(TriangleTests, SharedVerticesAndEdges) {
  const Int3 o{0, 0, 0}, x{8, 0, 0}, y{0, 8, 0}, z{0, 0, 8}, xy{8, 8, 0}, in{2, 2, 0}, far{-8, -2, 0};
  const IntTriangle base = triangle({o, x, y}, {0, 1, 2});
  EXPECT_FALSE(meet_beyond_shared(base, triangle({x, xy, y}, {1, 3, 2})));             // coplanar neighbours
  EXPECT_TRUE(meet_beyond_shared(base, triangle({x, y, in}, {1, 2, 3})));              // folded flat onto it
  EXPECT_FALSE(meet_beyond_shared(base, triangle({x, y, z}, {1, 2, 3})));              // folded up
  EXPECT_FALSE(meet_beyond_shared(base, triangle({o, far, z}, {0, 3, 4})));            // one vertex, pointing away
  EXPECT_FALSE(meet_beyond_shared(base, triangle({o, far, {-2, -8, 0}}, {0, 3, 4})));  // the same, coplanar
  EXPECT_FALSE(meet_beyond_shared(base, triangle({o, {-8, 0, 0}, {0, -8, 0}}, {0, 3, 4})));  // coplanar, edges in line
  EXPECT_TRUE(meet_beyond_shared(base, triangle({o, {4, 0, 0}, {0, -8, 0}}, {0, 3, 4})));    // along the same edge
  EXPECT_TRUE(meet_beyond_shared(base, triangle({o, in, far}, {0, 3, 4})));  // one vertex, coplanar, overlapping
  EXPECT_TRUE(
      meet_beyond_shared(base, triangle({o, {4, 4, 4}, {4, 4, -4}}, {0, 3, 4})));  // one vertex, cutting through
  EXPECT_TRUE(meet_beyond_shared(base, triangle({in, {2, 2, 8}, {4, 4, 8}}, {3, 4, 5})));  // touching from above
  EXPECT_FALSE(meet_beyond_shared(base, triangle({Int3{2, 2, 2}, Int3{2, 2, 8}, Int3{4, 4, 8}}, {3, 4, 5})));
  EXPECT_TRUE(meet_beyond_shared(base, triangle({o, x, y}, {3, 4, 5})));  // equal places, not shared by name
}

TEST(TriangleTests, EdgesInOneLineMeetWhereTheyOverlapOnly) {
  const Int3 a{0, 0, 0}, b{0, 4, 0}, c{5, 1, 7};
  const IntTriangle base = triangle({a, b, c}, {0, 1, 2});
  const auto on_line = [&](int from, int to) {
    return meet_beyond_shared(base, triangle({Int3{0, from, 0}, Int3{0, to, 0}, Int3{-5, 1, 9}}, {3, 4, 5}));
  };
  EXPECT_FALSE(on_line(5, 9));
  EXPECT_FALSE(on_line(-9, -1));
  EXPECT_TRUE(on_line(4, 9));
  EXPECT_TRUE(on_line(3, 9));
  EXPECT_TRUE(on_line(-3, 9));
  EXPECT_TRUE(on_line(1, 2));
}

// Closed triangles are apart where a normal of one, a normal to an edge of both, or one in a triangle's plane separates
// them (separating axes: Gottschalk, Lin and Manocha 1996). On so small a grid most meet in some coincidence.
TEST(TriangleTests, ApartAsSeparatingAxesSay) {
  using V = std::array<int64_t, 3>;
  const auto minus = [](const Int3& p, const Int3& q) { return V{p.x - q.x, p.y - q.y, p.z - q.z}; };
  const auto cross = [](const V& p, const V& q) {
    return V{p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]};
  };
  std::mt19937_64 random(11);
  int met = 0, apart = 0;
  for (int round = 0; round < 100000; ++round) {
    std::array<Int3, 3> a, b;
    for (size_t i = 0; i < 3; ++i) a[i] = random_point(random, 2), b[i] = random_point(random, 2);
    std::vector<V> axes;
    const auto edges = [&](const std::array<Int3, 3>& t) {
      return std::array<V, 3>{minus(t[1], t[0]), minus(t[2], t[1]), minus(t[0], t[2])};
    };
    const auto ea = edges(a), eb = edges(b);
    const V na = cross(ea[0], ea[1]), nb = cross(eb[0], eb[1]);
    if (na == V{} || nb == V{}) continue;
    axes = {na, nb};
    for (const V& e : ea) axes.push_back(cross(na, e));
    for (const V& e : eb) axes.push_back(cross(nb, e));
    for (const V& e : ea)
      for (const V& f : eb) axes.push_back(cross(e, f));
    const bool separate = std::any_of(axes.begin(), axes.end(), [&](const V& n) {
      const auto along = [&](const Int3& p) { return n[0] * p.x + n[1] * p.y + n[2] * p.z; };
      const auto [al, ah] = std::minmax({along(a[0]), along(a[1]), along(a[2])});
      const auto [bl, bh] = std::minmax({along(b[0]), along(b[1]), along(b[2])});
      return ah < bl || bh < al;
    });
    ASSERT_EQ(meet_beyond_shared(triangle(a, {0, 1, 2}), triangle(b, {3, 4, 5})), !separate) << round;
    ++(separate ? apart : met);
  }
  EXPECT_GT(met, 10000);
  EXPECT_GT(apart, 10000);
}

TEST(TriangleTests, CrossingHasTwoEndsAndIsSymmetric) {
  std::mt19937_64 random(5);
  int crossings = 0;
  for (int round = 0; round < 20000; ++round) {
    std::array<Int3, 3> a, b;
    for (size_t i = 0; i < 3; ++i) a[i] = random_point(random, 1000), b[i] = random_point(random, 1000);
    const Plane pa = plane_through(a[0], a[1], a[2]), pb = plane_through(b[0], b[1], b[2]);
    if (pa.n == std::array<int64_t, 3>{} || pb.n == std::array<int64_t, 3>{}) continue;
    const IntTriangle s = triangle(a, {0, 1, 2}), t = triangle(b, {3, 4, 5});
    const Crossing c = cross_triangles(s, pa, t, pb), d = cross_triangles(t, pb, s, pa);
    ASSERT_EQ(c.kind, d.kind);
    if (c.kind == Crossing::crossing) {
      ++crossings;
      ASSERT_TRUE(meet_beyond_shared(s, t));
      ASSERT_EQ(int(c.end[0].edge_of_s) + int(c.end[1].edge_of_s),
                2 - int(d.end[0].edge_of_s) - int(d.end[1].edge_of_s));
    } else if (c.kind == Crossing::apart) {
      ASSERT_FALSE(meet_beyond_shared(s, t));
    }
  }
  EXPECT_GT(crossings, 1000);
}

TEST(TriangleTests, RegularGridsAreEmbedded) {
  std::vector<Int3> v;
  std::vector<Tri> t;
  for (int j = 0; j < 6; ++j)
    for (int i = 0; i < 6; ++i)
      v.push_back({8 * i, j < 3 ? 8 * j : 16, j < 3 ? 0 : 8 * (j - 2)});  // a floor and a wall
  for (int32_t j = 0; j < 5; ++j)
    for (int32_t i = 0; i < 5; ++i)
      t.push_back({6 * j + i, 6 * j + i + 1, 6 * j + i + 7}), t.push_back({6 * j + i, 6 * j + i + 7, 6 * j + i + 6});
  EXPECT_EQ(check_embedded(v, t), "");
}

TEST(TriangleTests, EmbeddedStripsAndFolds) {
  std::vector<Int3> v{{0, 0, 0}, {0, 0, -20}, {20, 0, 0}, {20, 0, -20}, {40, 6, 0}, {40, 6, -20}};
  std::vector<Tri> t{{0, 1, 3}, {0, 3, 2}, {2, 3, 5}, {2, 5, 4}};
  EXPECT_EQ(check_embedded(v, t), "");
  v[4] = {10, 0, 0}, v[5] = {10, 0, -20};  // straight back over itself
  EXPECT_NE(check_embedded(v, t), "");
  v[4] = {40, 6, 0}, v[5] = {-10, -6, -20};  // twisted through itself
  v.push_back({-20, -12, -10}), t.push_back({4, 5, 6});
  EXPECT_NE(check_embedded(v, t), "");
}

}  // namespace test_exact
}  // namespace limberg::test
