// The named cases 17 to 23 and 29 to 37: flaps, cutting again, undermining, excision.
#include "sim/body/block.h"
#include "sim/body/skin.h"
#include "sim/cutting/strokes/drawn_stroke.h"
#include "tests/sim/cutting/case_scene.h"

namespace limberg::test {
namespace test_cut_cases_flaps {

/// A block cut by strokes on its skin.
struct Strokes {
  std::shared_ptr<const Body> body;
  Skin skin;
  static std::shared_ptr<const Body> block() {
    BlockSpec spec;
    spec.size_mm = {60, 60, 10};
    spec.skin_cell_mm = 2;
    return std::make_shared<const Body>(make_block(spec));
  }
  Strokes() : body(block()), skin(body) {}
  BladeContext on(const CaseScene& s) const {
    return {body.get(), &s.a, [this](const ChartPoint& p) { return skin.at(p); }};
  }
};
const Strokes& strokes() {
  static const Strokes made;  // immutable
  return made;
}
TriMesh block() { return strokes().body->surface; }

CutResult stroke(CaseScene& s, const std::vector<Vec2>& path, double depth) {
  return cut_whole(strokes().on(s), path, depth, 90, false, [&](const Blade& b) { return s.attempt(b), s.last; });
}
void incise(CaseScene& s, const std::vector<Vec2>& path, double depth) {
  const CutResult r = stroke(s, path, depth);
  ASSERT_TRUE(r.ok()) << r.reason;
}
void undermine(CaseScene& s, const std::vector<Vec2>& outline, double depth) {
  const BladeResult b = build_undermining(strokes().on(s), outline, depth);
  ASSERT_TRUE(b.blade) << b.reason;
  s.cut(*b.blade);
}

// The sheet under a triangular flap: a seeded middle and a skirt that reaches past the walls along its two free sides.
Blade under_flap(const Vec2& base1, const Vec2& tip, const Vec2& base2, double z) {
  const Vec2 m = 0.5 * (base1 + base2);
  Blade b;
  for (double scale : {0.96, 1.04})
    for (const Vec2& p : {base1, tip, base2}) {
      const Vec2 q = m + scale * (p - m);
      b.vertex.push_back(at(q.x(), q.y(), z));
    }
  b.tri = {{0, 1, 2}, {0, 3, 4}, {0, 4, 1}, {1, 4, 5}, {1, 5, 2}};
  b.seed = {2, 0, 0, 0, 0};
  return b;
}

CUT_CASE(C17_z_plasty, case_slab()) {
  // Limbs of 14 mm at 30, 45, 60 or 90 degrees to the central one; both triangles undermined.
  const auto z = [&](CaseScene& x, double degrees) {
    const double t = degrees * std::acos(-1.0) / 180, l = 14;
    const Vec2 up(0.21, l / 2), down(0.21, -l / 2), arm(l * std::sin(t), -l * std::cos(t));
    const Vec2 a = up + arm, b = down - arm, beyond = arm.normalized();
    x.cut(strip({a + beyond, up, down, b - beyond}, 3, -5));
    x.expect(1, {2});
    for (const Blade& sheet : {under_flap(a, up, down, -4), under_flap(up, down, b, -4.1)}) {
      x.cut(sheet);
      x.expect(1, {2});  // the flap is attached along its base
      double area = 0;
      for (int32_t f : x.a.last_operation().new_walls) area += std::abs(x.centre(f).z() + 4.05) < 0.1 ? x.area(f) : 0;
      EXPECT_NEAR(area, 0.5 * l * l * std::sin(t), 3e-3 * l * l) << degrees;  // the blade is redrawn within 8 um
    }
  };
  for (double degrees : {30.0, 45.0, 90.0}) {
    CaseScene other(case_slab());
    z(other, degrees);
  }
  z(s, 60);
}

CUT_CASE(C18_rhomboid_flap, wavy_case_slab()) {
  s.cut(open_box(kRhombus, 3, -6));
  s.excise_at({0, 0, 0});
  const std::vector<Vec2> flap{{0, 5.9}, {0, 17}, {10, 11}};
  Blade b = strip(flap, 3, -6.2);
  b.seed[0] = b.seed[1] = 0;
  s.cut(b);
  s.expect(1, {2});
  s.cut(sheet({-0.5, 2, -5.5}, {12, 0, 0}, {0, 16, 0}, 8, 10));
  s.expect(1, {2});
  EXPECT_GT(s.last.wall_faces, 50);
}

CUT_CASE(C19_recut_identical, wavy_case_slab()) {
  const Blade b = strip({{-20, 0.3}, {20, 1.1}}, 3, -6);
  s.cut(b);
  const uint64_t hash = s.a.full_hash();
  EXPECT_EQ(s.a.cut(b, 9).status, CutResult::nothing_to_cut);
  EXPECT_EQ(s.a.full_hash(), hash);
}

CUT_CASE(C20_recut_shallower_and_deeper, block()) {
  incise(s, {{-15, 0.3}, {15, 0.4}}, 4);
  const uint64_t hash = s.a.full_hash();
  const std::vector<int32_t> before = s.walls();
  const std::vector<Vec2> again{{-15, 0.3}, {15, 0.4}};
  EXPECT_EQ(stroke(s, again, 3).status, CutResult::nothing_to_cut);
  EXPECT_EQ(s.a.full_hash(), hash);
  ASSERT_TRUE(stroke(s, again, 7).ok());
  for (int32_t f : before) EXPECT_TRUE(s.a.faces()[size_t(f)].live());  // not even divided
  s.expect(1, {2});
  EXPECT_EQ(s.fronts(), 1);
}

CUT_CASE(C21_parallel_60_micrometres_away, case_slab()) {
  const double x = grid().to_mm(at(3.2, 0, 0)).x(), d = grid().to_mm(at(0.06, 0, 0)).x();
  s.cut(strip({{x, -40.31}, {x, 41.17}}, 3, -20, false, 200));
  s.cut(strip({{x + d, -40.31}, {x + d, 41.17}}, 3, -20, false, 200));
  ASSERT_EQ(s.last.tries, 1);
  s.expect(3, {2, 2, 2});  // the thin sheet is kept
  std::vector<double> v;
  for (const auto& c : s.a.components()) v.push_back(c.volume_mm3);
  EXPECT_NEAR(*std::min_element(v.begin(), v.end()), 720 * d, 1e-9);
  EXPECT_NEAR(*std::min_element(s.t->piece_volume_mm3.begin(), s.t->piece_volume_mm3.end()), 720 * d, 1e-6);
}

CUT_CASE(C22_across_a_wall_at_one_degree, wavy_case_slab()) {
  s.cut(strip({{-20, 0}, {20, 0}}, 3, -6));
  const double t = std::acos(-1.0) / 180;
  s.cut(strip({Vec2(-20 * std::cos(t), -20 * std::sin(t)), Vec2(20 * std::cos(t), 20 * std::sin(t))}, 3, -5));
  s.expect(1, {2});
  size_t segments = 0;
  for (const OrigTri& o : s.a.orig_tris())
    if (o.op == s.last.op) segments += s.a.constraints_of(int32_t(&o - s.a.orig_tris().data())).size();
  EXPECT_LE(s.a.last_operation().added.size(), 4 * segments + 4 * 2 * 27);  // and two per quad of the blade itself
}

CUT_CASE(C29_undermining_at_the_depth_of_the_incision, block()) {
  incise(s, {{-12, 0.3}, {12, 0.4}}, 4);
  undermine(s, {{-11, 0.3}, {11, 0.4}, {11, 10}, {-11, 10}}, 4);
  s.expect(1, {2});  // as with an overshoot: no bridge, which would be a handle
  incise(s, {{0.2, 0.35}, {0.5, 9.3}}, 8);
  double lowest = 0;
  for (int32_t f : s.a.last_operation().new_walls)
    for (int32_t p : s.a.faces()[size_t(f)].v) lowest = std::min(lowest, s.a.point_mm(p).z());
  EXPECT_GT(lowest, -4.1);  // across the flap, and not a bit of its bed
}

CUT_CASE(C30_undermining_overshoots, case_slab()) {
  s.cut(strip({{-15, 0.2}, {15, 0.2}}, 3, -5));
  std::vector<int32_t> far;
  for (int32_t f = 0; f < int32_t(s.a.faces().size()); ++f)
    if (s.a.faces()[f].live() && s.centre(f).y() < 0.1) far.push_back(s.a.faces()[f].orig);
  Blade b = sheet({-14, -0.3, -4}, {28, 0, 0}, {0, 12, 0}, 14, 15);
  for (size_t i = 0; i < 28; ++i) b.seed[i] = 0;  // the row that holds the wall
  s.cut(b);
  s.expect(1, {2});
  for (int32_t f : s.a.last_operation().new_walls) EXPECT_GT(s.centre(f).y(), 0.19);  // nothing beyond the wall
  // The far side keeps its triangles; the wall, which both sides share, is only divided further.
  for (int32_t o : far) EXPECT_GT(s.a.orig_tris()[size_t(o)].live, 0);
  for (int32_t f : s.a.last_operation().removed)
    if (s.a.orig_tris()[size_t(s.a.faces()[size_t(f)].orig)].op == 0) {
      EXPECT_GT(s.centre(f).y(), 0.1);
    }
}

CUT_CASE(C31_two_pockets_merge, case_slab()) {
  s.cut(strip({{-15, -9}, {15, -9.1}}, 3, -6));
  s.cut(strip({{-15, 9}, {15, 9.1}}, 3, -6));
  s.cut(sheet({-12, -9.4, -4}, {24, 0, 0}, {0, 8, 0}, 12, 4));
  s.cut(sheet({-12, 1.4, -4.02}, {24, 0, 0}, {0, 8, 0}, 12, 4));
  s.expect(1, {2});                                                  // a septum of 2.8 mm is left
  Blade b = sheet({-10, -2.4, -3.8}, {20, 0, 0}, {0, 5, 0}, 10, 3);  // dips below both between its edges
  for (Int3& v : b.vertex)
    if (std::abs(v.y) < at(0, 2, 0).y) v.z = at(0, 0, -4.2).z;
  s.cut(b);
  EXPECT_EQ(s.a.pieces(), 1);
  EXPECT_EQ(euler(s.a)[0], 0);  // one tunnel from incision to incision under the bridge
}

CUT_CASE(C32_cut_of_a_lifted_flap_only, case_slab()) {
  s.cut(strip({{-10, 0.2}, {10, 0.3}}, 2, -5));
  s.cut(sheet({-9, -0.1, -4}, {18, 0, 0}, {0, 12, 0}, 9, 6));
  std::vector<int32_t> bed;
  for (int32_t f = 0; f < int32_t(s.a.faces().size()); ++f)
    if (s.a.faces()[f].live() && s.centre(f).z() < -5.01) bed.push_back(f);
  const double sheet_area = [&] {
    double sum = 0;
    for (int32_t f : s.walls()) sum += s.area(f);
    return sum;
  }();
  s.cut(strip({{1, 0.1}, {1.3, 9}}, 2, -7));  // deep enough for flap and bed
  for (int32_t f : s.a.last_operation().new_walls) EXPECT_GT(s.centre(f).z(), -4.01);
  for (int32_t f : bed) EXPECT_TRUE(s.a.faces()[size_t(f)].live());
  // The pocket's own wall, one for both sides, is divided where the new one stands on it, and covers what it covered.
  double area = 0;
  for (int32_t f : s.walls())
    if (s.a.orig_tris()[size_t(s.a.faces()[size_t(f)].orig)].op < s.last.op) area += s.area(f);
  EXPECT_NEAR(area, sheet_area, 1e-6);
  s.expect(1, {2});
}

CUT_CASE(C33_through_two_stacked_pieces, case_slab()) {
  s.cut(strip({{-10, 0.2}, {10, 0.3}}, 2, -7));
  s.cut(sheet({-9, -0.1, -3}, {18, 0, 0}, {0, 12, 0}, 9, 6));
  s.cut(sheet({-9, -0.1, -6}, {18, 0, 0}, {0, 12, 0}, 9, 6));
  // Three layers. Drawn in the first and the second only: seeds above z = -6.
  Blade b;
  for (double x : {1.1, 1.4})
    for (double z : {2.0, -1.5, -4.5, -5.5, -9.0}) b.vertex.push_back(at(x, x == 1.1 ? 0.5 : 9, z));
  for (int32_t r = 0; r < 4; ++r) {
    b.tri.push_back({r, r + 1, r + 6});
    b.tri.push_back({r, r + 6, r + 5});
    b.seed.insert(b.seed.end(), 2, uint8_t(r < 3 ? 2 : 0));
  }
  b.seed[6] = b.seed[7] = 0;
  s.cut(b);
  bool first = false, second = false;
  for (int32_t f : s.a.last_operation().new_walls) {
    EXPECT_GT(s.centre(f).z(), -6.05);
    first = first || s.centre(f).z() > -2.9;
    second = second || s.centre(f).z() < -3.1;
  }
  EXPECT_TRUE(first && second);
}

CUT_CASE(C34_blade_as_from_an_inverted_cell, wavy_case_slab()) {
  // What a stroke over inverted cells could become in rest space: columns that run back, rows that turn over.
  for (const std::vector<Vec2>& path : {std::vector<Vec2>{{-9, 0}, {3, 0.1}, {-4, 0.2}, {9, 0.3}},
                                        std::vector<Vec2>{{-9, 5}, {3, 5}, {-4, 5}, {9, 5}}}) {
    Blade b = strip(path, 2, -5);
    for (size_t i = 4; i + 4 < b.vertex.size(); i += 6) std::swap(b.vertex[i], b.vertex[i + 1]);
    s.attempt(b);  // embedded or refused, checked either way
  }
}

CUT_CASE(C36_excise_then_cut_across_the_hole, case_slab()) {
  s.cut(open_box({{6, 0.2}, {0, 6}, {-6, 0.2}, {0, -6}}, 2, -5));
  s.excise_at({0, 0, 0});
  s.cut(strip({{-14, 0.3}, {14, 0.4}}, 2, -3));
  double nearest = 1e9;
  int left = 0, right = 0;
  for (int32_t f : s.a.last_operation().new_walls) {
    nearest = std::min(nearest, std::abs(s.centre(f).x()));
    (s.centre(f).x() > 0 ? right : left)++;
  }
  EXPECT_GT(nearest, 5.5);  // no wall in the void
  EXPECT_GT(left, 4);
  EXPECT_GT(right, 4);
  s.expect(1, {2});
}

CUT_CASE(C37_the_last_bridge, case_slab()) {
  // A floor, reached from a slit; then four walls around it, one after the other.
  s.cut(strip({{-8.3, -8}, {8.3, -8.1}}, 2, -5));
  s.expect(1, {2});
  s.cut(sheet({-9, -8.4, -4}, {18, 0, 0}, {0, 17.4, 0}, 9, 9));
  s.expect(1, {2});
  s.cut(strip({{-8, -8.4}, {-8.1, 8.4}}, 2, -4.4));
  s.expect(1, {2});
  s.cut(strip({{8, -8.4}, {8.1, 8.4}}, 2, -4.4));
  s.expect(1, {2});
  s.cut(strip({{-8.5, 8}, {8.5, 8.1}}, 2, -4.4));
  s.expect(2, {2, 2});
}

}  // namespace test_cut_cases_flaps
}  // namespace limberg::test
