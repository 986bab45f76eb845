// Acts on a head in the controls of old recordings, and names for what a tool touches: from a control to the command.
#include <gtest/gtest.h>

#include "devices/command_builder.h"
#include "devices/gestures.h"
#include "devices/message_codec.h"
#include "devices/old_controls.h"
#include "tests/devices/flat_patient.h"

namespace limberg {
namespace test_pick {

using namespace test;

/// Bone everywhere, lifted by 7 mm since it was at rest; two landmarks.
Snapshot bone_with_landmarks() {
  auto t = flat_topology(40, 1);
  for (size_t i = 0; i < t->view.tri.size(); ++i)
    t->organ.push_back(Organ::bone), t->object.push_back(3), t->view.kind[i] = FaceKind::free;
  t->landmark = {"pog'", "Pog"};
  Snapshot s = snapshot_of(t, [](const Vec3& X) { return Vec3(X + Vec3(0, 0, 7)); });
  s.landmark_mm = {{1, 2, 30}, {1, 2, 7}};
  return s;
}

ControlSample control(int32_t kind, const std::string& text, std::array<double, 4> value) {
  ControlSample c;
  c.kind = kind, c.text = ShortText(text), c.value = value;
  return c;
}

std::optional<Command> command_of(Gestures& g, const ControlSample& c, const Snapshot& s) {
  Events out;
  g.control(c, 5, s, out);
  CommandBuilder builder;
  std::optional<Command> made;
  for (const ToolEvent& e : out.all)
    if (auto k = builder.feed(e)) made = k;
  return made;
}

TEST(Pick, APlaceUnderTheMouseBecomesALandmark) {
  const Snapshot s = bone_with_landmarks();
  Gestures g;
  const auto on_bone = command_of(g, control(OldControls::landmark, "M1", {3, -4, 0.5, 1}), s);
  ASSERT_TRUE(on_bone);
  const auto& l = std::get<PlaceLandmark>(std::get<HeadCommand>(*on_bone));
  EXPECT_EQ(l.name, "M1");
  EXPECT_EQ(l.at_mm, Vec3(3, -4, 0.5));
  EXPECT_FALSE(l.on_face);
  const auto on_face = command_of(g, control(OldControls::landmark, "al_R", {3, -4, 20, 2}), s);
  ASSERT_TRUE(on_face);
  EXPECT_TRUE(std::get<PlaceLandmark>(std::get<HeadCommand>(*on_face)).on_face);
}

TEST(Pick, APanelMovesPlatesJoinsAndSawsByNumbers) {
  const Snapshot s = bone_with_landmarks();
  Gestures g;
  const auto made = [&](int32_t kind, const std::string& text, std::array<double, 4> value) {
    return command_of(g, control(kind, text, value), s);
  };
  const auto shift = made(OldControls::shift, "0 -8 1.5 3 0 -5", {1, 2, 3, 0});
  ASSERT_TRUE(shift);
  const auto& m = std::get<MoveFragment>(std::get<HeadCommand>(*shift));
  EXPECT_EQ(m.fragment.id, -1);
  EXPECT_EQ(m.fragment.at_mm, Vec3(1, 2, 3));
  EXPECT_EQ(m.by.translation_mm, Vec3(0, -8, 1.5));
  EXPECT_EQ(m.by.rotation_deg, Vec3(3, 0, -5));
  const auto plate = made(OldControls::plate, "4 5 6", {1, 2, 3, 0});
  ASSERT_TRUE(plate);
  EXPECT_EQ(std::get<PlateFragments>(std::get<HeadCommand>(*plate)).b_mm, Vec3(4, 5, 6));
  const auto join = made(OldControls::join, "4 5 6", {1, 2, 3, 0});
  ASSERT_TRUE(join);
  EXPECT_EQ(std::get<JoinFragments>(std::get<HeadCommand>(*join)).a.at_mm, Vec3(1, 2, 3));
  const auto plane = made(OldControls::plane, "0 0.6 0.8", {1, 2, 3, 25});
  ASSERT_TRUE(plane);
  const auto& cut = std::get<CutBone>(std::get<HeadCommand>(*plane));
  EXPECT_TRUE(cut.contour_mm.empty());
  EXPECT_EQ(cut.normal, Vec3(0, 0.6, 0.8));
  EXPECT_EQ(cut.radius_mm, 25);
  // Numbers that are not there move nothing.
  const int64_t missed = g.missed_presses();
  for (const char* text : {"", "0 8", "0 8 x 0 0 0", "nan 0 0 0 0 0"})
    EXPECT_FALSE(made(OldControls::shift, text, {1, 2, 3, 0})) << text;
  EXPECT_FALSE(made(OldControls::plate, "4 5", {1, 2, 3, 0}));
  EXPECT_EQ(g.missed_presses(), missed + 5);
}

TEST(Pick, CornersAreTheContourItselfAndASnapIsTakenAndLetGo) {
  const Snapshot s = bone_with_landmarks();
  Gestures g;
  CommandBuilder builder;
  std::vector<Command> made;
  const std::vector<Vec3> corner{{0, 0, 0}, {9, 0, 0}, {9, 9, 0}, {0, 9, 0}};
  const auto feed = [&](const ControlSample& c) {
    Events out;
    g.control(c, 5, s, out);
    for (const ToolEvent& e : out.all)
      if (auto k = builder.feed(e)) made.push_back(*k);
  };
  for (size_t k = 0; k < 4; ++k)
    feed(control(OldControls::corner, "",
                 {corner[k].x(), corner[k].y(), corner[k].z(),
                  k == 0  ? 0.
                  : k < 3 ? 1.
                          : 2.}));
  ASSERT_EQ(made.size(), 1u);
  EXPECT_EQ(std::get<CutBone>(std::get<HeadCommand>(made[0])).contour_mm, corner);
  feed(control(OldControls::snap, "", {3, 3, 0, 0}));
  ASSERT_EQ(made.size(), 3u);
  EXPECT_EQ(std::get<GrabFragment>(std::get<HeadCommand>(made[1])).fragment.at_mm, Vec3(3, 3, 0));
  EXPECT_TRUE(std::get<LetGo>(std::get<HeadCommand>(made[2])).snap);
}

TEST(Pick, ATrackedToolPicksWhereItTouchesAtRest) {
  const Snapshot s = bone_with_landmarks();
  Gestures g;
  Events out;
  EXPECT_FALSE(command_of(g, control(ControlSample::name_place, "M1", {0, 0, 0, double(kTouchedBone)}),
                          s));  // nothing is touched yet
  EXPECT_EQ(g.missed_presses(), 1);
  ControlSample saw;
  saw.kind = ControlSample::select_tool, saw.tool = Tool::saw;
  g.control(saw, 0, s, out);
  Pose p;
  p.tip_mm = {-12, 9, 7.5}, p.valid = true;
  for (int i = 1; i < 20; ++i) g.tick(i, p, false, 0, s, out);
  const auto made = command_of(g, control(ControlSample::name_place, "M1", {0, 0, 0, double(kTouchedBone)}), s);
  ASSERT_TRUE(made);
  const auto& l = std::get<PlaceLandmark>(std::get<HeadCommand>(*made));
  EXPECT_LT((l.at_mm - Vec3(-12, 9, 0)).norm(), 1e-4);
  const auto above = command_of(g, control(ControlSample::name_place, "M2", {0, 0, 0, double(kFaceNearTip)}), s);
  ASSERT_TRUE(above);
  EXPECT_TRUE(std::get<PlaceLandmark>(std::get<HeadCommand>(*above)).on_face);
  EXPECT_LT((std::get<PlaceLandmark>(std::get<HeadCommand>(*above)).at_mm - p.tip_mm).norm(), 1e-9);
}

TEST(Pick, TissueLiesBetweenTwoNamedPlacesWhereTheyAreNow) {
  const Snapshot s = bone_with_landmarks();
  Gestures g;
  const auto made = command_of(g, control(OldControls::tissue, "pog'/Pog", {28, 40, 3, 12}), s);
  ASSERT_TRUE(made);
  const auto& t = std::get<ConnectTissue>(std::get<HeadCommand>(*made));
  EXPECT_EQ(t.name, "pog'-Pog");
  EXPECT_EQ(t.face_mm, Vec3(1, 2, 30));
  EXPECT_EQ(t.bone_mm, Vec3(1, 2, 7));
  EXPECT_EQ(t.face_radius_mm, 28);
  EXPECT_EQ(t.bone_radius_mm, 40);
  EXPECT_EQ(t.layers, 3);
  EXPECT_EQ(t.young_kPa, 12);
  EXPECT_EQ(t.mode, TissueKind::finite_elements);
  for (const char* mode : kTissueKinds) {
    const auto in = command_of(g, control(OldControls::tissue, std::string("pog'/Pog/") + mode, {28, 40, 3, 12}), s);
    ASSERT_TRUE(in) << mode;
    const auto& named = std::get<ConnectTissue>(std::get<HeadCommand>(*in));
    EXPECT_EQ(named.name, "pog'-Pog");
    EXPECT_STREQ(kTissueKinds[size_t(named.mode)], mode);
    EXPECT_EQ(named.layers, 3);
  }
  for (const char* wrong : {"pog'/Nowhere", "Nowhere/Pog", "pog'", "", "/", "pog'/Pog/rubber", "pog'/Pog/"})
    EXPECT_FALSE(command_of(g, control(OldControls::tissue, wrong, {28, 40, 3, 12}), s)) << wrong;
}

TEST(Pick, TheSkullIsLaidUponAnother) {
  const Snapshot s = bone_with_landmarks();
  Gestures g;
  const auto made = command_of(g, control(OldControls::beside, "advanced", {2, 0, 0, 0}), s);
  ASSERT_TRUE(made);
  const auto& p = std::get<Superpose>(std::get<HeadCommand>(*made));
  EXPECT_EQ(p.on, SkullBeside::mirror);
  EXPECT_EQ(p.name, "advanced");
  EXPECT_EQ(
      std::get<Superpose>(std::get<HeadCommand>(*command_of(g, control(OldControls::beside, "", {7e5, 0, 0, 0}), s)))
          .on,
      SkullBeside::mirror);
}

TEST(Pick, ControlsAreRecordedAndReadBack) {
  for (int32_t kind : {int32_t(OldControls::landmark), int32_t(OldControls::tissue), int32_t(OldControls::beside),
                       int32_t(ControlSample::clutch)}) {
    const ControlSample c = control(kind, "pog'/Pog", {1, 2, 3, 4});
    ControlSample back;
    ASSERT_EQ(to_sample(to_message(c), back, true), nullptr);
    EXPECT_EQ(back.kind, kind);
    EXPECT_EQ(back.text, c.text);
    EXPECT_EQ(back.value, c.value);
  }
  ControlSample back;
  EXPECT_NE(to_sample(to_message(control(ControlSample::kLastKind + 1, "", {})), back, true), nullptr);
}

}  // namespace test_pick
}  // namespace limberg
