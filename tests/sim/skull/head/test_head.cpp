// A head of spheres: a ball of bone within a ball of skin.
#include <gtest/gtest.h>

#include "sim/base/error.h"
#include "sim/patient/world.h"
#include "sim/skull/head/head.h"
#include "sim/skull/simplex/generators.h"
#include "tests/sim/skull/bone/shapes.h"
#include "tests/sim/skull/head/shell_head.h"
#include "tests/sim/skull/needs_bullet.h"

namespace limberg {
namespace test_head {

/// A ball of bone of radius 30 (may be moved) beside a fixed one, under a face of radius 38.
HeadParts ball(bool tissue = false, TissueKind mode = TissueKind::springs) {
  HeadParts p;
  p.bones.push_back({"ball", simplex::make_sphere({0, 0, 0}, 30, 3), false});
  p.bones.push_back({"anvil", simplex::make_sphere({0, 0, -200}, 20, 2), true});
  p.face = simplex::make_sphere({0, 0, 0}, 38, 3);
  simplex::record_shape(p.face);
  p.landmarks = {{"top", {0, 0, 30}, false}, {"bottom", {0, 0, -30}, false}, {"crown", {0, 0, 38}, true}};
  if (tissue) {
    ConnectTissue t;
    t.name = "cap", t.face_mm = {0, 0, 38}, t.bone_mm = {0, 0, 30}, t.face_radius_mm = 30, t.layers = 2;
    t.mode = mode;
    p.tissues.push_back(t);
  }
  return p;
}

CutBone halve() {
  CutBone c;
  c.point_mm = {0, 0, 5}, c.normal = Vec3::UnitZ();
  return c;
}

MoveFragment lift(const Vec3& at, const Vec3& by) {
  MoveFragment m;
  m.fragment = {-1, at};
  m.by.translation_mm = by;
  return m;
}

/// A patient of bone and face.
class Skull : public World {
 public:
  Skull(HeadParts parts, Workers& w) : World(std::move(parts), w) {}
  const bone::Bones& bones() const { return head()->bones(); }
  const simplex::Mesh& face() const { return head()->face(); }
  const simplex::FaceModel& face_model() const { return head()->face_model(); }
  const std::vector<HeadLandmark>& landmarks() const { return head()->landmarks(); }
  const std::vector<ConnectTissue>& tissues() const { return head()->tissues(); }
  /// True at rest.
  bool step() { return World::step({}).residual == 0; }
};

Vec3 landmark(const Skull& h, const std::string& name) {
  for (const auto& [n, x] : h.head()->landmarks_now())
    if (n == name) return x;
  return Vec3::Constant(1e9);
}

TEST(Head, AnOsteotomyFreesAFragmentThatTakesItsLandmarksAlong) {
  InlineWorkers w;
  Skull h(ball(), w);
  ASSERT_EQ(h.bones().fragments().size(), 2u);
  const Outcome cut = h.apply(HeadCommand(halve()));
  ASSERT_TRUE(cut.done) << cut.reason;
  EXPECT_EQ(h.bones().fragments().size(), 3u);
  ASSERT_TRUE(h.apply(HeadCommand(lift({0, 0, 30}, {0, 3, 8}))).done);
  h.step();
  EXPECT_LT((landmark(h, "top") - Vec3(0, 3, 38)).norm(), 0.5);
  EXPECT_LT((landmark(h, "bottom") - Vec3(0, 0, -30)).norm(), 0.5);
}

TEST(Head, RefusalsSayWhyAndChangeNothing) {
  InlineWorkers w;
  Skull h(ball(), w);
  const uint64_t before = h.state_hash();
  const auto refused = [&](const Command& c, const char* says) {
    const Outcome o = h.apply(c);
    EXPECT_FALSE(o.done);
    EXPECT_NE(o.reason.find(says), std::string::npos) << o.reason;
    EXPECT_EQ(h.state_hash(), before);
  };
  refused(Incise{}, "no skin with flap tools");
  refused(HeadCommand(MoveFragment{{17, Vec3::Zero()}, {}, 1}), "no fragment 17");
  refused(HeadCommand(lift({0, 0, -180}, {0, 0, 1})), "anvil is fixed");
  refused(HeadCommand(lift({500, 0, 0}, {0, 0, 1})), "no bone within 15 mm");
  refused(HeadCommand(DragFragment{}), "nothing is held");
  refused(HeadCommand(LetGo{}), "nothing is held");
  refused(HeadCommand(Unplate{{0, Vec3::Zero()}}), "no plate on ball");
  refused(HeadCommand(SortFragments{}), "no fragment fits another");
  refused(HeadCommand(PlaceLandmark{"far", {0, 0, 300}, false}), "more than 20 mm");
  refused(Undo{}, "nothing to undo");
  CutBone beside = halve();
  beside.point_mm = {0, 0, 90};
  EXPECT_FALSE(h.apply(HeadCommand(beside)).done);
  EXPECT_EQ(h.state_hash(), before);
  EXPECT_EQ(h.refused(), 11);
}

TEST(Head, ARegionMayBeDrawnInsteadOfADisc) {
  InlineWorkers w;
  Skull disc(ball(), w), drawn(ball(), w), beside(ball(), w);
  ConnectTissue t;
  t.name = "cap", t.face_mm = {0, 0, 38}, t.bone_mm = {0, 0, 30}, t.face_radius_mm = 20, t.mode = TissueKind::springs;
  ASSERT_TRUE(disc.apply(HeadCommand(t)).done);
  const double R = 38;  // of the face
  for (int i = 0; i < 36; ++i)
    t.face_outline_mm.push_back({R * std::sin(20 / R) * std::cos(i * M_PI / 18),
                                 R * std::sin(20 / R) * std::sin(i * M_PI / 18), R * std::cos(20 / R)});
  Outcome o = drawn.apply(HeadCommand(t));
  ASSERT_TRUE(o.done) << o.reason;
  const auto vertices = [](Skull& h) { return double(h.head()->face_model().tissues()[0]->link.size()); };
  const double share = (1 - std::cos(20 / R)) / 2;  // of the ball, that its cap has
  EXPECT_NEAR(vertices(drawn), share * double(drawn.face().vertices()), 0.1 * vertices(drawn));
  EXPECT_LT(vertices(disc), vertices(drawn));  // ways along edges are longer than those on the ball
  for (Vec3& x : t.face_outline_mm) x += Vec3(300, 0, 0);
  o = beside.apply(HeadCommand(t));
  EXPECT_FALSE(o.done);
  EXPECT_NE(o.reason.find("within face_outline"), std::string::npos);
}

TEST(Head, UndoAndRedoGoThroughEveryKindOfAct) {
  InlineWorkers w;
  Skull h(ball(), w);
  ConnectTissue t;
  t.name = "cap", t.face_mm = {0, 0, 38}, t.bone_mm = {0, 0, 30}, t.face_radius_mm = 25, t.mode = TissueKind::springs;
  const std::vector<Command> acts{HeadCommand(t),
                                  HeadCommand(PlaceLandmark{"side", {30, 0, 0}, false}),
                                  HeadCommand(halve()),
                                  HeadCommand(lift({0, 0, 30}, {0, 0, 6})),
                                  HeadCommand(PlateFragments{{25, 0, 15}, {27, 0, 0}}),
                                  HeadCommand(Unplate{{-1, {25, 0, 15}}})};
  std::vector<uint64_t> bones{h.bones().hash()};
  std::vector<size_t> landmarks{h.landmarks().size()}, tissues{0};
  for (const Command& c : acts) {
    const Outcome o = h.apply(c);
    ASSERT_TRUE(o.done) << o.reason;
    bones.push_back(h.bones().hash()), landmarks.push_back(h.landmarks().size()), tissues.push_back(h.tissues().size());
  }
  for (int round = 0; round < 2; ++round) {
    for (size_t k = acts.size(); k-- > 0;) {
      ASSERT_TRUE(h.apply(Undo{}).done);
      EXPECT_EQ(h.bones().hash(), bones[k]);
      EXPECT_EQ(h.landmarks().size(), landmarks[k]);
      EXPECT_EQ(h.tissues().size(), tissues[k]);
      h.step();
    }
    EXPECT_FALSE(h.apply(Undo{}).done);
    for (size_t k = 1; k <= acts.size(); ++k) {
      ASSERT_TRUE(h.apply(Redo{}).done);
      EXPECT_EQ(h.bones().hash(), bones[k]);
      EXPECT_EQ(h.landmarks().size(), landmarks[k]);
      EXPECT_EQ(h.tissues().size(), tissues[k]);
    }
    EXPECT_FALSE(h.apply(Redo{}).done);
  }
}

TEST(Head, FragmentsAreSortedWithTheirLandmarks) {
  InlineWorkers w;
  Skull h(test::shell_head(), w);
  CutBone vault, halves;
  vault.point_mm = {0, 0, 12}, vault.normal = {0.1, 0.25, 1};
  halves.point_mm = {5, 10, 0}, halves.normal = {0.15, 1, 0.1}, halves.of = FragmentPick{1, Vec3::Zero()};
  ASSERT_TRUE(h.apply(HeadCommand(vault)).done);
  ASSERT_TRUE(h.apply(HeadCommand(halves)).done);
  ASSERT_EQ(h.bones().fragments().size(), 3u);
  const Vec3 front = landmark(h, "front"), back = landmark(h, "back");
  MoveFragment away;
  away.fragment.id = 1, away.by.translation_mm = {120, 40, -30}, away.by.rotation_deg = {10, 70, -20};
  ASSERT_TRUE(h.apply(HeadCommand(away)).done);
  away.fragment.id = 2, away.by.translation_mm = {-90, 20, 60}, away.by.rotation_deg = {-40, 5, 100};
  ASSERT_TRUE(h.apply(HeadCommand(away)).done);
  EXPECT_GT((landmark(h, "front") - front).norm(), 50);
  const uint64_t apart = h.state_hash();
  const Outcome o = h.apply(HeadCommand(SortFragments{}));
  ASSERT_TRUE(o.done) << o.reason;
  EXPECT_LT((landmark(h, "front") - front).norm(), 0.5);
  EXPECT_LT((landmark(h, "back") - back).norm(), 0.5);
  ASSERT_TRUE(h.apply(Undo{}).done);
  EXPECT_EQ(h.state_hash(), apart);
}

TEST(Head, APlateIsShownWhereItsFragmentsAreNow) {
  InlineWorkers w;
  Skull h(ball(), w);
  ASSERT_TRUE(h.apply(HeadCommand(halve())).done);
  ASSERT_TRUE(h.apply(HeadCommand(lift({0, 0, 30}, {0, 0, 6}))).done);
  Snapshot s;
  h.fill(s);
  EXPECT_TRUE(s.plate_mm.empty());
  ASSERT_TRUE(h.apply(HeadCommand(PlateFragments{{25, 0, 15}, {27, 0, 0}})).done);
  h.fill(s);
  ASSERT_EQ(s.plate_mm.size(), 1u);
  EXPECT_LT((s.plate_mm[0][0] - Vec3f(25, 0, 21)).norm(), 2);  // the surface of a coarse ball, and 6 mm
  EXPECT_LT((s.plate_mm[0][1] - Vec3f(27, 0, 0)).norm(), 3.5);
  ASSERT_TRUE(h.apply(HeadCommand(Unplate{{-1, {0, 0, 30}}})).done);
  h.fill(s);
  EXPECT_TRUE(s.plate_mm.empty());
}

TEST(Head, AMovedFragmentSaysHowItLies) {
  InlineWorkers w;
  Skull h(ball(), w);
  ASSERT_TRUE(h.apply(HeadCommand(halve())).done);
  // A plane cut pulled straight apart gapes by as much everywhere; pushed back into itself it overlaps by as much.
  Outcome o = h.apply(HeadCommand(lift({0, 0, 30}, {0, 0, 4})));
  EXPECT_EQ(o.reason, "ball: gap 4.0 mm, at most 4.0") << o.reason;
  o = h.apply(HeadCommand(lift({0, 0, 30}, {0, 0, -7})));
  EXPECT_NE(o.reason.find("overlap 3.0 mm deep"), std::string::npos) << o.reason;
  o = h.apply(HeadCommand(lift({0, 0, 30}, {0, 0, 3})));
  EXPECT_EQ(o.reason, "");
}

TEST(Head, HoweverLongANameIsTheNumbersBehindItAreSaid) {
  LIMBERG_NEEDS_BULLET();
  InlineWorkers w;
  HeadParts p = ball();
  p.bones[0].name = std::string(300, 'b');
  Skull h(std::move(p), w);
  ASSERT_TRUE(h.apply(HeadCommand(halve())).done);
  EXPECT_NE(h.apply(HeadCommand(lift({0, 0, 30}, {0, 0, 6}))).reason.find("gap 6.0 mm, at most 6.0"),
            std::string::npos);
  ASSERT_TRUE(h.apply(HeadCommand(GrabFragment{{-1, {0, 0, 30}}, 0})).done);
  EXPECT_NE(h.apply(HeadCommand(LetGo{true, 0})).reason.find("at most 3 mm and 10 degrees was expected"),
            std::string::npos);
}

TEST(Head, ASnapThatChangesNothingIsAnActLikeAnyOther) {
  LIMBERG_NEEDS_BULLET();
  InlineWorkers w;
  Skull h(ball(), w);
  const uint64_t whole = h.bones().hash();
  ASSERT_TRUE(h.apply(HeadCommand(halve())).done);
  const uint64_t cut = h.bones().hash();
  const Vec3 top(0, 0, 30);
  ASSERT_TRUE(h.apply(HeadCommand(GrabFragment{{-1, top}, 0})).done);
  const Outcome snap = h.apply(HeadCommand(LetGo{true, 0}));
  ASSERT_TRUE(snap.done);
  EXPECT_NE(snap.reason.find("fits into its cut"), std::string::npos) << snap.reason;
  EXPECT_EQ(h.bones().hash(), cut);
  ASSERT_TRUE(h.apply(Undo{}).done);  // of the snap
  EXPECT_EQ(h.bones().hash(), cut);
  ASSERT_TRUE(h.apply(Undo{}).done);  // of the cut
  EXPECT_EQ(h.bones().hash(), whole);
  EXPECT_FALSE(h.apply(Undo{}).done);
  // Too far away for a snap: it stays, and says so.
  ASSERT_TRUE(h.apply(Redo{}).done);
  ASSERT_TRUE(h.apply(HeadCommand(lift(top, {0, 0, 6}))).done);
  const uint64_t lifted = h.bones().hash();
  ASSERT_TRUE(h.apply(HeadCommand(GrabFragment{{-1, top}, 0})).done);
  const Outcome far = h.apply(HeadCommand(LetGo{true, 0}));
  EXPECT_NE(far.reason.find("stays: 6.0 mm and 0 degrees from fitting"), std::string::npos) << far.reason;
  EXPECT_EQ(h.bones().hash(), lifted);
}

TEST(Head, TheViewIsTheMeshes) {
  InlineWorkers w;
  Skull h(ball(true), w);
  ASSERT_TRUE(h.apply(HeadCommand(halve())).done);
  ASSERT_TRUE(h.apply(HeadCommand(lift({0, 0, 30}, {0, 0, 8}))).done);
  h.step();
  Snapshot s;
  h.fill(s);
  const SurfaceTopology& top = *s.topology;
  ASSERT_EQ(s.x_mm.size(), top.view.X_mm.size());
  ASSERT_EQ(s.moved_mm.size(), s.x_mm.size());
  // What is shown to have moved is what the mesh's vertices have moved, and the figure in the window is their largest.
  double most = 0;
  for (int32_t v = 0; v < h.face().slots(); ++v)
    if (h.face().alive(v))
      most = std::max(most, (h.face().x_mm[size_t(v)] - h.face_model().rest_mm()[size_t(v)]).norm());
  EXPECT_GT(most, 1);
  EXPECT_NEAR(*std::max_element(s.moved_mm.begin(), s.moved_mm.end()), most, 1e-4);
  ASSERT_EQ(top.organ.size(), top.view.tri.size());
  EXPECT_FALSE(top.strand.empty());
  EXPECT_EQ(s.landmark_mm.size(), top.landmark.size());
  size_t cut = 0, bone = 0, face = 0;
  double outward = 0;
  for (size_t t = 0; t < top.view.tri.size(); ++t) {
    const Tri& k = top.view.tri[t];
    const Vec3 a = top.view.X_mm[size_t(k[0])], b = top.view.X_mm[size_t(k[1])], c = top.view.X_mm[size_t(k[2])];
    cut += top.organ[t] == Organ::bone_cut, bone += top.organ[t] == Organ::bone, face += top.organ[t] == Organ::face;
    if (top.organ[t] == Organ::face) outward += a.dot((b - a).cross(c - a)) / 6;
    if (top.organ[t] == Organ::face) continue;
    // Each triangle of bone is where its fragment is, as a rigid body.
    const Eigen::Isometry3d pose = h.bones().fragment(top.object[t])->pose;
    for (const int32_t v : k)
      EXPECT_LT((pose * top.view.X_mm[size_t(v)] - s.x_mm[size_t(v)].cast<double>()).norm(), 1e-4);
  }
  EXPECT_GT(cut, 10u);
  EXPECT_GT(bone, 1000u);
  EXPECT_GT(face, 1000u);
  EXPECT_NEAR(outward, 4.0 / 3 * M_PI * 38 * 38 * 38, 0.02 * outward);  // counter-clockwise from outside
}

TEST(Head, TheFaceFollowsTheBone) {
  InlineWorkers w;
  Skull h(ball(true, TissueKind::finite_elements), w);
  const Vec3 before = landmark(h, "crown");
  ASSERT_TRUE(h.apply(HeadCommand(halve())).done);
  ASSERT_TRUE(h.apply(HeadCommand(lift({0, 0, 30}, {0, 0, 6}))).done);
  for (int i = 0; i < 400 && (i == 0 || !h.step()); ++i) {
  }
  const Vec3 moved = landmark(h, "crown") - before;
  EXPECT_GT(moved.z(), 3);
  EXPECT_LT(moved.z(), 7);
  EXPECT_LT(Vec2(moved.x(), moved.y()).norm(), 1);
  // What lies far away stays.
  EXPECT_LT((h.face().x_mm[0] - h.face_model().rest_mm()[0]).norm(), 8);
  double below = 0;
  for (int32_t v = 0; v < h.face().slots(); ++v)
    if (h.face_model().rest_mm()[size_t(v)].z() < -30)
      below = std::max(below, (h.face().x_mm[size_t(v)] - h.face_model().rest_mm()[size_t(v)]).norm());
  EXPECT_LT(below, 1.5);
}

TEST(Head, AJoinDoesNotMoveTheFace) {
  // The rest of one of the two is set anew by the join: the tissue has to know where on it it stands.
  for (TissueKind mode : {TissueKind::shape, TissueKind::finite_elements}) {
    InlineWorkers w;
    Skull h(ball(true, mode), w);
    ASSERT_TRUE(h.apply(HeadCommand(halve())).done);
    MoveFragment m = lift({0, 0, 30}, {1.5, 0, 2});
    m.by.rotation_deg = {0, 0, 20};
    ASSERT_TRUE(h.apply(HeadCommand(m)).done);
    for (int i = 0; i < 600 && (i == 0 || !h.step()); ++i) {
    }
    const std::vector<Vec3> face = h.face().x_mm;
    const Outcome o = h.apply(HeadCommand(JoinFragments{{-1, {0, 0, -30}}, {-1, {0, 0, 30}}}));
    ASSERT_TRUE(o.done) << o.reason;
    double far = 0;
    for (int i = 0; i < 60; ++i) h.step();
    for (size_t v = 0; v < face.size(); ++v) far = std::max(far, (h.face().x_mm[v] - face[v]).norm());
    EXPECT_LT(far, 0.02) << int(mode);  // (feet along the cut stand on new vertices)
    ASSERT_TRUE(h.apply(Undo{}).done);
    for (int i = 0; i < 60; ++i) h.step();
    far = 0;
    for (size_t v = 0; v < face.size(); ++v) far = std::max(far, (h.face().x_mm[v] - face[v]).norm());
    EXPECT_LT(far, 1e-6) << int(mode);
  }
}

TEST(Head, AHandCarriesAFragmentAndTheSameHandLetsItGo) {
  LIMBERG_NEEDS_BULLET();
  InlineWorkers w;
  Skull h(ball(), w);
  ASSERT_TRUE(h.apply(HeadCommand(halve())).done);
  ASSERT_TRUE(h.apply(HeadCommand(GrabFragment{{-1, {0, 0, 30}}, 1})).done);
  EXPECT_FALSE(h.apply(HeadCommand(GrabFragment{{-1, {0, 0, 30}}, 0})).done);   // of another hand
  EXPECT_FALSE(h.apply(HeadCommand(GrabFragment{{-1, {0, 0, -30}}, 1})).done);  // full
  EXPECT_FALSE(h.apply(HeadCommand(DragFragment{{}, 0, 0})).done);
  EXPECT_FALSE(h.apply(Undo{}).done);  // while it is held
  for (int i = 1; i <= 80; ++i) {
    DragFragment d;
    d.hand = 1, d.to.translation_mm = {0, 0, 0.1 * i};
    ASSERT_TRUE(h.apply(HeadCommand(d)).done);
    h.step();
  }
  for (int i = 0; i < 30; ++i) h.step();
  ASSERT_TRUE(h.apply(HeadCommand(LetGo{false, 1})).done);
  h.step();
  EXPECT_NEAR(landmark(h, "top").z(), 38, 0.5);
  const uint64_t moved = h.bones().hash();
  ASSERT_TRUE(h.apply(Undo{}).done);
  EXPECT_NEAR(landmark(h, "top").z(), 30, 0.5);
  ASSERT_TRUE(h.apply(Redo{}).done);
  EXPECT_EQ(h.bones().hash(), moved);
}

// Two gloves: each half in a hand; what one lets go is an act of its own, whatever the other does meanwhile.
TEST(Head, TwoHandsCarryAFragmentEach) {
  LIMBERG_NEEDS_BULLET();
  InlineWorkers w;
  Skull h(ball(), w);
  ASSERT_TRUE(h.apply(HeadCommand(halve())).done);
  const auto take = [&](int hand, const Vec3& by) {
    DragFragment d;
    d.hand = hand, d.to.translation_mm = by;
    ASSERT_TRUE(h.apply(HeadCommand(d)).done);
  };
  const uint64_t first = h.bones().hash();
  ASSERT_TRUE(h.apply(HeadCommand(GrabFragment{{-1, {0, 0, 30}}, 1})).done);
  for (int i = 1; i <= 20; ++i) take(1, {0, 0, 0.25 * i}), h.step();
  ASSERT_TRUE(h.apply(HeadCommand(GrabFragment{{-1, {0, 0, -30}}, 2})).done);
  for (int i = 1; i <= 40; ++i) take(1, {0, 0, 5 + 0.1 * i}), take(2, {0.1 * i, 0, -0.2 * i}), h.step();
  ASSERT_TRUE(h.apply(HeadCommand(LetGo{false, 1})).done);
  EXPECT_FALSE(h.apply(Undo{}).done);  // the other hand still holds
  for (int i = 1; i <= 20; ++i) take(2, {4, 0, -8 - 0.1 * i}), h.step();
  ASSERT_TRUE(h.apply(HeadCommand(LetGo{false, 2})).done);
  h.step();
  const auto at = [&](const Vec3& place) {
    const auto& bones = h.bones();
    const bone::Fragment& f = *bones.fragment(bones.nearest_fragment(place));
    return Vec3(f.pose.translation());
  };
  EXPECT_LT((at({0, 0, 30}) - Vec3(0, 0, 9)).norm(), 1e-9);  // nothing was in the way
  EXPECT_LT((at({0, 0, -30}) - Vec3(4, 0, -10)).norm(), 1e-9);
  const uint64_t moved = h.bones().hash();
  ASSERT_TRUE(h.apply(Undo{}).done);
  EXPECT_LT((at({0, 0, 30}) - Vec3(0, 0, 9)).norm(), 1e-9);  // only what the second hand did is taken back
  EXPECT_LT(at({0, 0, -30}).norm(), 1e-12);
  ASSERT_TRUE(h.apply(Undo{}).done);
  EXPECT_EQ(h.bones().hash(), first);
  ASSERT_TRUE(h.apply(Redo{}).done);
  EXPECT_LT(at({0, 0, -30}).norm(), 1e-12);
  ASSERT_TRUE(h.apply(Redo{}).done);
  EXPECT_EQ(h.bones().hash(), moved);
}

TEST(Head, WhatCannotBeBuiltIsAnInputError) {
  InlineWorkers w;
  HeadParts p = ball(true);
  p.tissues.push_back(p.tissues[0]);  // of the same name
  EXPECT_THROW(Head(std::move(p), w), InputError);
  HeadParts q = ball();
  q.face = {};
  EXPECT_THROW(Head(std::move(q), w), InputError);  // a landmark on a face that is not there
}

}  // namespace test_head
}  // namespace limberg
