// How a face looks: a scan's picture and colours lie where they lay on the scan, seams and all, and go into recordings.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "app/assembly/bundle.h"
#include "app/head/build.h"
#include "app/program/temporary_folder.h"
#include "render/image.h"
#include "sim/base/error.h"
#include "sim/base/workers.h"
#include "sim/skull/head/head.h"
#include "sim/skull/simplex/file.h"
#include "sim/skull/simplex/generators.h"

namespace limberg {
namespace test_face_look {

constexpr double kRadius_mm = 48;
constexpr int kRows = 60, kColumns = 120;

/// Where a place of the ball lies in the picture: its two halves, y above 0 and below, are two charts seen from their
/// sides, u from 0 to .5 and from .5 to 1.
struct InPicture {
  bool front;
  Vec2 at(const Vec3& X) const {
    return {0.25 + (front ? 0 : 0.5) + 0.2 * X.x() / kRadius_mm, 0.5 + 0.4 * X.z() / kRadius_mm};
  }
};

class FaceLook : public ::testing::Test {
 protected:
  void SetUp() override {
    simplex::Mesh ball = simplex::make_sphere({0, 0, 0}, 40, 3), face = simplex::make_sphere({0, 0, 0}, kRadius_mm, 4);
    for (simplex::Mesh* m : {&ball, &face}) simplex::record_shape(*m);
    simplex::save_mesh(ball, file("ball.txt")), simplex::save_mesh(face, file("face.txt"));
  }
  std::string file(const std::string& name) const { return (folder_.path() / name).string(); }
  void write(const std::string& name, const std::string& text) const { std::ofstream(file(name)) << text; }

  /// A ball about the z axis, of quads; `half`: only y >= 0. With colours, or in two charts with a material.
  void scan(const std::string& name, bool coloured, bool half = false, double scale = 1) const {
    std::string v, vt, f;
    const auto at = [](int row, int column) {
      const double a = M_PI * row / kRows, b = 2 * M_PI * column / kColumns;
      return Vec3(kRadius_mm * std::sin(a) * std::cos(b), kRadius_mm * std::sin(a) * std::sin(b),
                  kRadius_mm * std::cos(a));
    };
    for (int r = 0; r <= kRows; ++r)
      for (int c = 0; c < kColumns; ++c) {
        const Vec3 X = at(r, c), x = scale * X;
        v += fmt::format("v {} {} {}", x.x(), x.y(), x.z());
        if (coloured) v += fmt::format(" {} {} {}", 0.5 + X.x() / 100, 0.5 + X.y() / 100, 0.5 + X.z() / 100);
        v += "\n";
        for (const bool front : {true, false}) {
          const Vec2 uv = InPicture{front}.at(X);
          vt += fmt::format("vt {} {}\n", uv.x(), uv.y());
        }
      }
    for (int r = 0; r < kRows; ++r)
      for (int c = 0; c < (half ? kColumns / 2 : kColumns); ++c) {
        const bool front = c < kColumns / 2;
        f += "f";
        for (const auto& [i, j] : {std::pair(r, c), {r + 1, c}, {r + 1, c + 1}, {r, c + 1}}) {
          const int k = i * kColumns + j % kColumns;
          f += coloured ? fmt::format(" {}", k + 1) : fmt::format(" {}/{}", k + 1, 2 * k + (front ? 1 : 2));
        }
        f += "\n";
      }
    write(name, (coloured ? "" : "mtllib scan.mtl\n") + v + (coloured ? "" : vt) + f);
    if (coloured) return;
    write("scan.mtl", "newmtl skin\nmap_Kd photo.png\n");
    Image photo;
    photo.width = 16, photo.height = 8, photo.rgb.assign(3 * 16 * 8, 90);
    write_png(file("photo.png"), photo);
  }
  Scene scene(const std::string& more) const {
    return parse_scene(
        "name = \"ball\"\n[head]\nsource = \"files\"\nbones = [\"ball.txt\"]\nface = \"face.txt\"\n" + more,
        file("ball.toml"));
  }
  std::shared_ptr<const SurfaceTopology> shown(const Scene& of) {
    Head head(head_parts(of, workers_), workers_);
    Snapshot s;
    head.fill(s);
    return s.topology;
  }
  std::string why(const std::string& more) {
    try {
      shown(scene(more));
    } catch (const InputError& e) {
      return e.what();
    }
    return "";
  }

