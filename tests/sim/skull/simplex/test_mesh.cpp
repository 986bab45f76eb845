// Meshes made, counted, refused, turned into triangles and back, taken apart and put together.
#include <gtest/gtest.h>

#include <numbers>

#include "sim/base/error.h"
#include "sim/skull/simplex/contour.h"
#include "sim/skull/simplex/dual.h"
#include "sim/skull/simplex/generators.h"

namespace limberg::simplex {
namespace test_mesh {

constexpr double kPi = std::numbers::pi;

void expect_census(const Mesh& m, int64_t vertices, int64_t genus, int64_t ends, int64_t parts = 1) {
  EXPECT_EQ(find_fault(m).value_or(""), "");
  const Census c = census(m);
  EXPECT_EQ(c.vertices, vertices);
  EXPECT_EQ(2 * c.edges, 3 * c.vertices);
  EXPECT_EQ(c.genus, genus);
  EXPECT_EQ(c.end_contours, ends);
  EXPECT_EQ(c.components, parts);
  EXPECT_EQ(c.vertices, 2 * (c.faces - c.chi));
  int64_t sum = 0;
  for (int32_t f = 0; f < m.face_slots(); ++f)
    if (m.alive_face(f)) sum += 6 - m.face_size[size_t(f)];
  EXPECT_EQ(sum, 6 * c.chi);
}

TEST(Generators, SpheresToriCylindersPlanes) {
  for (int l = 0; l < 5; ++l) expect_census(make_sphere({0, 0, 0}, 1, l), 20 << (2 * l), 0, 0);
  expect_census(make_sphere_of_faces({0, 0, 0}, 50, 1002), 2000, 0, 0);  // the paper's sphere
  expect_census(make_sphere_of_faces({0, 0, 0}, 50, 12), 20, 0, 0);
  expect_census(make_torus(30, 10, 12, 9), 216, 1, 0);
  expect_census(make_torus(30, 10, 40, 16), 1280, 1, 0);
  const Mesh c = make_cylinder(10, 40, 20);
  expect_census(c, c.vertices(), 0, 2);
  const Mesh p = make_plane(60, 40, 2);
  expect_census(p, p.vertices(), 0, 1);
  EXPECT_NEAR(extent(p).area_mm2, 60 * 40, 8);  // corners are cut off
  for (int32_t v = 0; v < p.slots(); ++v) EXPECT_EQ(p.x_mm[size_t(v)].z(), 0);
  for (int32_t v = 0; v < p.slots(); ++v)
    if (const Row& f = p.left[size_t(v)]; !is_end(p.kind(f[0])) && !is_end(p.kind(f[1])) && !is_end(p.kind(f[2]))) {
      EXPECT_GT(p.frame(v).N.z(), 0.99);
    }
}

TEST(Generators, OutsideIsOutside) {
  EXPECT_NEAR(extent(make_sphere({3, 4, 5}, 10, 4)).volume_mm3, 4. / 3 * kPi * 1000, 10);
  EXPECT_NEAR(extent(make_torus(30, 10, 80, 26)).volume_mm3, 2 * kPi * kPi * 30 * 100, 1000);
  EXPECT_NEAR(extent(make_cylinder(10, 40, 60)).volume_mm3, kPi * 100 * 40, 100);
}

TEST(Generators, RefuseWhatCannotBe) {
  EXPECT_THROW(make_sphere({0, 0, 0}, 0, 2), InputError);
  EXPECT_THROW(make_sphere({0, 0, 0}, NAN, 2), InputError);
  EXPECT_THROW(make_sphere({0, 0, 0}, 1, 99), InputError);
  EXPECT_THROW(make_sphere_of_faces({0, 0, 0}, 1, 3), InputError);
  EXPECT_THROW(make_torus(10, 10, 12, 9), InputError);
  EXPECT_THROW(make_torus(30, 10, 13, 9), InputError);
  EXPECT_THROW(make_torus(30, 10, 1 << 20, 1 << 20), InputError);
  EXPECT_THROW(make_cylinder(1, 1e30, 8), InputError);
  EXPECT_THROW(make_plane(1e9, 1e9, 1e-3), InputError);
  EXPECT_THROW(make_plane(INFINITY, 1, 1), InputError);
}

TEST(Rows, EveryFaultHasItsSentence) {
  const Mesh good = make_sphere({0, 0, 0}, 1, 1);
  const auto fault = [&](auto&& spoil) {
    std::vector<Row> rows = good.nbr;
    spoil(rows);
    try {
      make_mesh(rows, good.x_mm);
    } catch (const InputError& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  EXPECT_EQ(fault([](auto&) {}), "");
  EXPECT_NE(fault([](auto& r) { r[5][1] = 80; }).find("does not exist"), std::string::npos);
  EXPECT_NE(fault([](auto& r) { r[5][1] = -1; }).find("does not exist"), std::string::npos);
  EXPECT_NE(fault([](auto& r) { r[5][1] = 5; }).find("its own"), std::string::npos);
  EXPECT_NE(fault([](auto& r) { r[5][1] = r[5][0]; }).find("twice"), std::string::npos);
  EXPECT_NE(fault([](auto& r) { r[5][1] = r[5][0] == 70 || r[5][2] == 70 ? 71 : 70; }).find("in turn"),
            std::string::npos);
  EXPECT_NE(fault([](auto& r) { std::swap(r[5][0], r[5][1]); }), "");  // turned over: faces meet twice or themselves
  EXPECT_THROW(make_mesh(good.nbr, {}), InputError);
}

TEST(Rows, FaultsOfTheCacheAreSeen) {
  Mesh m = make_sphere({0, 0, 0}, 1, 1);
  const auto spoiled = [&](auto&& f) {
    Mesh bad = m;
    f(bad);
    return find_fault(bad).has_value();
  };
  EXPECT_FALSE(spoiled([](Mesh&) {}));
  EXPECT_TRUE(spoiled([](Mesh& b) { b.left[3][0] = b.left[40][0]; }));
  EXPECT_TRUE(spoiled([](Mesh& b) { ++b.face_size[2]; }));
  EXPECT_TRUE(spoiled([](Mesh& b) { b.x_mm[2].x() = NAN; }));
  EXPECT_TRUE(spoiled([](Mesh& b) { b.free_vertex.push_back(1); }));
  EXPECT_TRUE(spoiled([](Mesh& b) { b.flags[1] |= kOnContour; }));
  EXPECT_TRUE(spoiled([](Mesh& b) { b.zone.pop_back(); }));
}

TEST(Dual, ThereAndBack) {
  const Mesh m = make_sphere({0, 0, 0}, 20, 3);
  const DualTriangles d = dual_triangles(m);
  const Mesh again = from_triangles(d.X_mm, d.tri);
  ASSERT_EQ(again.slots(), m.slots());
  for (const Vec3& x : again.x_mm) EXPECT_NEAR(x.norm(), 20, 0.03);  // centroids would be off by their sagitta, 0.2 mm
  EXPECT_EQ(again.nbr, m.nbr);
  const Mesh shrunk = from_triangles(d.X_mm, d.tri, DualPlacement::centroid);
  const double off = std::abs(extent(again).volume_mm3 - extent(m).volume_mm3),
               shrinks = std::abs(extent(shrunk).volume_mm3 - extent(m).volume_mm3);
  EXPECT_LT(off, 0.1 * shrinks);
  for (const Vec3& x : d.X_mm) EXPECT_NEAR(x.norm(), 20, 0.02);  // the centres of the fans lie on the sphere
}

TEST(Dual, FansCoverTheSurface) {
  for (const Mesh& m : {make_sphere({0, 0, 0}, 10, 3), make_plane(30, 20, 2), make_cylinder(8, 20, 16)}) {
    const FanTriangles f = fan_triangles(m);
    double area = 0;
    for (const Tri& t : f.tri)
      area +=
          0.5 * (f.X_mm[size_t(t[1])] - f.X_mm[size_t(t[0])]).cross(f.X_mm[size_t(t[2])] - f.X_mm[size_t(t[0])]).norm();
    EXPECT_NEAR(area, extent(m).area_mm2, 1e-9 * area);
    for (int32_t face : f.face) EXPECT_EQ(m.kind(face), FaceKind::surface);
    // The fans are a manifold: their dual exists, with as many holes as there are end contours.
    EXPECT_EQ(census(from_triangles(f.X_mm, f.tri)).end_contours, census(m).end_contours);
  }
}

TEST(Dual, BrokenTrianglesAreRefused) {
  const std::vector<Vec3> X{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}};
  const auto reason = [&](const std::vector<Vec3>& x, const std::vector<Tri>& t) {
    try {
      from_triangles(x, t);
    } catch (const InputError& e) {
      return std::string(e.what());
    }
    return std::string("accepted");
  };
  const std::vector<Tri> tet{{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
  EXPECT_EQ(reason(X, tet), "accepted");
  EXPECT_NE(reason(X, {}).find("no triangles"), std::string::npos);
  EXPECT_NE(reason(X, {{0, 1, 9}}).find("does not exist"), std::string::npos);
  EXPECT_NE(reason(X, {{0, 1, -1}}).find("does not exist"), std::string::npos);
  EXPECT_NE(reason(X, {{0, 1, 1}}).find("twice"), std::string::npos);
  EXPECT_NE(reason(X, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}, {0, 1, 4}}).find("3 triangles"), std::string::npos);
  EXPECT_NE(reason(X, {{0, 1, 2}, {0, 1, 3}}).find("orientation"), std::string::npos);
  auto bad = X;
  bad[2].y() = NAN;
  EXPECT_NE(reason(bad, tet).find("finite"), std::string::npos);
  // Two tetrahedra that touch in vertex 0, and two borders that do.
  const std::vector<Vec3> Y{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {-1, 0, 0}, {0, -1, 0}, {0, 0, -1}};
  EXPECT_NE(reason(Y, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}, {0, 4, 5}, {0, 6, 4}, {4, 6, 5}, {0, 5, 6}}),
            "accepted");
  EXPECT_NE(reason(Y, {{0, 1, 2}, {0, 4, 5}}).find("touch"), std::string::npos);
}

TEST(Mesh, PartsGoAndComeBack) {
  Mesh m = make_sphere({0, 0, 0}, 5, 2);
  const Mesh t = make_torus(30, 8, 12, 9);
  const uint64_t alone = hash(m);
  EXPECT_EQ(append(m, t), 320);
  expect_census(m, 536, 1, 0, 2);
  std::vector<int32_t> old;
  const Mesh sphere = extract_component(m, 7, &old), torus = extract_component(m, 400);
  EXPECT_EQ(hash(sphere), alone);
  EXPECT_EQ(hash(torus), hash(t));
  EXPECT_EQ(old[10], 10);
  Delta d;
  const uint64_t both = hash(m);
  ASSERT_TRUE(remove_component(m, 0, d));
  expect_census(m, 216, 1, 0, 1);
  Mesh packed = m;
  compact(packed);
  EXPECT_EQ(hash(packed), hash(t));
  undo(m, d);
  EXPECT_EQ(hash(m), both);
}

TEST(Mesh, RenumberingKeepsTheSurface) {
  Mesh m = make_plane(30, 20, 2);
  const Mesh before = m;
  const std::vector<int32_t> renamed = compact(m, true);
  EXPECT_EQ(find_fault(m).value_or(""), "");
  EXPECT_EQ(census(m), census(before));
  int64_t apart = 0;
  for (int32_t v = 0; v < m.slots(); ++v) {
    EXPECT_EQ(m.x_mm[size_t(renamed[size_t(v)])], before.x_mm[size_t(v)]);
    for (int k = 0; k < 3; ++k)
      EXPECT_EQ(m.nbr[size_t(renamed[size_t(v)])][size_t(k)], renamed[size_t(before.nbr[size_t(v)][size_t(k)])]);
    apart = std::max<int64_t>(apart, std::abs(m.nbr[size_t(v)][0] - v));
  }
  EXPECT_LT(apart, 120);
}

}  // namespace test_mesh
}  // namespace limberg::simplex
