// The face that shipped scenes operate on: what the file holds is what the program makes, closed, and as thick as said.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <sstream>

#include "app/program/places.h"
#include "app/session/workers_pool.h"
#include "sim/base/whole_file.h"
#include "sim/body/tension_lines.h"
#include "sim/geometry/bvh.h"
#include "sim/geometry/io/obj_text.h"
#include "sim/imaging/anatomical/eye_shape.h"
#include "sim/imaging/anatomical/face_lines.h"
#include "sim/imaging/anatomical/face_tissue.h"
#include "sim/imaging/anatomical/lid_bed.h"
#include "sim/imaging/anatomical/mouth_bed.h"

namespace limberg {
namespace test_face_tissue {

FaceTissue made(const FaceOpenings& open) {
  WorkersPool workers(2);
  return make_face_tissue(workers, open);
}

template <class Surface>
void is_the_shipped(const Surface& made, const std::string& name, double written_mm) {
  const ObjText file = parse_obj_text(read_whole_file(source_dir() + "/app/scenes/anatomical_" + name + ".obj"),
                                      "shipped", {100'000, 200'000});
  ASSERT_EQ(file.v.size(), made.X_mm.size()) << "./do face makes the file anew";
  for (size_t i = 0; i < file.v.size(); ++i)
    ASSERT_LE((file.v[i] - made.X_mm[i]).cwiseAbs().maxCoeff(), 0.51 * written_mm) << i;
  EXPECT_EQ(file.face.size(), made.tri.size());
}

/// Its Euler characteristic: 2 of a sphere, 0 with one handle.
int64_t euler_of_closed(const FaceTissue& face) {
  std::map<std::pair<int32_t, int32_t>, int> edge;
  for (const Tri& t : face.tri)
    for (size_t k = 0; k < 3; ++k) ++edge[{t[k], t[(k + 1) % 3]}];
  for (const auto& [e, n] : edge) {
    EXPECT_EQ(n, 1);
    EXPECT_TRUE(edge.contains({e.second, e.first}));
  }
  return int64_t(face.X_mm.size()) - int64_t(edge.size()) / 2 + int64_t(face.tri.size());
}

void is_as_thick_as_it_says(const FaceTissue& face) {
  std::vector<Tri> deep;
  for (size_t t = 0; t < face.tri.size(); ++t)
    if (face.part[t] == FacePart::deep) deep.push_back(face.tri[t]);
  const Bvh bed(face.X_mm, deep), all(face.X_mm, face.tri);
  // Forehead, cheekbone, cheek: from the skin met from in front.
  const std::pair<Vec3, double> places[] = {{{0, 0, 70}, 8}, {{45, 0, -30}, 14}, {{-45, 0, -30}, 14}};
  for (const auto& [p, thick_mm] : places) {
    const auto hits = all.line(Vec3(p.x(), 200, p.z()), -Vec3::UnitY(), 0, 400);
    ASSERT_FALSE(hits.empty());
    const Vec3 skin(p.x(), 200 - hits[0].t, p.z());
    // Cells of 4 mm, and edges thinned to 12 % of theirs.
    EXPECT_NEAR(bed.closest(skin).distance_mm, thick_mm, 1.2) << p.transpose();
  }
}

void has_parts_on_both_sides(const FaceTissue& face, size_t parts) {
  std::array<std::array<int, 2>, std::size(kFaceParts)> n{};
  for (size_t t = 0; t < face.tri.size(); ++t) ++n[size_t(face.part[t])][face.X_mm[size_t(face.tri[t][0])].x() > 0];
  for (size_t part = 0; part < n.size(); ++part) {
    const auto& [left, right] = n[part];
    if (part >= parts) {
      EXPECT_EQ(left + right, 0);
      continue;
    }
    EXPECT_GT(left, 50);
    EXPECT_NEAR(double(left) / right, 1, 0.1);
  }
}

/// From in front between the lips to the teeth nothing is in the way; above and below there is a lip as thick as one.
void lips_are_apart(const FaceTissue& face) {
  const Bvh all(face.X_mm, face.tri);
  const auto along = [&](double x, double z) { return all.line(Vec3(x, 200, z), -Vec3::UnitY(), 0, 140); };
  for (const double x : {-20.0, -8.0, 0.0, 8.0, 20.0}) {
    EXPECT_TRUE(along(x, -55.6).empty()) << x;
    for (const double z : {-51.5, -60.5}) {
      const auto lip = along(x, z);
      ASSERT_EQ(lip.size(), 2u) << x << ' ' << z;
      EXPECT_GT(lip[1].t - lip[0].t, 6) << x << ' ' << z;
      EXPECT_LT(lip[1].t - lip[0].t, 18) << x << ' ' << z;
    }
  }
}

/// From in front between the lids nothing is in the way of the globe; through a lid, towards the globe's middle, there
/// is tissue of 2 to 4.5 mm (a margin is 2 mm thick, as remembered), then the globe.
void lids_are_apart(const FaceTissue& face) {
  using anatomical::Eye;
  const Bvh all(face.X_mm, face.tri);
  for (const auto& [x, z] :
       {std::pair(26.0, 14.5), std::pair(31.5, 11.5), std::pair(31.5, 18.0), std::pair(38.0, 15.0)})
    for (const Bvh::LineHit& h : all.line(Vec3(x, 200, z), -Vec3::UnitY(), 0, 200 - Eye::parted_centre().y()))
      ADD_FAILURE() << x << ' ' << z << " meets tissue at y = " << 200 - h.t;
  for (const auto& [x, z] : {std::pair(24.0, 8.0), std::pair(31.5, 6.5), std::pair(39.0, 8.5)}) {
    const auto skin = all.line(Vec3(x, 200, z), -Vec3::UnitY(), 0, 140);
    ASSERT_FALSE(skin.empty());
    const Vec3 at(x, 200 - skin[0].t, z), inwards = (Eye::parted_centre() - at).normalized();
    const auto lid = all.line(at - inwards, inwards, 0, 12);
    ASSERT_EQ(lid.size(), 2u) << x;
    EXPECT_GT(lid[1].t - lid[0].t, 2) << x;
    EXPECT_LT(lid[1].t - lid[0].t, 4.5) << x;
    EXPECT_NEAR(Eye::globe_mm(at + (lid[1].t - 1) * inwards), 0.3, 0.1) << x;
  }
}

// One test each: they are made in some ten seconds.
TEST(FaceTissue, IsClosedAsThickAsItSaysAndTheShippedOne) {
  const FaceTissue face = made({});
  is_the_shipped(face, "face", 0.01);
  EXPECT_EQ(euler_of_closed(face), 2);
  is_as_thick_as_it_says(face);
  has_parts_on_both_sides(face, 4);
}

// The shipped lines lie on the shipped face, alike on both halves, and run there as the drawings have it.
TEST(FaceTissue, LinesOfTensionAreThoseThatItsRulesMake) {
  const ObjText file =
      parse_obj_text(read_whole_file(source_dir() + "/app/scenes/anatomical_face.obj"), "shipped", {100'000, 200'000});
  std::vector<Tri> tri;
  for (const ObjText::Face& f : file.face)
    tri.push_back({file.corner[f.first].v, file.corner[f.first + 1].v, file.corner[f.first + 2].v});
  const std::vector<FaceLine> made = face_tension_lines(file.v, tri);
  const std::string name = source_dir() + "/app/scenes/anatomical_tension.txt";
  const std::vector<TensionPlace> shipped = parse_tension_lines(read_whole_file(name), name);
  ASSERT_EQ(made.size(), shipped.size()) << "./do face makes the file anew";
  ASSERT_GT(made.size(), 130u);
  for (size_t i = 0; i < made.size(); ++i) {
    EXPECT_LT((made[i].at_mm - shipped[i].at_mm).cwiseAbs().maxCoeff(), 0.07) << i;
    EXPECT_GT(std::abs(made[i].along.dot(shipped[i].along)), 0.9999) << i;
    const auto mirrored = std::find_if(made.begin(), made.end(), [&](const FaceLine& o) {
      return (o.at_mm - made[i].at_mm.cwiseProduct(Vec3(-1, 1, 1))).norm() < 1e-9 &&
             std::abs(o.along.dot(made[i].along.cwiseProduct(Vec3(-1, 1, 1)))) > 0.9999;
    });
    EXPECT_NE(mirrored, made.end()) << i;
  }
}

TEST(FaceTissue, PartedLipsHaveMarginsAndLieBeforeTeeth) {
  const FaceTissue face = made({.lips = Lips::parted});
  is_the_shipped(face, "lips", 0.01);
  EXPECT_EQ(euler_of_closed(face), 0) << "the mouth is the one hole";
  is_as_thick_as_it_says(face);
  has_parts_on_both_sides(face, 5);
  lips_are_apart(face);
  WorkersPool workers(2);
  const anatomical::SkinShape skin;
  const MouthBed bed(skin);
  const MouthBedMeshes meshes = make_mouth_bed(bed, workers);
  is_the_shipped(meshes.teeth, "teeth", 0.001);
  is_the_shipped(meshes.gums, "gums", 0.001);
  for (const Vec3& X : face.X_mm) ASSERT_GT(bed(X), -1) << X.transpose();  // its deep cells are 4 mm large
}

TEST(FaceTissue, ACleftPartsTheUpperLipUpToABridgeBelowTheNostril) {
  const FaceTissue face = made({.lips = Lips::cleft});
  is_the_shipped(face, "cleft", 0.01);
  EXPECT_EQ(euler_of_closed(face), 0) << "gap and mouth are one hole";
  is_as_thick_as_it_says(face);
  const Bvh all(face.X_mm, face.tri);
  const auto skin_y = [&](double x, double z) {
    const auto hits = all.line(Vec3(x, 200, z), -Vec3::UnitY(), 0, 400);
    return hits.empty() ? 0 : 200 - hits[0].t;
  };
  // The lip's skin lies before y = 100 mm here, what is behind the gap is not.
  int open = 0, bridge = 0;
  constexpr double kStep_mm = 0.1;
  for (double x = -20; x < 0; x += kStep_mm) open += skin_y(x, -50) < 100;
  for (double z = -43; z < -36; z += kStep_mm) bridge += skin_y(-8, z) > 105;
  EXPECT_GT(open * kStep_mm, 7);
  EXPECT_LT(open * kStep_mm, 9);
  EXPECT_GT(bridge * kStep_mm, 3);
  EXPECT_LT(bridge * kStep_mm, 5);
  // The other half is whole.
  for (double x = 1; x < 20; ++x) EXPECT_GT(skin_y(x, -50), 98) << x;
  const anatomical::SkinShape skin;
  const MouthBed bed(skin);
  for (const Vec3& X : face.X_mm) ASSERT_GT(bed(X), -1) << X.transpose();  // its deep cells are 4 mm large
}

TEST(FaceTissue, TheScalpGoesOverTheVertex) {
  const FaceTissue face = made({.reach = FaceReach::scalp});
  is_the_shipped(face, "scalp", 0.01);
  EXPECT_EQ(euler_of_closed(face), 2);
  double top = 0, back = 0;
  for (const Vec3& X : face.X_mm) top = std::max(top, X.z()), back = std::min(back, X.y());
  EXPECT_GT(top, 125);
  EXPECT_LT(back, -55);
}

TEST(FaceTissue, PartedLidsHaveMarginsAndLieBeforeAGlobe) {
  using anatomical::Eye;
  const FaceTissue face = made({.lids = Lids::parted});
  is_the_shipped(face, "lids", 0.01);
  EXPECT_EQ(euler_of_closed(face), 0) << "the orbit is the one hole";
  is_as_thick_as_it_says(face);
  lids_are_apart(face);
  const LidBedMeshes eye = make_lid_bed();
  is_the_shipped(eye.globe, "eye", 0.001);
  is_the_shipped(eye.iris, "iris", 0.001);
  is_the_shipped(eye.pupil, "pupil", 0.001);
  double front = -1e3, back = 1e3;
  for (const Vec3& X : eye.globe.X_mm) {
    front = std::max(front, X.y()), back = std::min(back, X.y());
    ASSERT_NEAR(Eye::globe_mm(X), 0, 0.02) << X.transpose();
  }
  EXPECT_NEAR(front - back, 24.0, 1e-6);
  for (const Vec3& X : face.X_mm) ASSERT_GT(Eye::globe_mm(X), 0.15) << X.transpose();
}

TEST(FaceTissue, ThePictureIsLaidWhereItWasTaken) {
  for (const Vec3& X : {Vec3(0, 105, -20), Vec3(40, 80, -30), Vec3(-30, 95, 60)}) {
    const Vec2 uv = face_picture_place(X);
    const Vec3 back = face_place_of_picture(uv);
    EXPECT_LT((face_picture_place(back) - uv).norm(), 1e-6);
  }
}

}  // namespace test_face_tissue
}  // namespace limberg
