// What the method rests on, tried: the embedding test is needed; every sign is the one that rational arithmetic gives;
// shared edges that others have crossed; several walls through one identical line; strongly curved blades.
#include <gtest/gtest.h>

#include <boost/multiprecision/cpp_int.hpp>
#include <map>

#include "app/program/places.h"
#include "tests/bench/fuzz/generator.h"
#include "tests/sim/cutting/case_scene.h"

namespace limberg::test {
namespace test_cut_proofs {

// --- The embedding test ----------------------------------------------------------------------------------------------

// Found at random with the test off, and made small. With it, the same blades are redrawn or refused.
TEST(Proof, TheEmbeddingTestIsNeeded) {
  for (const char* name : {"blade_through_itself_1", "blade_through_itself_2"}) {
    const fuzz::Case c = fuzz::read_case(source_dir() + "/tests/sim/cutting/corpus/" + name + ".json");
    fuzz::Settings off;
    off.skip_embedding = true;
    EXPECT_NE(fuzz::run_case(c, off).violation, "");
    EXPECT_EQ(fuzz::run_case(c, {}).violation, "");
  }
}

// --- Rational recomputation ------------------------------------------------------------------------------------------

using Rational = boost::multiprecision::cpp_rational;
using Integer = boost::multiprecision::cpp_int;

Integer big(int128 v) {
  const bool negative = v < 0;
  const uint128 m = negative ? -uint128(v) : uint128(v);
  Integer r = uint64_t(m >> 64);
  r <<= 64;
  r += uint64_t(m);
  return negative ? Integer(-r) : r;
}
Integer big(const Int256& v) {
  const bool negative = v.negative();
  const Int256 m = negative ? -v : v;
  Integer r = 0;
  for (int i = 3; i >= 0; --i) r = (r << 64) + m.limb[size_t(i)];
  return negative ? Integer(-r) : r;
}
std::array<Rational, 3> place(const PointRef& p) {
  std::array<Rational, 3> x;
  for (size_t k = 0; k < 3; ++k)
    x[k] = p.implicit() ? Rational(big(p.exact().x[k]), big(p.exact().w))
                        : Rational(Integer(int64_t((*p.approx)[int(k)])));
  return x;
}
int sign(const Rational& r) { return r > 0 ? 1 : r < 0 ? -1 : 0; }

struct Recheck : SignWatcher {
  int64_t signs = 0, wrong = 0, zeros = 0;
  void count(int found, int right) {
    ++signs;
    wrong += found != right;
    zeros += right == 0;
  }
  void side(const Plane& plane, const PointRef& p, int s) override {
    const auto x = place(p);
    Rational v = -Rational(big(plane.d));
    for (size_t k = 0; k < 3; ++k) v += x[k] * Integer(plane.n[k]);
    count(s, sign(v));
  }
  void turn(const Plane& plane, const PointRef& a, const PointRef& b, const PointRef& c, int s) override {
    const auto p = place(a), q = place(b), r = place(c);
    Rational v = 0;  // n . (b - a) x (c - a)
    for (size_t k = 0; k < 3; ++k) {
      const size_t i = (k + 1) % 3, j = (k + 2) % 3;
      v += Integer(plane.n[k]) * ((q[i] - p[i]) * (r[j] - p[j]) - (q[j] - p[j]) * (r[i] - p[i]));
    }
    count(s, sign(v));
  }
  void order(int axis, const PointRef& a, const PointRef& b, int s) override {
    count(s, sign(place(a)[size_t(axis)] - place(b)[size_t(axis)]));
  }
};

// 6 V of every component, exactly.
std::vector<Rational> volumes6(const Arrangement& a) {
  std::vector<Rational> v(a.components().size(), 0);
  for (int32_t f = 0; f < int32_t(a.faces().size()); ++f)
    for (int side = 0; side < 2; ++side) {
      const Face& face = a.faces()[size_t(f)];
      if (!face.has_side(side)) continue;
      const auto p = place(a.point(face.v[0])), q = place(a.point(face.v[1])), r = place(a.point(face.v[2]));
      Rational det = 0;
      for (size_t k = 0; k < 3; ++k) {
        const size_t i = (k + 1) % 3, j = (k + 2) % 3;
        det += p[k] * (q[i] * r[j] - q[j] * r[i]);
      }
      if (side == 0) det = -det;
      v[size_t(a.component_of(sided_face(f, side)))] += det;
    }
  return v;
}

// Points are what they are made of, and all decisions and volumes those of unbounded rational numbers.
TEST(Proof, EverySignAndVolumeAgainstRationals) {
  Recheck check;
  FaultPlan plan;
  plan.watch = &check;
  for (uint64_t seed = 1; seed <= 4; ++seed) {
    fuzz::Generator g(seed * 77, seed % 2 == 0);
    const fuzz::Case c = g.start();
    fuzz::Runner r(c, {0, false, false});
    Arrangement a(fuzz::make_body(c.body), grid());
    const std::vector<Rational> before = volumes6(a);
    a.set_fault(&plan);
    int made = 0;
    for (int32_t i = 0; i < 60 && made < 8; ++i) {
      const fuzz::Op op = g.next(r, i);
      if (op.kind != fuzz::Op::cut) continue;
      Blade b;
      b.vertex = op.vertex;
      b.tri = op.tri;
      b.seed = op.seed_of_tri;
      made += a.cut(b, op.seed).ok();
      r.apply(op);
    }
    EXPECT_GE(made, 6);
    const std::vector<Rational> after = volumes6(a);
    Rational sum = 0;
    const double unit = grid().half_unit_mm();
    for (size_t i = 0; i < after.size(); ++i) {
      sum += after[i];
      const double mm3 = after[i].convert_to<double>() * unit * unit * unit / 6;
      EXPECT_NEAR(a.components()[i].volume_mm3, mm3, 1e-9);
      EXPECT_EQ(a.components()[i].volume_mm3 > 0, after[i] > 0);
    }
    EXPECT_EQ(sum, before[0]);
    for (int32_t p = 0; p < a.point_count(); ++p)  // the doubles are where the points are
      for (size_t k = 0; k < 3; ++k)
        EXPECT_LT(std::abs((place(a.point(p))[k] - Rational((*a.point(p).approx)[int(k)])).convert_to<double>()),
                  2 * kApproximationError);
    a.set_fault(nullptr);
  }
  EXPECT_EQ(check.wrong, 0);
  EXPECT_GT(check.signs, 10000);
  std::printf("%lld signs, %lld zeros\n", (long long)check.signs, (long long)check.zeros);
}

// --- Shared edges ----------------------------------------------------------------------------------------------------

// The foot of a strip, shared by its own points, `drop` mm further down; columns [from, to].
Blade below(const Blade& strip_above, const CutResult& made, const Arrangement& a, size_t from, size_t to, double drop,
            double aside = 0) {
  Blade b;
  const int32_t by = int32_t(std::lround(drop * 8192)) * 2, off = int32_t(std::lround(aside * 8192)) * 2;
  (void)strip_above;
  for (size_t i = from; i <= to; ++i) {
    const int32_t id = made.blade_point[2 * i + 1];
    const Int3 p = a.explicit_point(id);
    b.vertex.push_back(p);
    b.shared_point.push_back(id);
    b.vertex.push_back({p.x + 2, p.y + off, p.z - by});
    b.shared_point.push_back(-1);
  }
  const int32_t n = int32_t(to - from);
  for (int32_t i = 0; i < n; ++i)
    b.tri.push_back({2 * i, 2 * i + 1, 2 * i + 3}), b.tri.push_back({2 * i, 2 * i + 3, 2 * i + 2});
  b.seed.assign(b.tri.size(), 2);
  return b;
}

TEST(Proof, SharedFrontsThatOtherWallsHaveCrossed) {
  for (const double across_depth : {-3.0, -5.0, -7.5}) {
    SCOPED_TRACE(across_depth);
    CaseScene s(case_slab());
    const Blade wall = strip({{-12.1, 0.3}, {12.2, 0.9}}, 2, -5);
    const CutResult made = s.cut(wall);
    s.cut(strip({{-4, -9}, {-3, 9.5}}, 2, across_depth));
    s.cut(strip({{5, -9.2}, {4, 9}}, 2, across_depth));
    s.cut(strip({{5.2, -8}, {-4.1, 8.3}}, 2, across_depth));
    s.cut(below(wall, made, s.a, 0, wall.vertex.size() / 2 - 1, 3));
    s.expect(1, {2});
    s.cut(strip({{0.4, -7}, {-0.7, 8}}, 2, -9));  // over the joint
    s.expect(1, {2});
    s.take_back();
  }
}

// Three and four walls of different operations hang on one identical line of points.
TEST(Proof, SeveralWallsThroughOneLine) {
  CaseScene s(case_slab());
  const Blade wall = strip({{-9.1, 0.3}, {9.2, 0.9}}, 2, -4);
  const CutResult made = s.cut(wall);
  const size_t last = wall.vertex.size() / 2 - 1;
  s.cut(below(wall, made, s.a, 0, last, 3, 0));
  s.expect(1, {2});
  s.cut(below(wall, made, s.a, 0, last, 2, 2.5));
  s.expect(1, {2});
  s.cut(below(wall, made, s.a, 1, last - 1, 2.2, -2.6));
  s.expect(1, {2});
  EXPECT_GT(s.wall_edges_with(4), 0);
  s.cut(strip({{1.3, -8}, {1.1, 8.2}}, 2, -9));  // and one across them all
  s.expect(1, {2});
  s.cut(strip({{-40, -1.1}, {40, 1.7}}, 3, -20));
  EXPECT_GE(s.a.pieces(), 2);
  s.take_back();
}

// --- Several pieces of one cell divided again ------------------------------------------------------------------------

// Parents are named by union of new walls' sides and what has stayed. Here, exactly: each piece of a cell lies in the
// parent that a point inside it had before.
TEST(Proof, ParentsOfSeveralPiecesInOneCell) {
  for (uint64_t seed = 1; seed <= 6; ++seed) {
    SCOPED_TRACE(seed);
    CaseScene s(wavy_case_slab(), lattice_over(wavy_case_slab(), 14, 0.1 * double(seed)));
    uint64_t r = seed;
    const auto real = [&](double lo, double hi) {
      r = r * 6364136223846793005ull + 1442695040888963407ull;
      return lo + (hi - lo) * double(r >> 33) * 0x1p-31;
    };
    for (int i = 0; i < 6; ++i) {  // many pieces per cell; then walls that divide every face of them again
      const double t = real(0, 3.14);
      const Vec2 c(real(-6, 6), real(-6, 6)), d(60 * std::cos(t), 60 * std::sin(t));
      const auto before = s.t;
      const Arrangement& a = s.a;
      // Which old class holds each old sided face's middle: remembered by place.
      std::map<std::pair<int32_t, int32_t>, int32_t> old;  // (cell, sided face) -> old copy
      for (size_t cell = 0; cell < before->components.size(); ++cell)
        if (before->components[cell])
          for (int32_t f : before->components[cell]->face)
            for (int side = 0; side < 2; ++side)
              if (const int k = before->components[cell]->class_of(sided_face(f, side)); k >= 0)
                old[{int32_t(cell), sided_face(f, side)}] = before->copy(int32_t(cell), k);
      s.cut(strip({c - d, c + d}, 3, -20, false, 200));
      // A new face of an old triangle lies in exactly one of the faces that it was divided from.
      for (size_t cell = 0; cell < s.t->components.size(); ++cell) {
        if (!s.t->components[cell]) continue;
        for (int32_t f : s.t->components[cell]->face)
          for (int side = 0; side < 2; ++side) {
            const int k = s.t->components[cell]->class_of(sided_face(f, side));
            if (k < 0) continue;
            const int32_t parent = s.t->cell_parent[size_t(s.t->copy(int32_t(cell), k))];
            const int32_t orig = a.faces()[size_t(f)].orig;
            if (a.orig_tris()[size_t(orig)].op == s.last.op) continue;
            // Ancestors: old faces of the same triangle, in the same cell, that overlap it.
            bool any = false, found = false;
            for (int32_t o : before->components[cell] ? before->components[cell]->face : std::vector<int32_t>()) {
              if (a.faces()[size_t(o)].orig != orig) continue;
              bool overlap = true;  // f's middle in o (doubles: far from edges or not at all)
              const Vec3 m = s.centre(f),
                         n = (a.point_mm(a.faces()[size_t(o)].v[1]) - a.point_mm(a.faces()[size_t(o)].v[0]))
                                 .cross(a.point_mm(a.faces()[size_t(o)].v[2]) - a.point_mm(a.faces()[size_t(o)].v[0]));
              for (size_t e = 0; e < 3; ++e) {
                const Vec3 p = a.point_mm(a.faces()[size_t(o)].v[e]),
                           q = a.point_mm(a.faces()[size_t(o)].v[(e + 1) % 3]);
                overlap = overlap && (q - p).cross(m - p).dot(n) > 0;
              }
              const auto it = old.find({int32_t(cell), sided_face(o, side)});
              if (!overlap || it == old.end()) continue;
              any = true;
              found = found || it->second == parent;
            }
            if (any) {
              EXPECT_TRUE(found) << "cell " << cell << " face " << f;
            }
          }
      }
    }
    EXPECT_GT(s.t->cells.size(), 40u);
  }
}

// --- Strongly curved blades ------------------------------------------------------------------------------------------

TEST(Proof, StronglyCurvedBlades) {
  const double pi = std::acos(-1.0);
  {  // a spoon: most of a sphere, out through the skin
    CaseScene s(case_slab());
    Blade b;
    const int rings = 10, around = 20;
    const Vec3 c(1.1, 0.7, -3.1);
    for (int i = 0; i <= rings; ++i)
      for (int j = 0; j < around; ++j) {
        const double t = pi * (0.16 + 0.80 * i / rings), u = 2 * pi * (j + 0.5 * (i % 2)) / around;
        const Vec3 p = c + 5.2 * Vec3(std::sin(t) * std::cos(u), std::sin(t) * std::sin(u), std::cos(t));
        b.vertex.push_back(at(p.x(), p.y(), p.z()));
      }
    b.vertex.push_back(at(c.x(), c.y(), c.z() - 5.2));
    for (int32_t i = 0; i < rings; ++i)
      for (int32_t j = 0; j < around; ++j) {
        const int32_t k = (j + 1) % around, p = i * around, q = p + around;
        b.tri.push_back({p + j, q + j, q + k});
        b.tri.push_back({p + j, q + k, p + k});
      }
    for (int32_t j = 0; j < around; ++j)
      b.tri.push_back({rings * around + j, int32_t(b.vertex.size()) - 1, rings * around + (j + 1) % around});
    b.seed.assign(b.tri.size(), 2);
    // Odd rows are turned by half a step: quads there are twisted, so test what is there, not what was meant.
    if (s.attempt(b)) {
      EXPECT_EQ(s.a.pieces(), 2);
      s.excise_at({1.1, 0.7, -3});
      s.expect(1, {2});
    } else {
      ADD_FAILURE() << s.last.reason;
    }
    s.take_back();
  }
  {  // a spiral of three turns, 0.8 mm apart
    CaseScene s(case_slab());
    std::vector<Vec2> path;
    for (int i = 0; i <= 90; ++i) {
      const double t = 6 * pi * i / 90;
      path.push_back((1.5 + 0.8 * t / (2 * pi)) * Vec2(std::cos(t), std::sin(t)) + Vec2(0.37, 0.21));
    }
    s.cut(strip(path, 2, -5));
    s.expect(1, {2});
    EXPECT_EQ(s.fronts(), 1);
    s.cut(
        sheet({-5, -5, -4}, {10.4, 0, 0}, {0, 10.7, 0}, 8, 8));  // the post below it comes off in no more than one ring
    s.take_back();
  }
  {  // a screw: a sheet that winds about its own axis
    CaseScene s(case_slab());
    Blade b;
    for (int i = 0; i <= 24; ++i) {
      const double t = 1.5 * pi * i / 24;
      for (double r : {-4.0, 4.0})
        b.vertex.push_back(at(0.3 + r * std::cos(t), 0.2 + r * std::sin(t), 2 - 9.0 * i / 24));
    }
    for (int32_t i = 0; i < 24; ++i)
      b.tri.push_back({2 * i, 2 * i + 1, 2 * i + 3}), b.tri.push_back({2 * i, 2 * i + 3, 2 * i + 2});
    b.seed.assign(b.tri.size(), 2);
    s.cut(b);
    s.expect(1, {2});
    s.take_back();
  }
}

}  // namespace test_cut_proofs
}  // namespace limberg::test
