// Exact predicates, validation and OBJ files: what must pass passes, each planted defect is found and named.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <random>
#include <sstream>

#include "sim/base/error.h"
#include "sim/body/block.h"
#include "sim/body/obj.h"
#include "sim/geometry/grid_predicates.h"
#include "sim/geometry/validate.h"

namespace limberg {
namespace test_surface {

std::string obj_text(const TriMesh& m, double scale = 1) {
  std::ostringstream s;
  s.precision(17);
  for (const Vec3& X : m.X_mm) s << "v " << X.x() * scale << ' ' << X.y() * scale << ' ' << X.z() * scale << '\n';
  for (const Tri& t : m.tri) s << "f " << t[0] + 1 << ' ' << t[1] + 1 << ' ' << t[2] + 1 << '\n';
  return s.str();
}

Body small_block() {
  BlockSpec s;
  s.size_mm = {12, 8, 4};
  s.skin_cell_mm = 2;
  return make_block(s);
}

void expect_refused(const TriMesh& m, const RestGrid& g, const std::string& word) {
  try {
    validate_surface(m, g, "m.obj");
    ADD_FAILURE() << "accepted, expected: " << word;
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find(word), std::string::npos) << e.what();
    EXPECT_TRUE(std::string(e.what()).starts_with("m.obj")) << e.what();
  }
}

TEST(GridPredicates, OrientationIsExactAndAntisymmetric) {
  const int32_t m = RestGrid::kMaxCoordinate;
  const Int3 a{-m, -m, -m}, b{m, -m, -m}, c{-m, m, -m}, d{-m, -m, m};
  const GridVolume edge = 2 * GridVolume(m);
  EXPECT_TRUE(grid_orient3d(a, b, c, d) == edge * edge * edge);
  EXPECT_TRUE(grid_orient3d(b, a, c, d) == -edge * edge * edge);
  // One unit off a plane through far points is seen.
  EXPECT_TRUE(grid_orient3d(a, b, {-m, m, m - 1}, {m, m, m}) != 0);
  EXPECT_TRUE(grid_orient3d(a, b, {-m, m, m}, {m, m, m}) == 0);
}

// Random small-coordinate triangles hit every degenerate case; the float answer is exact there (values below 2^53).
bool segment_meets_by_fractions(const Int3& p, const Int3& q, const GridTriangle& t) {
  // Sample-free reference: clip the segment by the triangle's prism and plane in long double rationals.
  const auto v = [](const Int3& i) { return Vec3(i.x, i.y, i.z); };
  const Vec3 a = v(t[0]), b = v(t[1]), c = v(t[2]), P = v(p), Q = v(q), n = (b - a).cross(c - a);
  double lo = 0, hi = 1, den = 1;                  // the admissible interval is [lo, hi] / den with integers in doubles
  const auto keep = [&](double at0, double at1) {  // at0 + s (at1 - at0) >= 0
    const double d = at1 - at0;
    if (d == 0) return at0 >= 0;
    // s >= -at0/d or s <= -at0/d, compared as fractions with lo/den, hi/den
    const double num = d > 0 ? -at0 : at0, dd = std::abs(d);
    const double l = lo * dd, h = hi * dd, x = num * den;
    if (d > 0 && x > l) {
      lo = x;
      hi = h;
      den *= dd;
    } else if (d < 0 && x < h) {
      lo = l;
      hi = x;
      den *= dd;
    }
    return lo <= hi;
  };
  const auto inside = [&](const Vec3& e, const Vec3& f) {
    const Vec3 w = n.cross(f - e);
    return keep(w.dot(P - e), w.dot(Q - e));
  };
  return keep(n.dot(P - a), n.dot(Q - a)) && keep(-n.dot(P - a), -n.dot(Q - a)) && inside(a, b) && inside(b, c) &&
         inside(c, a);
}

TEST(GridPredicates, SegmentAgainstTriangleMatchesClippingInSmallIntegers) {
  std::mt19937_64 rng(5);
  // Coordinates in 0..2: the fractions above stay far below 2^53, so that reference is exact.
  const auto point = [&] { return Int3{int32_t(rng() % 3), int32_t(rng() % 3), int32_t(rng() % 3)}; };
  int meets = 0, total = 0;
  for (int n = 0; n < 200000; ++n) {
    const GridTriangle t{point(), point(), point()};
    const auto normal = grid_normal(t[0], t[1], t[2]);
    if (normal[0] == 0 && normal[1] == 0 && normal[2] == 0) continue;
    const Int3 p = point(), q = point();
    if (p == q) continue;
    const bool got = grid_segment_meets_triangle(p, q, t);
    ASSERT_EQ(got, segment_meets_by_fractions(p, q, t)) << n;
    ASSERT_EQ(got, grid_segment_meets_triangle(q, p, {t[2], t[1], t[0]}));
    meets += got;
    ++total;
  }
  EXPECT_GT(meets, total / 20);
  EXPECT_LT(meets, total * 19 / 20);
}

TEST(GridPredicates, NeighboursOffendOnlyWhenTheyFold) {
  const Int3 a{0, 0, 0}, b{10, 0, 0}, c{0, 10, 0}, d{10, 10, 0}, e{8, 2, 0}, up{3, 3, 9};
  EXPECT_FALSE(grid_triangles_offend({a, b, c}, {b, d, c}));
  EXPECT_FALSE(grid_triangles_offend({a, b, c}, {b, a, up}));
  EXPECT_TRUE(grid_triangles_offend({a, b, d}, {b, a, e}));    // folded flat onto each other
  EXPECT_FALSE(grid_triangles_offend({a, b, c}, {d, up, b}));  // one corner
  EXPECT_TRUE(grid_triangles_offend({a, b, c}, {a, d, up}));   // a-d runs through the first triangle
  EXPECT_TRUE(grid_triangles_offend({a, b, c}, {e, d, up}));   // touches its long edge
  EXPECT_TRUE(grid_triangles_offend({a, b, c}, {c, b, a}));
  EXPECT_FALSE(grid_triangles_offend({a, b, c}, {Int3{0, 0, 1}, Int3{10, 0, 1}, Int3{0, 10, 1}}));
}

TEST(Validate, TheDefaultBlockPasses) {
  const Body b = make_block({});
  const SurfaceReport r = validate_surface(b.surface, b.grid, "block");
  EXPECT_EQ(r.genus, 0);
  EXPECT_EQ(r.volume_mm3, 144000);
  EXPECT_NEAR(r.area_mm2, 2 * 14400 + 4 * 1200, 1e-6);
}

TEST(Validate, EachPlantedDefectIsFound) {
  const Body good = small_block();
  const RestGrid& g = good.grid;
  validate_surface(good.surface, g, "m.obj");
  TriMesh m = good.surface;
  m.tri.pop_back();
  expect_refused(m, g, "open");
  m = good.surface;
  std::swap(m.tri[5][0], m.tri[5][1]);
  expect_refused(m, g, "same direction");
  m = good.surface;
  for (Tri& t : m.tri) std::swap(t[0], t[1]);
  expect_refused(m, g, "inside out");
  m = good.surface;
  m.tri[3][1] = m.tri[3][0];
  expect_refused(m, g, "no area");
  m = good.surface;
  m.tri[3][1] = 1 << 20;
  expect_refused(m, g, "names vertex");
  m = good.surface;
  m.X_mm[7].x() += 1e-7;
  expect_refused(m, g, "rest grid");
  m = good.surface;
  m.X_mm[7].x() = NAN;
  expect_refused(m, g, "not finite");
  m = good.surface;  // push one skin vertex through the bottom
  size_t middle = 0;
  for (size_t i = 0; i < m.X_mm.size(); ++i)
    if (m.X_mm[i].z() == 0 && m.X_mm[i].head<2>().norm() < m.X_mm[middle].head<2>().norm()) middle = i;
  m.X_mm[middle].z() = -5;
  expect_refused(m, g, "crosses or touches itself");
  m.X_mm[middle].z() = -4;  // exactly touching is not embedded either
  expect_refused(m, g, "crosses or touches itself");
  m.X_mm[middle].z() = -3.9375;
  EXPECT_NO_THROW(validate_surface(m, g, "m.obj"));

  const auto twice = [&](const Vec3& offset) {
    TriMesh two = good.surface;
    const int32_t n = int32_t(two.X_mm.size());
    for (const Vec3& X : good.surface.X_mm) two.X_mm.push_back(X + offset);
    for (const Tri& t : good.surface.tri) two.tri.push_back({t[0] + n, t[1] + n, t[2] + n});
    return two;
  };
  expect_refused(twice({50, 0, 0}), g, "separate parts");
  // Two blocks that share one corner vertex: the fan around it is broken.
  TriMesh kiss = twice(good.box_max_mm - good.box_min_mm);
  int32_t low = 0, high = 0;
  for (int32_t i = 0; i < int32_t(kiss.X_mm.size()); ++i)
    if (kiss.X_mm[size_t(i)] == good.box_max_mm) (i < int32_t(good.surface.X_mm.size()) ? low : high) = i;
  for (Tri& t : kiss.tri)
    for (int32_t& v : t) v = v == high ? low : v;
  expect_refused(kiss, g, "touches itself in a vertex");
}

TEST(Obj, BlockThroughTextGivesTheSameSurface) {
  const Body b = small_block();
  ObjSpec spec;
  spec.path = "b.obj";
  spec.scale_to_mm = 10;
  SurfaceReport report;
  const Body back = parse_obj(obj_text(b.surface, 0.1), spec, &report);
  ASSERT_EQ(back.surface.tri, b.surface.tri);
  for (size_t i = 0; i < b.surface.X_mm.size(); ++i)
    EXPECT_LE((back.surface.X_mm[i] - b.surface.X_mm[i]).cwiseAbs().maxCoeff(), back.grid.unit_mm);
  EXPECT_EQ(report.genus, 0);
  EXPECT_NEAR(report.volume_mm3, 12 * 8 * 4, 1e-2);  // a unit of the grid times the area
  for (size_t t = 0; t < back.surface.tri.size(); ++t) {
    bool bottom = true;
    for (int32_t v : back.surface.tri[t]) bottom = bottom && back.surface.X_mm[size_t(v)].z() == back.box_min_mm.z();
    EXPECT_EQ(back.surface.tag[t] == SurfaceTag::fixed, bottom);
  }
}

TEST(Obj, TheDeepSideIsWhatLooksThere) {
  const Body b = small_block();
  const auto held = [&](const ObjSpec& spec) {
    const Body body = parse_obj(obj_text(b.surface), spec);
    double area[3] = {0, 0, 0};  // by axis of the normal
    for (size_t t = 0; t < body.surface.tri.size(); ++t) {
      if (body.surface.tag[t] != SurfaceTag::fixed) continue;
      const Tri& c = body.surface.tri[t];
      const auto& X = body.surface.X_mm;
      const Vec3 n = (X[size_t(c[1])] - X[size_t(c[0])]).cross(X[size_t(c[2])] - X[size_t(c[0])]);
      int axis = 0;
      n.cwiseAbs().maxCoeff(&axis);
      area[axis] += 0.5 * n.norm();
    }
    return Vec3(area[0], area[1], area[2]);
  };
  ObjSpec spec;
  spec.path = "b.obj";
  EXPECT_NEAR((held(spec) - Vec3(0, 0, 96)).norm(), 0, 1e-2);  // the bottom; 1/8192 mm on 12 mm
  spec.deep_center_mm = Vec3(0, 0, -100);
  spec.deep_angle_deg = 45;
  EXPECT_NEAR((held(spec) - Vec3(0, 0, 96)).norm(), 0, 1e-2);
  spec.deep_center_mm = Vec3(0, 0, -2);
  EXPECT_EQ(held(spec), Vec3(0, 0, 0));  // all of a convex body looks away from its middle
  spec.deep_center_mm.reset();
  spec.deep_angle_deg = 0;
  EXPECT_EQ(held(spec), Vec3(0, 0, 0));
  spec.deep_direction = Vec3::UnitX();
  spec.deep_plane_mm = 5.9;
  EXPECT_NEAR((held(spec) - Vec3(32, 0, 0)).norm(), 0, 1e-2);  // one end
  spec.deep_plane_mm = -100;
  EXPECT_THROW(held(spec), InputError);  // no skin left
}

const char* kCube =
    "# a cube of quads, negative indices, windows line ends, a split line\r\n"
    "v 0 0 0\r\nv 1 0 0\r\nv 1 1 0\r\nv 0 1 0\r\nv 0 0 1\r\nv 1 0 1\r\nv 1 1 1\r\nv 0 1 1\r\n"
    "vt 0 0\r\nvt 1 0\r\nvt 1 1\r\nvt 0 1\r\ns off\r\nusemtl x\r\n"
    "f 4/1 3/2 2/3 1/4\r\nf 5/1/7 6/2/7 7/3/7 8/4/7\r\nf 1 2 6 5\r\nf 2//1 3//1 \\\r\n7//1 6//1\r\nf -6 -5 -1 -2\r\nf "
    "4 1 5 8 # end\r\n";

TEST(Obj, PolygonsNegativeIndicesAndLineEnds) {
  ObjSpec spec;
  spec.path = "cube.obj";
  spec.scale_to_mm = 20;
  SurfaceReport r;
  const std::string text = kCube;
  const Body b = parse_obj(text, spec, &r);
  EXPECT_EQ(r.triangles, 12);
  EXPECT_EQ(r.vertices, 8);
  EXPECT_NEAR(r.volume_mm3, 8000, 1e-9);
  for (const auto& corner : b.surface.uv[2])
    EXPECT_NE(corner, Eigen::Vector2f(1, 1));  // 8 5 6, an ear of the second quad
}

TEST(Obj, AFaceMayNameVerticesThatFollow) {
  ObjSpec spec;
  spec.path = "late.obj";
  SurfaceReport r;
  parse_obj("f 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\nv 0 0 0\nv 9 0 0\nv 0 9 0\nv 0 0 9\n", spec, &r);
  EXPECT_NEAR(r.volume_mm3, 121.5, 1e-6);
}

TEST(Obj, ConcavePolygonsAreCutInside) {
  // An L-shaped prism: the two L faces are concave hexagons.
  ObjSpec spec;
  spec.path = "l.obj";
  SurfaceReport r;
  parse_obj(
      "v 0 0 0\nv 20 0 0\nv 20 10 0\nv 10 10 0\nv 10 20 0\nv 0 20 0\nv 0 0 5\nv 20 0 5\nv 20 10 5\nv 10 10 5\nv 10 20 "
      "5\nv 0 20 5\n"
      "f 6 5 4 3 2 1\nf 7 8 9 10 11 12\nf 1 2 8 7\nf 2 3 9 8\nf 3 4 10 9\nf 4 5 11 10\nf 5 6 12 11\nf 6 1 7 12\n",
      spec, &r);
  EXPECT_NEAR(r.volume_mm3, 300 * 5, 1e-9);
  EXPECT_EQ(r.triangles, 20);
}

TEST(Obj, ASurfaceThatIsInsideOutIsTurned) {
  const std::string corners = "v 0 0 0\nv 9 0 0\nv 0 9 0\nv 0 0 9\nvt 0 0\nvt 1 0\nvt 0 1\n";
  ObjSpec spec;
  spec.path = "x.obj", spec.deep_angle_deg = 30;
  SurfaceReport out, in;
  const Body outwards = parse_obj(corners + "f 1/1 3/2 2/3\nf 1/1 2/2 4/3\nf 2/1 3/2 4/3\nf 3/1 1/2 4/3\n", spec, &out);
  const Body inwards = parse_obj(corners + "f 1/1 2/3 3/2\nf 1/1 4/3 2/2\nf 2/1 4/3 3/2\nf 3/1 4/3 1/2\n", spec, &in);
  EXPECT_FALSE(out.turned);
  EXPECT_TRUE(in.turned);
  EXPECT_EQ(in.volume_mm3, out.volume_mm3);
  EXPECT_EQ(inwards.surface.tri, outwards.surface.tri);
  EXPECT_EQ(inwards.surface.uv, outwards.surface.uv) << "each corner keeps its place in the picture";
  EXPECT_EQ(inwards.surface.tag, outwards.surface.tag);
}

TEST(Obj, BadFilesAreRefusedWithTheirLine) {
  const std::string v = "v 0 0 0\nv 9 0 0\nv 0 9 0\nv 0 0 9\n";
  const std::tuple<std::string, int, const char*> cases[] = {
      {"", 0, "no vertices"},
      {"hello\n", 0, "no vertices"},
      {v, 0, "no faces"},
      {"v 1 2\n", 1, "three finite numbers"},
      {"v 1 nan 2\n", 1, "three finite numbers"},
      {"v 1 1e999 2\n", 1, "three finite numbers"},
      {"v 1 2x 3\n", 1, "three finite numbers"},
      {v + "f 1 2 5\n", 5, "names vertex 5"},
      {v + "f 0 1 2\n", 5, "names vertex 0"},
      {v + "f -5 1 2\n", 5, "names vertex -5"},
      {v + "f 1 2\n", 5, "2 corners"},
      {v + "f 1 2 a\n", 5, "broken index"},
      {v + "f 1/1 2/1 3/1\n", 5, "texture coordinate 1"},
      {v + "f 1 99999999999999999999 2\n", 5, "broken index"},
      {v + "f 1 3 2\n", 5, "open"},
      {v + "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 4 1\n", 8, "same direction"},
      {v + "v 9 9 0\nf 1 5 2 3\n", 6, "cannot be cut"},
      {"v 0 0 0\nv 9e9 0 0\nv 0 9 0\nv 0 0 9\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n", 0, "expected 1 to 1000"},
      {"v 0 0 0\nv 1e-3 0 0\nv 0 1e-3 0\nv 0 0 1e-3\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n", 0, "expected 1 to 1000"},
  };
  for (const auto& [text, line, word] : cases) {
    ObjSpec spec;
    spec.path = "x.obj";
    try {
      parse_obj(text, spec);
      ADD_FAILURE() << "accepted: " << text;
    } catch (const InputError& e) {
      EXPECT_EQ(e.line(), line) << e.what();
      EXPECT_NE(std::string(e.what()).find(word), std::string::npos) << e.what();
    }
  }
  ObjSpec spec;
  spec.path = "t.obj";
  EXPECT_NO_THROW(parse_obj(v + "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n", spec));
  spec.path = "/no/such/file.obj";
  EXPECT_THROW(load_obj(spec), InputError);
  spec.path = std::filesystem::temp_directory_path();
  EXPECT_THROW(load_obj(spec), InputError);
}

TEST(Obj, AnyBytesAreEitherASurfaceOrAnInputError) {
  std::mt19937_64 rng(9);
  const std::string good = kCube, spice = "vf/0123456789-. \n\\#e\xff";
  int refused = 0;
  for (int n = 0; n < 20000; ++n) {
    std::string t = good;
    for (int k = 1 + int(rng() % 3); k > 0 && !t.empty(); --k) {
      const size_t at = rng() % t.size();
      if (rng() % 3 == 0)
        t.erase(at, 1 + rng() % 20);
      else
        t[at] = spice[rng() % spice.size()];
    }
    ObjSpec spec;
    spec.path = "f.obj";
    spec.scale_to_mm = 20;
    try {
      parse_obj(t, spec);
    } catch (const InputError&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 5000);
}

TEST(Obj, TheRealFaceLoads) {
  const char* data = std::getenv("LIMBERG_DATA");
  if (!data) GTEST_SKIP() << "LIMBERG_DATA does not name the folder of the test data";
  ObjSpec spec;
  spec.path = std::string(data) + "/face/wholeFace_NasalCartilage.obj";
  if (!std::filesystem::exists(spec.path)) GTEST_SKIP() << spec.path << " is absent";
  spec.scale_to_mm = 10;
  SurfaceReport r;
  const Body b = load_obj(spec, &r);
  EXPECT_EQ(r.vertices, 7798);
  EXPECT_EQ(r.triangles, 15612);
  EXPECT_EQ(r.genus, 5);
  EXPECT_GT(r.volume_mm3, 1e5);
  EXPECT_NEAR((b.box_max_mm - b.box_min_mm).y(), 322.6, 0.1);
}

}  // namespace test_surface
}  // namespace limberg
