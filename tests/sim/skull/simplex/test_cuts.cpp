// t3, t4 and their variants across edges; contours, holes, parts.
#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "sim/skull/simplex/contour.h"
#include "sim/skull/simplex/dual.h"
#include "sim/skull/simplex/generators.h"

namespace limberg::simplex {
namespace test_cuts {

std::vector<int32_t> equator(const Mesh& m) {
  // Through four places around z = 0.
  std::vector<int32_t> picks;
  for (const Vec3& p : {Vec3(10, 0, 0), Vec3(0, 10, 0), Vec3(-10, 0, 0), Vec3(0, -10, 0)}) {
    int32_t best = 0;
    for (int32_t v = 0; v < m.slots(); ++v)
      if ((m.x_mm[size_t(v)] - p).squaredNorm() < (m.x_mm[size_t(best)] - p).squaredNorm()) best = v;
    picks.push_back(best);
  }
  const ContourResult c = contour_through(m, picks);
  EXPECT_TRUE(c) << c.reason;
  return c.contour;
}

TEST(T4, CutsASphereInTwoAndT3JoinsItAgain) {
  Mesh m = make_sphere({0, 0, 0}, 10, 3);
  const uint64_t before = hash(m), rows = topology_hash(m);
  const Census c = census(m);
  const std::vector<int32_t> contour = equator(m);
  Delta d;
  const OperatorResult o = t4(m, contour, CutPolicy::must_divide, d);
  ASSERT_TRUE(o) << sentence(o.answer);
  ASSERT_EQ(find_fault(m).value_or(""), "");
  EXPECT_TRUE(o.divided);
  const Census after = census(m);
  EXPECT_EQ(after.vertices, c.vertices);
  EXPECT_EQ(after.edges, c.edges);
  EXPECT_EQ(after.faces, c.faces + 2);
  EXPECT_EQ(after.chi, 4);
  EXPECT_EQ(after.components, 2);
  EXPECT_EQ(after.genus, 0);
  EXPECT_EQ(after.end_contours, 2);
  EXPECT_EQ(m.face_size[size_t(o.face[0])] + m.face_size[size_t(o.face[1])], int32_t(contour.size()));
  Mesh joined = m;
  Delta e;
  const OperatorResult back = t3(joined, o.face[0], o.face[1], contour, e);
  ASSERT_TRUE(back) << sentence(back.answer);
  ASSERT_EQ(find_fault(joined).value_or(""), "");
  EXPECT_EQ(topology_hash(joined), rows);
  undo(joined, e);
  EXPECT_EQ(hash(joined), hash(m));
  undo(m, d);
  EXPECT_EQ(hash(m), before);
}

TEST(T4, ATorusOpensAndStaysOnePart) {
  Mesh m = make_torus(30, 10, 24, 12);
  const uint64_t rows = topology_hash(m);
  // Around the tube: the faces of two neighbouring rows have a ring of vertices between them.
  std::vector<int32_t> region;
  for (int32_t f = 0; f < m.face_slots(); ++f)
    if (const Vec3 c = face_centre(m, f); std::atan2(c.y(), c.x()) > 0.3 && std::atan2(c.y(), c.x()) < 1.2)
      region.push_back(f);
  EXPECT_FALSE(contour_of_faces(m, region));  // a band has two borders
  // One of them, walked: start where the band ends.
  std::vector<uint8_t> in(size_t(m.face_slots()), 0);
  for (int32_t f : region) in[size_t(f)] = 1;
  int32_t h0 = -1;
  for (int32_t f : region)
    m.around(f, [&](int32_t h) {
      if (!in[size_t(m.face(m.twin(h)))] && h0 < 0) h0 = h;
    });
  std::vector<int32_t> contour;
  int32_t h = h0;
  do {
    contour.push_back(m.from(h));
    h = m.next(h);
    while (in[size_t(m.face(m.twin(h)))]) h = m.next(m.twin(h));
  } while (h != h0);
  Delta d;
  EXPECT_EQ(t4(m, contour, CutPolicy::must_divide, d).answer, Answer::does_not_divide);
  EXPECT_EQ(topology_hash(m), rows);
  EXPECT_TRUE(d.empty());
  const OperatorResult o = t4(m, contour, CutPolicy::must_not_divide, d);
  ASSERT_TRUE(o) << sentence(o.answer);
  ASSERT_EQ(find_fault(m).value_or(""), "");
  const Census c = census(m);
  EXPECT_EQ(c.chi, 2);
  EXPECT_EQ(c.components, 1);
  EXPECT_EQ(c.genus, 0);
  EXPECT_EQ(c.end_contours, 2);
  EXPECT_EQ(m.face_size[size_t(o.face[0])], 12);
  EXPECT_EQ(m.face_size[size_t(o.face[1])], 12);
  Delta e;
  ASSERT_TRUE(t3(m, o.face[0], o.face[1], contour, e));
  EXPECT_EQ(topology_hash(m), rows);
  undo(m, e);
  // Without the contour the rings are found to lie on one another: genus 1 again.
  const OperatorResult closed = t3(m, o.face[0], o.face[1], e);
  ASSERT_TRUE(closed) << sentence(closed.answer);
  ASSERT_EQ(find_fault(m).value_or(""), "");
  EXPECT_EQ(census(m).genus, 1);
}

TEST(T3, JoinsTwoSpheresAndAddsAHandle) {
  Mesh m = make_sphere({0, 0, 0}, 10, 2);
  append(m, make_sphere({25, 0, 0}, 10, 2));
  const uint64_t before = hash(m);
  auto nearest = [&](const Vec3& p) {
    int32_t best = -1;
    for (int32_t f = 0; f < m.face_slots(); ++f)
      if (m.alive_face(f) &&
          (best < 0 || (face_centre(m, f) - p).squaredNorm() < (face_centre(m, best) - p).squaredNorm()))
        best = f;
    return best;
  };
  Delta d;
  const Census c = census(m);
  const OperatorResult o = t3(m, nearest({10, 0, 0}), nearest({15, 0, 0}), d);
  ASSERT_TRUE(o) << sentence(o.answer);
  ASSERT_EQ(find_fault(m).value_or(""), "");
  EXPECT_EQ(census(m).chi, c.chi - 2);
  EXPECT_EQ(census(m).components, 1);
  EXPECT_EQ(census(m).genus, 0);
  const OperatorResult handle = t3(m, nearest({0, 10, 0}), nearest({25, 10, 0}), d);
  ASSERT_TRUE(handle) << sentence(handle.answer);
  ASSERT_EQ(find_fault(m).value_or(""), "");
  EXPECT_EQ(census(m).genus, 1);
  const int32_t f = nearest({0, -10, 0});
  const uint64_t now = hash(m);
  EXPECT_EQ(t3(m, f, f, d).answer, Answer::same_face);
  int32_t beside = -1;
  m.around(f, [&](int32_t h) { beside = m.face(m.twin(h)); });
  EXPECT_EQ(t3(m, f, beside, d).answer, Answer::shared_vertex);
  int32_t second = -1;
  m.around(beside, [&](int32_t h) {
    const int32_t g = m.face(m.twin(h));
    bool touches = g == f;
    m.around(f, [&](int32_t e) { touches |= m.face(m.twin(e)) == g; });
    if (!touches) second = g;
  });
  EXPECT_EQ(t3(m, f, second, d).answer, Answer::common_face);
  EXPECT_EQ(hash(m), now);
  undo(m, d);
  EXPECT_EQ(hash(m), before);
}

TEST(T4Edges, PlaneCutsAreExactAndT3SpokesIsTheInverse) {
  Mesh m = make_sphere({0, 0, 0}, 10, 3);
  const uint64_t before = hash(m), rows = topology_hash(m);
  const Census c = census(m);
  const Vec3 n = Vec3(0.3, 0.2, 1).normalized(), p(0, 0, 2);
  const PlaneCurves curves = curves_of_plane(m, p, n);
  ASSERT_EQ(curves.curve.size(), 1u);
  const int k = int(curves.curve[0].size());
  Delta d;
  const OperatorResult o = t4_edges(m, curves.curve[0], CutPolicy::must_divide, d);
  ASSERT_TRUE(o) << sentence(o.answer);
  ASSERT_EQ(find_fault(m).value_or(""), "");
  const Census a = census(m);
  EXPECT_EQ(a.vertices - c.vertices, 2 * k);
  EXPECT_EQ(a.edges - c.edges, 3 * k);
  EXPECT_EQ(a.faces - c.faces, k + 2);
  EXPECT_EQ(a.chi, 4);
  EXPECT_EQ(a.components, 2);
  for (int32_t f : o.face)
    for (int32_t v : m.ring(f))
      EXPECT_NEAR(n.dot(m.x_mm[size_t(v)] - p), 0, 2e-3 * 1.2);  // crossings stay 1/1000 from the ends
  // The part with the normal is on the left.
  const Mesh cap = extract_component(m, m.ring(o.face[0])[0]), rest = extract_component(m, m.ring(o.face[1])[0]);
  for (const Vec3& x : cap.x_mm) EXPECT_GT(n.dot(x - p), -3e-3);
  const double R = 10, h = R - p.dot(n), cut = std::numbers::pi * h * h * (3 * R - h) / 3;
  EXPECT_NEAR(extent(cap).volume_mm3, cut, 0.01 * cut);
  EXPECT_NEAR(extent(cap).volume_mm3 + extent(rest).volume_mm3, 4. / 3 * std::numbers::pi * 1000, 0.01 * 4189);
  Mesh joined = m;
  Delta e;
  const OperatorResult back = t3_spokes(joined, o.face[0], o.face[1], e);
  ASSERT_TRUE(back) << sentence(back.answer);
  ASSERT_EQ(find_fault(joined).value_or(""), "");
  compact(joined);
  EXPECT_EQ(topology_hash(joined), rows);
  undo(m, d);
  EXPECT_EQ(hash(m), before);
}

TEST(T4Edges, EveryPlaneThroughATorus) {
  const Mesh torus = make_torus(30, 10, 40, 16);
  int cuts = 0;
  for (int i = 0; i < 60; ++i) {
    const double a = 0.1 + 0.11 * i;
    const Vec3 n(std::cos(a), std::sin(2.3 * a), std::sin(a)), p(3 * std::sin(a), 10 * std::cos(3 * a), 0);
    Mesh m = torus;
    Delta d;
    for (const auto& curve : curves_of_plane(m, p, n).curve) {
      const Census before = census(m);
      const OperatorResult o = t4_edges(m, curve, CutPolicy::any, d);
      ASSERT_EQ(find_fault(m).value_or(""), "");
      if (o) {
        ++cuts;
        EXPECT_EQ(census(m).chi, before.chi + 2);
        EXPECT_EQ(census(m).components, before.components + o.divided);
      }
    }
    EXPECT_EQ(find_fault(m).value_or(""), "");
    undo(m, d);
    EXPECT_EQ(hash(m), hash(torus));
  }
  EXPECT_GT(cuts, 60);
}

TEST(T4, BadContoursAreRefusedWithReasons) {
  Mesh m = make_sphere({0, 0, 0}, 10, 3);
  const std::vector<int32_t> good = equator(m);
  const uint64_t before = hash(m);
  Delta d;
  const auto refused = [&](std::vector<int32_t> c, Answer a, CutPolicy p = CutPolicy::any) {
    const OperatorResult o = t4(m, c, p, d);
    EXPECT_EQ(o.answer, a) << sentence(o.answer);
    EXPECT_EQ(hash(m), before);
    EXPECT_TRUE(d.empty());
  };
  refused({}, Answer::too_short);
  refused({good[0], good[1]}, Answer::too_short);
  refused({good[0], good[1], -7}, Answer::no_such_vertex);
  refused({good[0], good[1], good[0]}, Answer::repeated_vertex);  // a spur
  std::vector<int32_t> open = good;
  open.pop_back();
  refused(open, Answer::not_a_cycle);
  refused(m.ring(0), Answer::too_few_left);  // around one face: nothing leaves inside
  std::vector<int32_t> other = m.ring(0);
  std::reverse(other.begin(), other.end());
  refused(other, Answer::too_few_right);
  refused(good, Answer::divides, CutPolicy::must_not_divide);
  EXPECT_FALSE(contour_through(m, std::vector<int32_t>{3}));
  EXPECT_FALSE(contour_through(m, std::vector<int32_t>{3, 3, 3}));
  EXPECT_FALSE(contour_through(m, std::vector<int32_t>{3, 99999}));
  EXPECT_FALSE(contour_through(m, std::vector<int32_t>{good[0], good[5]}));  // there and back
  Mesh two = m;
  append(two, m);
  EXPECT_FALSE(contour_through(two, std::vector<int32_t>{3, 3 + m.slots(), 50}));
}

TEST(Holes, ARegionBecomesAnEndContour) {
  Mesh m = make_sphere({0, 0, 0}, 10, 3);
  const uint64_t before = hash(m);
  std::vector<int32_t> region;
  for (int32_t f = 0; f < m.face_slots(); ++f)
    if (face_centre(m, f).z() > 8) region.push_back(f);
  Delta d;
  const OperatorResult o = open_hole(m, region, d);
  ASSERT_TRUE(o) << sentence(o.answer);
  EXPECT_EQ(find_fault(m).value_or(""), "");
  const Census c = census(m);
  EXPECT_EQ(c.components, 1);
  EXPECT_EQ(c.end_contours, 1);
  EXPECT_EQ(c.genus, 0);
  const auto ends = end_contours(m);
  ASSERT_EQ(ends.size(), 1u);
  EXPECT_EQ(ends[0].kind, FaceKind::hole);
  for (int32_t v : ends[0].rim) EXPECT_NEAR(m.x_mm[size_t(v)].z(), 8, 2);
  EXPECT_FALSE(open_hole(m, std::vector<int32_t>{0}, d));  // a single face has no inside to cut off
  const uint64_t holed = hash(m);
  EXPECT_EQ(t4(m, ends[0].rim, CutPolicy::any, d).answer, Answer::end_face);
  EXPECT_EQ(hash(m), holed);
  undo(m, d);
  EXPECT_EQ(hash(m), before);
}

TEST(Zones, ContoursBoundThem) {
  Mesh m = make_sphere({0, 0, 0}, 10, 3);
  const std::vector<int32_t> c = equator(m);
  ASSERT_EQ(keep_contour(m, c), "");
  int32_t top = 0;
  for (int32_t v = 0; v < m.slots(); ++v)
    if (m.x_mm[size_t(v)].z() > m.x_mm[size_t(top)].z()) top = v;
  const int32_t n = fill_zone(m, top, 1);
  EXPECT_GT(n, m.slots() / 3);
  EXPECT_LT(n, 2 * m.slots() / 3);
  for (int32_t v = 0; v < m.slots(); ++v) EXPECT_TRUE(m.zone[size_t(v)] != 1 || m.x_mm[size_t(v)].z() > -2);
}

TEST(Shells, BothTablesCutAndJoinedAreWatertight) {
  // A thick shell of bone: an outer sphere and an inner one turned
  // inside out, cut by one plane, the mouths joined in pairs.
  Mesh m = make_sphere({0, 0, 0}, 20, 3);
  Mesh inner = make_sphere({0, 0, 0}, 14, 3);
  for (Row& r : inner.nbr) std::swap(r[1], r[2]);
  append(m, make_mesh(inner.nbr, inner.x_mm));
  const Census c = census(m);
  Delta d;
  std::vector<OperatorResult> mouths;
  for (const auto& curve : curves_of_plane(m, {0, 0, 5}, Vec3::UnitZ()).curve) {
    mouths.push_back(t4_edges(m, curve, CutPolicy::must_divide, d));
    ASSERT_TRUE(mouths.back()) << sentence(mouths.back().answer);
  }
  ASSERT_EQ(mouths.size(), 2u);
  for (int side : {0, 1}) {
    const OperatorResult o = t3(m, mouths[0].face[side], mouths[1].face[side], d);
    ASSERT_TRUE(o) << sentence(o.answer);
  }
  ASSERT_EQ(find_fault(m).value_or(""), "");
  const Census a = census(m);
  EXPECT_EQ(a.chi, c.chi);
  EXPECT_EQ(a.components, 2);
  EXPECT_EQ(a.end_contours, 0);
  EXPECT_EQ(a.genus, 0);
}

}  // namespace test_cuts
}  // namespace limberg::simplex
