// The saw: planes and contours through shells and solid bone; what is refused.
#include <gtest/gtest.h>

#include "sim/skull/bone/bones.h"
#include "sim/skull/bone/osteotomy.h"
#include "sim/skull/bone/surface.h"
#include "tests/sim/skull/bone/shapes.h"
#include "tests/sim/skull/simplex/random.h"

namespace limberg::bone {
namespace test_osteotomy {

using simplex::Mesh;

struct Parts {
  std::vector<Bulk> bulk;
  double sum = 0;
};

Parts parts(const Mesh& m) {
  Parts p;
  std::vector<int32_t> of;
  const int32_t n = simplex::components(m, of);
  p.bulk = bulks(m, of, n);
  for (const Bulk& b : p.bulk) p.sum += b.volume_mm3;
  return p;
}

double volume(const Mesh& m) { return parts(m).sum; }

/// What osteotomy.h says: over the faces that the curves cross, area times the heights of the fans before and after.
double bound(const Mesh& before, const Mesh& after) {
  double sum = 0;
  for (int32_t f = 0; f < before.face_slots(); ++f) {
    const bool same = after.alive_face(f) && after.kind(f) == before.kind(f) && after.ring(f) == before.ring(f);
    if (same) continue;
    const Vec3 c = simplex::face_centre(before, f);
    const simplex::FaceArea a = simplex::face_area(before, f);
    double high = 0;
    before.around(f, [&](int32_t h) {
      high = std::max(high, std::abs((before.x_mm[size_t(h / 3)] - c).dot(a.vector_mm2.normalized())));
    });
    sum += 2 * a.area_mm2 * high;
  }
  return sum;
}

void expect_closed(const Mesh& m) {
  EXPECT_EQ(simplex::find_fault(m).value_or(""), "");
  EXPECT_EQ(simplex::census(m).end_contours, 0);
  // Watertight: the sum of all area vectors of each component vanishes.
  std::vector<int32_t> of;
  const int32_t n = simplex::components(m, of);
  std::vector<Vec3> sum(size_t(n), Vec3::Zero());
  for (int32_t f = 0; f < m.face_slots(); ++f)
    if (m.alive_face(f)) sum[size_t(of[size_t(m.face_edge[size_t(f)] / 3)])] += simplex::face_area(m, f).vector_mm2;
  for (const Vec3& s : sum) EXPECT_LT(s.norm(), 1e-6);
}

TEST(Osteotomy, APlaneThroughAShellCutsBothTables) {
  Mesh m = test::skull_shell();
  const Mesh before = m;
  const simplex::Census c = simplex::census(m);
  Osteotomy o;
  o.kind = Osteotomy::Kind::plane, o.point_mm = {0, 0, 25}, o.normal = Vec3(0.2, 0.1, 1);
  simplex::Delta d;
  const Cut cut = cut_bone(m, 0, o, d);
  ASSERT_TRUE(cut) << cut.reason;
  EXPECT_EQ(cut.curves, 2);
  expect_closed(m);
  const simplex::Census a = simplex::census(m);
  EXPECT_EQ(a.components, 2);
  EXPECT_EQ(a.genus, 1);  // a cap, and a cup with a hole in its bottom
  EXPECT_EQ(a.chi, c.chi);
  EXPECT_EQ(cut.wall_left.size(), cut.wall_right.size());
  EXPECT_GT(cut.wall_left.size(), 30u);
  const double moved = std::abs(volume(m) - volume(before));
  EXPECT_LE(moved, bound(before, m));
  EXPECT_LT(moved, 2e-4 * volume(before));
  // The walls lie in the plane, and both sides' are the same polygons.
  for (size_t i = 0; i < cut.wall_left.size(); ++i) {
    for (int32_t v : m.ring(cut.wall_left[i]))
      EXPECT_NEAR(o.normal.normalized().dot(m.x_mm[size_t(v)] - o.point_mm), 0, 1e-2);
    EXPECT_LT((simplex::face_area(m, cut.wall_left[i]).vector_mm2 + simplex::face_area(m, cut.wall_right[i]).vector_mm2)
                  .norm(),
              1e-9);
    EXPECT_LT((simplex::face_centre(m, cut.wall_left[i]) - simplex::face_centre(m, cut.wall_right[i])).norm(), 1e-9);
  }
  simplex::undo(m, d);
  EXPECT_EQ(simplex::hash(m), simplex::hash(before));
}

TEST(Osteotomy, AContourOnAShellIsSweptThroughTheOtherTable) {
  for (const bool picked : {false, true}) {
    Mesh m = test::skull_shell();
    const Mesh before = m;
    Osteotomy o;
    // Over the forehead; drawn in 2 mm steps, or eight picks.
    o.path_mm = test::on_ellipsoid(test::circle({0, 68, 30}, {0, 1, 0.5}, 26, picked ? 8 : 80, picked ? 0 : 0.15));
    simplex::Delta d;
    const Cut cut = cut_bone(m, 0, o, d);
    ASSERT_TRUE(cut) << cut.reason << (picked ? " (picked)" : " (drawn)");
    EXPECT_EQ(cut.curves, 2);
    expect_closed(m);
    const simplex::Census a = simplex::census(m);
    EXPECT_EQ(a.components, 2);
    EXPECT_EQ(a.genus, 1);  // the window makes the shell a ring
    EXPECT_EQ(a.chi, 2);
    EXPECT_LE(std::abs(volume(m) - volume(before)), bound(before, m));
    const Parts p = parts(m);
    const double small = std::min(p.bulk[0].volume_mm3, p.bulk[1].volume_mm3);
    EXPECT_NEAR(small, std::numbers::pi * 26 * 26 * 6, 0.15 * small);  // disc of bone, 6 mm thick
    simplex::undo(m, d);
    EXPECT_EQ(simplex::hash(m), simplex::hash(before));
  }
}

TEST(Osteotomy, SolidBoneNeedsOneCurve) {
  const Mesh whole = test::mandible();
  Osteotomy plane;
  plane.kind = Osteotomy::Kind::plane, plane.point_mm = {0, 40, 0}, plane.normal = {1, 0.2, 0.1};
  Osteotomy round;
  round.path_mm = test::circle({0, 40, 0}, {1, 0.1, 0}, 9, 60);
  Osteotomy cap;  // thick bone: what lies over the contour comes off
  cap.path_mm = test::circle({26, 0, 0}, {1, 0, 0}, 8, 50);
  for (const auto& [bone, o] : {std::pair(whole, plane), std::pair(whole, round), std::pair(test::ellipsoid(), cap)}) {
    Mesh m = bone;
    simplex::Delta d;
    const Cut cut = cut_bone(m, 0, o, d);
    ASSERT_TRUE(cut) << cut.reason;
    EXPECT_EQ(cut.curves, 1);
    expect_closed(m);
    EXPECT_EQ(simplex::census(m).components, 2);
    EXPECT_EQ(simplex::census(m).genus, 0);
    EXPECT_LE(std::abs(volume(m) - volume(bone)), bound(bone, m));
    simplex::undo(m, d);
    EXPECT_EQ(simplex::hash(m), simplex::hash(bone));
  }
}

TEST(Osteotomy, VolumeErrorShrinksWithTheMesh) {
  // Only the faces that are crossed change: an error of O(h^2) per area, of O(h^3) in all.
  double error[2];
  for (int i : {0, 1}) {
    Mesh m = test::ellipsoid(3 + i);
    const double all = volume(m);
    Osteotomy o;
    o.kind = Osteotomy::Kind::plane, o.point_mm = {3, 0, 0}, o.normal = {1, 0.3, 0.2};
    simplex::Delta d;
    const Cut cut = cut_bone(m, 0, o, d);
    ASSERT_TRUE(cut) << cut.reason;
    error[i] = std::abs(volume(m) - all);
  }
  EXPECT_LT(error[1], error[0] / 2);
}

TEST(Osteotomy, ForbiddenCutsAreRefusedAndChangeNothing) {
  Mesh m = test::skull_shell();
  const auto refused = [&](const Osteotomy& o, const char* why) {
    const uint64_t before = simplex::hash(m);
    simplex::Delta d;
    const Cut cut = cut_bone(m, 0, o, d);
    EXPECT_NE(cut.reason.find(why), std::string::npos) << cut.reason;
    EXPECT_EQ(simplex::hash(m), before);
    EXPECT_TRUE(d.empty());
  };
  const std::vector<Vec3> good = test::on_ellipsoid(test::circle({0, 68, 30}, {0, 1, 0.5}, 26, 80));
  Osteotomy o;
  o.path_mm.assign(good.begin(), good.begin() + 60);
  refused(o, "open");
  o.path_mm.clear();
  refused(o, "at least three");
  for (int i = 0; i < 90; ++i) {  // an eight
    const double t = 2 * std::numbers::pi * i / 90;
    o.path_mm.push_back({30 * std::sin(t), 72, 20 + 18 * std::sin(2 * t)});
  }
  o.path_mm = test::on_ellipsoid(o.path_mm);
  refused(o, "crosses itself");
  o.path_mm = test::circle({0, 85, 0}, {0, 1, 0}, 0.8, 30);
  refused(o, "too small");
  o.path_mm = test::circle({0, 200, 0}, {0, 1, 0}, 20, 30);
  refused(o, "from the bone");
  o.path_mm = good, o.path_mm[3].x() = NAN;
  refused(o, "not finite");
  o.path_mm = good;
  ASSERT_TRUE([&] {  // a kept contour across the forehead
    std::vector<int32_t> picks;
    for (const Vec3& p : {Vec3(40, 68, 20), Vec3(0, 85, 20), Vec3(-40, 68, 20), Vec3(0, 60, 55)}) {
      int32_t best = 0;
      for (int32_t v = 0; v < m.slots(); ++v)
        if ((m.x_mm[size_t(v)] - p).squaredNorm() < (m.x_mm[size_t(best)] - p).squaredNorm()) best = v;
      picks.push_back(best);
    }
    const simplex::ContourResult c = simplex::contour_through(m, picks);
    return c && simplex::keep_contour(m, c.contour).empty();
  }());
  refused(o, "kept contour");
  simplex::release_contour(m, 0);
  for (int32_t v = 0; v < m.slots(); ++v)
    if (m.x_mm[size_t(v)].y() > 60) m.flags[size_t(v)] |= simplex::kLocked;
  refused(o, "locked");
  for (uint8_t& f : m.flags) f = 0;
  Osteotomy p;
  p.kind = Osteotomy::Kind::plane, p.point_mm = {0, 0, 300};
  refused(p, "does not meet");
  p.normal = Vec3::Zero();
  refused(p, "not zero");
  p.normal = {NAN, 0, 1};
  refused(p, "finite");
  p.normal = Vec3::UnitZ(), p.point_mm = {0, 0, 64.85};
  refused(p, "too small");
  // A hole in the outer table under the contour.
  std::vector<int32_t> region;
  const Vec3 on_path = good[20];
  for (int32_t f = 0; f < m.face_slots(); ++f)
    if (const Vec3 c = simplex::face_centre(m, f);
        (c - on_path).norm() < 9 && c.cwiseQuotient(Vec3(70, 85, 65)).norm() > 0.97)
      region.push_back(f);
  simplex::Delta holed;
  ASSERT_TRUE(simplex::open_hole(m, region, holed));
  refused(o, "hole");
  // A ring does not fall apart when it is cut once.
  m = simplex::make_torus(30, 8, 40, 20);
  Osteotomy once;
  once.kind = Osteotomy::Kind::plane, once.point_mm = {30, 0, 0}, once.normal = {0.1, 1, 0}, once.radius_mm = 15;
  refused(once, "does not divide");
  once.must_divide = false;
  simplex::Delta d;
  const Cut cut = cut_bone(m, 0, once, d);
  EXPECT_TRUE(cut) << cut.reason;
  EXPECT_EQ(simplex::census(m).genus, 0);
  expect_closed(m);
}

TEST(Osteotomy, RandomPlanesThroughRingsAndShells) {
  // A torus, cut flat along its ring plane, has an outer and an inner curve; a shell has several.
  test::Random random(7);
  int done = 0, refused = 0;
  for (const Mesh& whole : {simplex::make_torus(30, 10, 60, 24), test::skull_shell(3), test::mandible(3)}) {
    for (int i = 0; i < 40; ++i) {
      Mesh m = whole;
      Osteotomy o;
      o.kind = Osteotomy::Kind::plane, o.point_mm = random.vec(25), o.normal = random.vec();
      simplex::Delta d;
      const Cut cut = cut_bone(m, 0, o, d);
      if (!cut) {
        ++refused;
        EXPECT_EQ(simplex::hash(m), simplex::hash(whole));
        EXPECT_TRUE(cut.reason.find("small") != std::string::npos || cut.reason.find("meet") != std::string::npos)
            << cut.reason;
        continue;
      }
      ++done;
      expect_closed(m);
      EXPECT_GE(simplex::census(m).components, 2);
      EXPECT_LE(std::abs(volume(m) - volume(whole)), bound(whole, m) + 1e-6);
      simplex::undo(m, d);
      EXPECT_EQ(simplex::hash(m), simplex::hash(whole));
    }
  }
  EXPECT_GT(done, 80);
  EXPECT_LT(refused, 40);
}

}  // namespace test_osteotomy
}  // namespace limberg::bone
