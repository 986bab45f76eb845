// A scene made for a surface of one's own can be read, built and cut, whichever way the surface faces.
#include <gtest/gtest.h>

#include <fstream>

#include "app/program/temporary_folder.h"
#include "app/scene/first_scene.h"
#include "app/scene/scene.h"
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

}  // namespace test_first_scene
}  // namespace limberg
