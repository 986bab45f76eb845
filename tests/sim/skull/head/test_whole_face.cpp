// Tissue over a whole face: sound columns everywhere, a free rim that comes to rest.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sim/geometry/bvh.h"
#include "sim/imaging/synthetic/synthetic_head.h"
#include "sim/skull/head/head.h"
#include "sim/skull/simplex/dual.h"
#include "sim/skull/simplex/generators.h"

namespace limberg {
namespace test_whole_face {

using namespace simplex;

TEST(MeanRatio, IsThatOfKnownTetrahedra) {
  const Vec3 o(0, 0, 0), x(1, 0, 0), y(0, 1, 0), z(0, 0, 1);
  EXPECT_NEAR(mean_ratio(o, Vec3(1, 1, 0), Vec3(1, 0, 1), Vec3(0, 1, 1)), -1, 1e-12);
  EXPECT_NEAR(mean_ratio(o, Vec3(1, 0, 1), Vec3(1, 1, 0), Vec3(0, 1, 1)), 1, 1e-12);
  EXPECT_NEAR(mean_ratio(o, x, y, z), 12 * std::cbrt(0.25) / 9, 1e-12);  // 3 V = 1/2, edges 3 x 1 and 3 x sqrt 2
  EXPECT_EQ(mean_ratio(o, x, y, Vec3(1, 1, 0)), 0);
  EXPECT_NEAR(mean_ratio(5 * o, 5 * x, 5 * y, 5 * z), mean_ratio(o, x, y, z), 1e-12);
}

/// The synthetic head at edges that are quick to make; its tissue about the nose, so far.
HeadParts head_with(double radius_mm) {
  static const HeadModel model = [] {
    InlineWorkers w;
    HeadSpec spec;
    spec.edge_mm = 6, spec.face_edge_mm = 7;
    return make_head(spec, w);
  }();
  HeadParts p;
  p.bones = {{"cranium", model.cranium, true}, {"mandible", model.mandible, false}};
  p.face = model.face;
  ConnectTissue t;
  t.name = "whole", t.face_mm = t.bone_mm = Vec3(0, 108, -40), t.face_radius_mm = radius_mm;
  t.layers = 2, t.young_kPa = 15, t.mode = TissueKind::finite_elements;
  p.tissues = {t};
  return p;
}

TEST(WholeFace, TissueCoversTheSkinOverBoneSoundlyAndComesToRest) {
  InlineWorkers w;
  Head head(head_with(400), w);
  const Tissue& t = *head.face_model().tissues().front();
  const TissueQuality q = quality_of(t);
  EXPECT_GE(q.least_ratio, kSoundTissue.shape);
  EXPECT_GE(q.thinnest_mm, kSoundTissue.thickness_mm);
  EXPECT_LT(q.hovering, 0.2 * q.columns);
  // All skin that has bone beneath it, but for a few hundredths: ears, lids, nostrils.
  const FanTriangles fan = fan_triangles(head.bones_now());
  const Bvh bone(fan.X_mm, fan.tri);
  int over = 0;
  for (int32_t v = 0; v < head.face().slots(); ++v)
    over += head.face().alive(v) && bone.closest(head.face().x_mm[size_t(v)], kSkinOverBone_mm).triangle >= 0;
  EXPECT_GT(double(t.link.size()), 0.9 * over);
  // Columns are as long as the way to bone is where nothing stood in their way: at the middle of them all.
  std::vector<double> way;
  for (const auto& [v, f] : t.link) {
    Vec3 d;
    if (way_to_bone(bone, head.face().x_mm[size_t(f)], head.face().frame(f).N, 60, d)) way.push_back(d.norm());
  }
  std::sort(way.begin(), way.end());
  EXPECT_NEAR(q.median_mm, way[way.size() / 2], 0.1 * way[way.size() / 2]);

  const std::vector<Vec3> before = head.face().x_mm;
  MoveFragment m;
  for (const bone::Fragment& f : head.bones().fragments())
    if (!f.fixed) m.fragment.id = f.id;  // the mandible
  m.by.translation_mm = Vec3(0, 6, 0);
  const ActedOnHead act = head.act(HeadCommand(m));
  ASSERT_TRUE(act.done) << act.reason;
  int steps = 0;
  HeadStep s;
  do s = head.step(1. / 60);
  while (!s.at_rest && ++steps < 400);
  EXPECT_TRUE(s.at_rest);
  double most = 0;
  for (size_t v = 0; v < before.size(); ++v)
    if (head.face().alive(int32_t(v))) most = std::max(most, (head.face().x_mm[v] - before[v]).norm());
  EXPECT_GT(most, 5);
  EXPECT_LT(most, 6 * 1.2);  // skin goes with its bone, not beyond; a fold's tip a little
}

TEST(WholeFace, AFreeRimWhoseShapeDoesNotRestMovesAsItsNeighboursDo) {
  // Vertices of the free rim are drawn far over their neighbours, so that the foot of each lies outside of their
  // triangle: the constraint of shape then stretches a disturbance (fitted skin at a neck's rim, 2026-11-27).
  InlineWorkers w;
  Mesh face = make_sphere({0, 0, 0}, 60, 3), skull = make_sphere_of_faces({0, 0, 0}, 48, 600);
  append(skull, make_sphere({0, 0, -400}, 20, 1));  // it never moves
  const std::vector<int32_t> region = region_around(face, 5, 22);
  const Vec3 out = face.x_mm[5].normalized();
  std::vector<uint8_t> in(face.x_mm.size(), 0);
  for (const int32_t v : region) in[size_t(v)] = 1;
  int drawn = 0;
  for (int32_t v = 0; v < face.slots(); ++v) {
    const double far = (face.x_mm[size_t(v)].normalized() - out).norm() * 60;
    if (in[size_t(v)] || far > 40 || v % 3) continue;
    const Vec3 to = face.x_mm[size_t(face.nbr[size_t(v)][0])];
    face.x_mm[size_t(v)] += 2.2 * (to - face.x_mm[size_t(v)]), ++drawn;
  }
  ASSERT_GT(drawn, 10);
  FaceModel f(face, w);
  ASSERT_TRUE(f.connect(skull, {"cheek", region, {}, 2, 10, TissueKind::finite_elements, {}}).done);
  Mesh moved = skull;
  for (Vec3& x : moved.x_mm)
    if (x.norm() < 100) x += 4 * out;
  f.follow(moved);
  for (int i = 0; i < 300 && !f.at_rest(); ++i) f.step(12);
  EXPECT_TRUE(f.at_rest());
  double most = 0;
  for (size_t v = 0; v < face.x_mm.size(); ++v) most = std::max(most, (f.face().x_mm[v] - face.x_mm[v]).norm());
  EXPECT_LT(most, 4.5);  // 4 and what the tissue's own edge adds
}

}  // namespace test_whole_face
}  // namespace limberg
