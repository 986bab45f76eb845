// A scene made for a surface of one's own can be read, built and cut, whichever way the surface faces.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "app/program/temporary_folder.h"
#include "app/scene/first_scene.h"
#include "app/scene/scene.h"
#include "sim/base/whole_file.h"
#include "sim/body/skin.h"
#include "tests/sim/lattice/sheet_bodies.h"

namespace limberg {
namespace test_first_scene {

/// A mound on a flat bed that looks along an axis (0 to 2), to either side.
TriMesh mound(int axis, bool forwards, double size_mm, const Vec3& at_mm) {
  test::Sheet s;
  s.size_mm = size_mm, s.cells = 20;
  s.top = [&](double x, double y) { return 0.25 * size_mm - 0.6 * (x * x + y * y) / size_mm; };
  s.bottom = [&](double, double) { return -0.2 * size_mm; };
  TriMesh m = test::sheet_mesh(s);
  for (Vec3& X : m.X_mm) {
    Vec3 p;
    p[axis] = forwards ? X.z() : -X.z();
    p[(axis + 1) % 3] = X.x(), p[(axis + 2) % 3] = forwards ? X.y() : -X.y();
    X = p + at_mm;
  }
  return m;
}

TEST(FirstScene, OperatesOnWhateverSideMostOfASurfaceFaces) {
  for (int axis = 0; axis < 3; ++axis)
    for (const bool forwards : {true, false})
      for (const double size : {40.0, 200.0}) {
        SCOPED_TRACE(testing::Message() << axis << ' ' << forwards << ' ' << size);
        const TemporaryFolder folder("first-scene");
        const TriMesh m = mound(axis, forwards, size, {12, -340, 55});
        std::ofstream file(folder.path() / "own \"1\".obj");
        for (const Vec3& X : m.X_mm) file << "v " << X.x() << ' ' << X.y() << ' ' << X.z() << '\n';
        for (const Tri& t : m.tri) file << "f " << t[0] + 1 << ' ' << t[1] + 1 << ' ' << t[2] + 1 << '\n';
        file.close();
        ObjSpec spec;
        spec.path = (folder.path() / "own \"1\".obj").string(), spec.layers.resize(1);
        const std::string text = first_scene(load_obj(spec), "own \"1\".obj");
        const Scene scene = parse_scene(text, (folder.path() / "own.toml").string());
        const auto body = build_body(scene);
        const Skin skin(body);
        const auto origin = skin.at({0, 0});
        ASSERT_TRUE(origin) << text;
        EXPECT_LT((origin->X_mm - scene.obj.chart_origin_mm).norm(), 0.5);
        // The crown of the mound, but where its box looks alike from two sides.
        EXPECT_GT(origin->normal.dot(body->chart_normal()), 0.9);
        EXPECT_GT(scene.camera.from.dot(body->chart_normal()), 0);
        EXPECT_NE(std::count(body->surface.tag.begin(), body->surface.tag.end(), SurfaceTag::fixed), 0);
        if (axis == 2 && forwards) {
          EXPECT_EQ(body->chart_normal(), Vec3::UnitZ());
        }
      }
}

// A line through the middle of a ring meets nothing, and those beside it the wall of its hole.
TEST(FirstScene, OfARingItsOriginLooksOutAndNotFromTheHole) {
  constexpr int kAround = 60, kAcross = 24;
  std::string text;
  for (int i = 0; i < kAround; ++i)
    for (int j = 0; j < kAcross; ++j) {
      const double u = 2 * M_PI * i / kAround, v = 2 * M_PI * j / kAcross, r = 45 + 18 * std::cos(v);
      text += fmt::format("v {} {} {}\n", r * std::cos(u), r * std::sin(u), 18 * std::sin(v));
      const auto at = [](int a, int b) { return a % kAround * kAcross + b % kAcross + 1; };
      text += fmt::format("f {} {} {} {}\n", at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
    }
  ObjSpec spec;
  spec.path = "ring.obj", spec.layers.resize(1);
  const TemporaryFolder folder("ring");
  write_whole_file((folder.path() / "ring.obj").string(), text);
  const Scene scene = parse_scene(first_scene(parse_obj(text, spec), "ring.obj"), (folder.path() / "r.toml").string());
  const auto body = build_body(scene);
  const auto origin = Skin(body).at({0, 0});
  ASSERT_TRUE(origin);
  EXPECT_GT(origin->normal.dot(body->chart_normal()), 0.7);
}

}  // namespace test_first_scene
}  // namespace limberg
