// The face that shipped scenes operate on: what the file holds is what the program makes, closed, and as thick as said.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <sstream>

#include "app/program/places.h"
#include "app/session/workers_pool.h"
#include "sim/base/whole_file.h"
#include "sim/geometry/bvh.h"
#include "sim/geometry/io/obj_text.h"
#include "sim/imaging/anatomical/face_tissue.h"

namespace limberg {
namespace test_face_tissue {

const FaceTissue& face() {
  static const FaceTissue made = [] {
    WorkersPool workers(2);
    return make_face_tissue(workers);
  }();
  return made;
}

void the_shipped_file_is_what_is_made() {
  const ObjText file =
      parse_obj_text(read_whole_file(source_dir() + "/app/scenes/anatomical_face.obj"), "shipped", {100'000, 200'000});
  ASSERT_EQ(file.v.size(), face().X_mm.size()) << "./do face makes the file anew";
  for (size_t i = 0; i < file.v.size(); ++i)
    ASSERT_LE((file.v[i] - face().X_mm[i]).cwiseAbs().maxCoeff(), 0.0051) << i;  // written with two decimals
  EXPECT_EQ(file.face.size(), face().tri.size());
}

void is_closed_and_of_one_sphere() {
  std::map<std::pair<int32_t, int32_t>, int> edge;
  for (const Tri& t : face().tri)
    for (size_t k = 0; k < 3; ++k) ++edge[{t[k], t[(k + 1) % 3]}];
  for (const auto& [e, n] : edge) {
    ASSERT_EQ(n, 1);
    ASSERT_TRUE(edge.contains({e.second, e.first}));
  }
  EXPECT_EQ(int64_t(face().X_mm.size()) - int64_t(edge.size()) / 2 + int64_t(face().tri.size()), 2);  // Euler
}

void is_as_thick_as_it_says() {
  std::vector<Tri> deep;
  for (size_t t = 0; t < face().tri.size(); ++t)
    if (face().part[t] == FacePart::deep) deep.push_back(face().tri[t]);
  const Bvh bed(face().X_mm, deep), all(face().X_mm, face().tri);
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

void has_all_its_parts_on_both_sides() {
  std::array<std::array<int, 2>, 4> n{};
  for (size_t t = 0; t < face().tri.size(); ++t)
    ++n[size_t(face().part[t])][face().X_mm[size_t(face().tri[t][0])].x() > 0];
  for (const auto& [left, right] : n) {
    EXPECT_GT(left, 50);
    EXPECT_NEAR(double(left) / right, 1, 0.1);
  }
}

// One test: it is made once, in some ten seconds.
TEST(FaceTissue, IsClosedAsThickAsItSaysAndTheShippedOne) {
  the_shipped_file_is_what_is_made();
  is_closed_and_of_one_sphere();
  is_as_thick_as_it_says();
  has_all_its_parts_on_both_sides();
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
