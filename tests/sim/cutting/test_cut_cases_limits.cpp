// The named cases 38 and 40 to 44: taking back, long histories,
// bad input, limits of the numbers, strokes across themselves.
#include <limits>

#include "sim/base/error.h"
#include "sim/cutting/arrangement/fault.h"
#include "sim/geometry/validate.h"
#include "tests/sim/cutting/case_scene.h"
#include "tests/sim/cutting/patient.h"

namespace limberg::test {
namespace test_cut_cases_limits {

// Every case is taken back and made again step by step (CaseScene::take_back). Here a longer history, at random.
CUT_CASE(C38_undo_and_redo, wavy_case_slab()) {
  uint64_t r = 42;
  const auto real = [&](double lo, double hi) {
    r = r * 6364136223846793005ull + 1442695040888963407ull;
    return lo + (hi - lo) * double(r >> 33) * 0x1p-31;
  };
  for (int i = 0; i < 8; ++i) {
    const Vec2 p(real(-20, 20), real(-20, 20)), q(real(-20, 20), real(-20, 20));
    if (i % 3 == 2)
      s.attempt(sheet({p.x() - 6, p.y() - 6, -real(2, 9)}, {12, 0, real(-1, 1)}, {0, 12, real(-1, 1)}, 5, 5));
    else
      s.attempt(strip({p, q}, 3, -real(2, 10), false, 3));
    if (s.a.pieces() > 1) s.sweep(5);
  }
}

// The work of a cut, in exact signs and steps, is that of what it meets, not of what was cut before.
TEST(CutCases, C40_two_hundred_cuts) {
  Arrangement a(wavy_slab(120, 12, 40, 0.8), grid());
  FaultPlan count;
  a.set_fault(&count);
  std::vector<double> work;
  uint64_t r = 7;
  const auto real = [&](double lo, double hi) {
    r = r * 6364136223846793005ull + 1442695040888963407ull;
    return lo + (hi - lo) * double(r >> 33) * 0x1p-31;
  };
  while (work.size() < 200) {
    const Vec2 p(real(-52, 52), real(-52, 52));
    const double t = real(0, 6.28);
    count.calls = 0;
    const CutResult c = a.cut(strip({p, p + 5 * Vec2(std::cos(t), std::sin(t))}, 3, -4, false, 2), 1 + work.size());
    ASSERT_NE(c.status, CutResult::refused) << c.reason;
    if (c.ok()) work.push_back(double(count.calls) / double(c.tries));
  }
  a.set_fault(nullptr);
  EXPECT_EQ(a.check_all(), "");
  double first = 0, last = 0;
  for (size_t i = 0; i < 20; ++i) first += work[i], last += work[180 + i];
  EXPECT_LE(last, 1.5 * first);
  std::printf("work of cuts 181-200 over cuts 1-20: %.2f\n", last / first);
}

TEST(CutCases, C41_bad_strokes) {
  Patient p(2);
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  for (const std::vector<Vec2>& path :
       {std::vector<Vec2>{}, std::vector<Vec2>{{1, 1}}, std::vector<Vec2>{{1, 1}, {1, 1}, {1, 1}},
        std::vector<Vec2>{{nan, 0}, {3, 3}}, std::vector<Vec2>{{0, 0}, {inf, 3}},
        std::vector<Vec2>{{200, 200}, {230, 200}}, std::vector<Vec2>{{0, 0}, {1e300, -1e300}}})
    for (double depth : {4.0, nan, -1.0, 0.0, inf}) EXPECT_FALSE(p.incise(path, depth).ok());  // incise checks the hash
  for (double depth : {nan, -1.0, 0.0}) EXPECT_FALSE(p.incise({{-5, 0}, {5, 0}}, depth).ok());
  Blade odd = strip({{-5, 0}, {5, 0}}, 2, -3), far = odd, none, unknown = odd, flat = odd;
  odd.vertex[0].x |= 1;
  far.vertex[0].x = 1 << 22;
  unknown.tri[0][0] = 99;
  flat.vertex[1] = flat.vertex[0];
  const uint64_t hash = p.a.full_hash();
  for (const Blade* b : {&odd, &far, &none, &unknown}) {
    const CutResult c = p.a.cut(*b, 1);
    EXPECT_EQ(c.status, CutResult::refused);
    EXPECT_NE(c.reason, "");
    EXPECT_EQ(p.a.full_hash(), hash);
  }
  p.a.cut(flat, 1);  // the jitter may give it an area
  EXPECT_EQ(p.a.check_all(), "");
}

TEST(CutCases, C42_bodies_that_are_none) {
  const auto refused = [](const TriMesh& m) {
    try {
      validate_surface(m, grid(), "body.obj");
    } catch (const InputError& e) {
      return std::string(e.what()).find("triangle") != std::string::npos;  // where
    }
    return false;
  };
  EXPECT_FALSE(refused(case_slab()));
  TriMesh open = case_slab();
  open.tri.pop_back(), open.tag.pop_back(), open.uv.pop_back();
  EXPECT_TRUE(refused(open));
  EXPECT_THROW(Arrangement(open, grid()), InputError);
  TriMesh turned = case_slab();
  std::swap(turned.tri[5][0], turned.tri[5][1]);
  EXPECT_TRUE(refused(turned));
  EXPECT_THROW(Arrangement(turned, grid()), InputError);
  TriMesh fin = case_slab();  // three triangles at an edge
  fin.tri.push_back({fin.tri[0][0], fin.tri[0][1], int32_t(fin.X_mm.size() - 1)});
  fin.tag.push_back(SurfaceTag::skin), fin.uv.push_back({});
  EXPECT_TRUE(refused(fin));
  EXPECT_THROW(Arrangement(fin, grid()), InputError);
  TriMesh through = case_slab();  // a vertex of the skin pulled down through the bottom
  through.X_mm[200].z() = -14;
  EXPECT_TRUE(refused(through));
}

// A body that fills the domain, cut at its borders.
TriMesh at_the_limit() {
  const double half = grid().half_unit_mm() * (RestGrid::kMaxCoordinate - 2000);
  return flat_slab(2 * half, 2 * half, 0.9 * half, 8, 8);
}
CUT_CASE(C43_coordinates_at_the_limit, at_the_limit(), lattice_over(at_the_limit(), 60, 0.001)) {
  const double far = grid().half_unit_mm() * (RestGrid::kMaxCoordinate - 600);
  s.cut(strip({{-far, -far}, {far, far}}, 5, -far, false, 400));
  s.expect(2, {2, 2});
  s.cut(strip({{-far, far}, {far, -far}}, 5, -far, false, 400));
  s.expect(4, {2, 2, 2, 2});
  s.cut(sheet({-far, -far, -40}, {2 * far, 0, 3}, {0, 2 * far, -5}, 1, 1));
  s.expect(8, Chi(8, 2));
  EXPECT_FALSE(s.attempt(strip({{-far, 3}, {far * 1.01, 5}}, 5, -far, false, 400)));  // beyond
}

TEST(CutCases, C44_stroke_across_itself) {
  std::vector<Vec2> eight;
  for (int i = 0; i <= 48; ++i) {
    const double t = 2 * std::acos(-1.0) * i / 48;
    eight.push_back({16 * std::sin(t), 9 * std::sin(2 * t)});
  }
  for (double depth : {4.0, 12.0}) {
    Patient p(2);
    const uint64_t hash = p.a.full_hash();
    const CutResult r = p.incise(eight, depth);
    ASSERT_TRUE(r.ok()) << r.reason;
    EXPECT_EQ(p.a.pieces(), depth > 10 ? 3 : 1);
    for (int i = 0; i < p.cuts; ++i) p.a.undo();
    EXPECT_EQ(p.a.full_hash(), hash);
  }
}

}  // namespace test_cut_cases_limits
}  // namespace limberg::test