  TemporaryFolder folder_;
  InlineWorkers workers_;
};

/// How many triangles of the face wear what lies farther from where they lie than `most_mm`, or both charts.
size_t misplaced(const SurfaceTopology& top, double most_mm, double axes = 1) {
  const SurfaceView& view = top.view;
  size_t bad = 0, seen = 0;
  for (size_t t = 0; t < view.tri.size(); ++t) {
    if (top.organ[t] != Organ::face) continue;
    ++seen;
    const bool front = view.uv[t][0].x() < 0.5f;
    for (size_t k = 0; k < 3; ++k) {
      Vec3 X = view.X_mm[size_t(view.tri[t][int(k)])].normalized() * kRadius_mm;
      X.head<2>() *= axes;
      const Vec2 off = view.uv[t][k].cast<double>() - InPicture{front}.at(X);
      const double mm = std::hypot(off.x() / 0.2, off.y() / 0.4) * kRadius_mm;
      if (!(mm <= most_mm)) ++bad;
    }
  }
  EXPECT_GT(seen, 3000u);
  return bad;
}

TEST_F(FaceLook, APictureLiesWhereItLayOnTheScan) {
  scan("scan.obj", false);
  const auto top = shown(scene("face_texture = \"scan.obj\"\n"));
  ASSERT_TRUE(top->image);
  EXPECT_EQ(top->image->width, 16);
  EXPECT_EQ(top->image_on, Organ::face);
  ASSERT_EQ(top->view.uv.size(), top->view.tri.size());
  // A triangle beyond a seam ends at it: so far the corner of one is from its middle, edges here being 5 mm long.
  EXPECT_EQ(misplaced(*top, 4), 0u);
  // A scan in another unit, and one whose axes point left and backwards as the face's do.
  scan("cm.obj", false, false, 0.1);
  EXPECT_EQ(misplaced(*shown(scene("face_texture = \"cm.obj\"\nface_texture_scale_to_mm = 10\n")), 4), 0u);
  const auto turned = shown(scene("axes = \"lps\"\nface_texture = \"scan.obj\"\n"));
  EXPECT_EQ(misplaced(*turned, 4, -1), 0u);
  EXPECT_GT(misplaced(*turned, 4), 1000u);
}

TEST_F(FaceLook, ColoursOfVerticesAreTakenOverAndFadeBeyondTheScan) {
  scan("scan.obj", true, true);
  const auto top = shown(scene("face_texture = \"scan.obj\"\n"));
  EXPECT_FALSE(top->image);
  ASSERT_EQ(top->rgba.size(), top->view.X_mm.size());
  std::vector<bool> of_face(top->rgba.size());
  for (size_t t = 0; t < top->view.tri.size(); ++t)
    if (top->organ[t] == Organ::face)
      for (const int32_t v : std::as_const(top->view.tri)[t]) of_face[size_t(v)] = true;
  size_t on = 0, beyond = 0;
  for (size_t v = 0; v < of_face.size(); ++v) {
    const Vec3 X = std::as_const(top->view.X_mm)[v];
    const auto& c = top->rgba[v];
    if (!of_face[v]) {
      EXPECT_EQ(c[3], 0) << "bone";
    } else if (X.y() > 1) {
      ++on;
      EXPECT_EQ(c[3], 255);
      // The scan's facets and the mesh's lie half a millimetre beside the ball, and a level is .4 mm.
      for (int k = 0; k < 3; ++k) EXPECT_NEAR(c[size_t(k)], 255 * (0.5 + X[k] / 100), 3) << X.transpose();
    } else if (X.y() < -FaceTexture::kNone_mm) {
      ++beyond;
      EXPECT_EQ(c[3], 0);
    } else if (X.y() < 0) {
      EXPECT_NEAR(c[3], 255 * std::clamp((10 + X.y()) / 6, 0.0, 1.0), 20) << X.transpose();
    }
  }
  EXPECT_GT(on, 500u);
  EXPECT_GT(beyond, 300u);
}

TEST_F(FaceLook, ItsFilesGoIntoRecordingsAndNotIntoTheHash) {
  scan("scan.obj", false);
  const Scene bare = scene(""), worn = scene("face_texture = \"scan.obj\"\nnormal_skull = \"scan.obj\"\n");
  for (const Scene* s : {&bare, &worn}) {
    Recording rec;
    rec.blobs = bundle(*s, Calibration());
    const Unbundled again = unbundle_scene(rec, "t.lcm");
    EXPECT_EQ(again.scene.hash, s->hash);
    EXPECT_EQ(bool(shown(again.scene)->image), s == &worn);
  }
  write("photo.png", "");
  EXPECT_EQ(scene("face_texture = \"scan.obj\"\nnormal_skull = \"scan.obj\"\n").hash, worn.hash);
}

TEST_F(FaceLook, MistakesAreNamed) {
  scan("scan.obj", false), scan("bare.obj", false);
  write("bare.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const auto says = [&](const std::string& more, const std::string& what) {
    const std::string said = why(more);
    EXPECT_NE(said.find(what), std::string::npos) << more << said;
  };
  says("face_texture = \"none.obj\"\n", "none.obj");
  says("face_texture = \"bare.obj\"\n", "nor colours of its vertices; expected one of them");
  says("face_texture = \"bare.obj\"\nface_picture = \"photo.png\"\n", "has no face with texture coordinates");
  says("face_texture = \"scan.obj\"\nface_picture = \"scan.mtl\"\n", "scan.mtl");
  says("face_picture = \"photo.png\"\n", "without face_texture");
  says("face_texture = \"scan.obj\"\nface_texture_scale_to_mm = 0\n", "face_texture_scale_to_mm");
  EXPECT_EQ(why("face_texture = \"scan.obj\"\n"), "");
  write("far.obj", "v 0 0 0 1 1 1\nv 1e300 0 0 1 1 1\nv 0 1 0 1 1 1\nf 1 2 3\n");
  says("face_texture = \"far.obj\"\n", "a point is not at a place within 1000000 mm");
  // Of no area, in space and in the picture: nothing to complain of, and nothing to divide by.
  write("thin.obj", "v 0 0 0\nv 0 0 0\nv 50 0 0\nvt 0 0\nvt 0 0\nvt 9 -9\nf 1/1 2/2 3/3\nf 1/1 1/1 1/1\n");
  EXPECT_EQ(why("face_texture = \"thin.obj\"\nface_picture = \"photo.png\"\n"), "");
  const auto thin = shown(scene("face_texture = \"thin.obj\"\nface_picture = \"photo.png\"\n"));
  for (const auto& corners : thin->view.uv)
    for (const Eigen::Vector2f& uv : corners) ASSERT_TRUE(uv.allFinite());
}

}  // namespace test_face_look
}  // namespace limberg
