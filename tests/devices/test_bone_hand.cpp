// Saw, grab and glove on bone: a flat patient whose left half is bone.
#include <gtest/gtest.h>

#include <numbers>

#include "devices/bone_contour.h"
#include "devices/command_builder.h"
#include "devices/gestures.h"
#include "devices/virtual_hand.h"
#include "tests/devices/flat_patient.h"

namespace limberg {
namespace test_bone_hand {

using namespace test;

std::shared_ptr<SurfaceTopology> half_bone() {
  auto t = flat_topology(40, 1);
  const SurfaceView& v = t->view;
  for (size_t i = 0; i < v.tri.size(); ++i) {
    const bool bone =
        v.X_mm[size_t(v.tri[i][0])].x() + v.X_mm[size_t(v.tri[i][1])].x() + v.X_mm[size_t(v.tri[i][2])].x() < 0;
    t->organ.push_back(bone ? Organ::bone : Organ::flesh);
    t->object.push_back(bone ? 3 : -1);
    if (bone) t->view.kind[i] = FaceKind::free;
  }
  return t;
}

Pose at(const Vec3& tip) {
  Pose p;
  p.tip_mm = tip, p.valid = true;
  return p;
}

ControlSample choose(Tool tool) {
  ControlSample c;
  c.kind = ControlSample::select_tool, c.tool = tool;
  return c;
}

TEST(BoneHand, TheSawDrawsOnBoneOnlyAndItsLineBecomesAnOsteotomy) {
  const Snapshot s = snapshot_of(half_bone(), [](const Vec3& X) { return Vec3(X + Vec3(0, 0, 7)); });  // as it lies now
  Gestures g;
  Events out;
  g.control(choose(Tool::saw), 0, s, out);
  int64_t tick = 1;
  // On skin there is nothing to saw.
  g.tick(tick++, at({40, 0, 7}), false, 0, s, out);
  g.tick(tick++, at({40, 0, 7}), true, 1, s, out);
  g.tick(tick++, at({40, 0, 7}), false, 1, s, out);
  EXPECT_EQ(out.count(ToolEvent::stroke_begin), 0);
  EXPECT_EQ(g.missed_presses(), 1);
  const auto circle = [](double turn) { return Vec3(-30 + 15 * std::cos(turn), 15 * std::sin(turn), 7); };
  for (int i = 0; i < 20; ++i) g.tick(tick++, at(circle(0)), false, 0, s, out);
  constexpr int n = 2000;
  for (int i = 0; i <= n; ++i)
    g.tick(tick++, at(circle(2.1 * std::numbers::pi * i / n)), true, i == 0, s, out);  // a little beyond
  g.tick(tick++, at(circle(0.1 * std::numbers::pi)), false, 1, s, out);
  CommandBuilder builder;
  std::optional<Command> made;
  for (const ToolEvent& e : out.all)
    if (auto c = builder.feed(e)) made = c;
  ASSERT_TRUE(made);
  const auto& cut = std::get<CutBone>(std::get<HeadCommand>(*made));
  EXPECT_GT(cut.contour_mm.size(), 30u);
  for (size_t i = 0; i < cut.contour_mm.size(); ++i) {
    const Vec3& p = cut.contour_mm[i];
    EXPECT_NEAR(p.z(), 0, 1e-5);  // at rest
    EXPECT_NEAR((p - Vec3(-30, 0, 0)).norm(), 15, 0.25);
    EXPECT_NEAR((p - cut.contour_mm[(i + 1) % cut.contour_mm.size()]).norm(), 2, 0.35);  // closed, even, drawn once
  }
}

TEST(BoneHand, AScratchIsNoOsteotomy) {
  EXPECT_TRUE(bone_contour({}).empty());
  EXPECT_TRUE(bone_contour({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}, {4, 0, 0}}).empty());
}

TEST(BoneHand, TheStylusCarriesAFragment) {
  const Snapshot s = snapshot_of(half_bone());
  Gestures g;
  Events out;
  g.control(choose(Tool::grab), 0, s, out);
  int64_t tick = 1;
  for (int i = 0; i < 20; ++i) g.tick(tick++, at({-30, 5, 0}), false, 0, s, out);
  g.tick(tick++, at({-30, 5, 0}), true, 1, s, out);
  ASSERT_EQ(out.count(ToolEvent::bone_grab), 1);
  EXPECT_EQ(g.state().carried.holds, 1);
  g.tick(tick++, at({-30, 5, 9}), true, 0, s, out);
  EXPECT_LT((motion_of(g.state().carried) * Vec3(1, 2, 3) - Vec3(1, 2, 12)).norm(), 1e-12);
  g.tick(tick++, at({-30, 5, 9}), false, 1, s, out);
  EXPECT_EQ(out.count(ToolEvent::bone_drag), 1);
  EXPECT_EQ(out.count(ToolEvent::bone_release), 1);
  EXPECT_EQ(g.state().carried.holds, 0);
  CommandBuilder builder;
  std::vector<std::string> names;
  for (const ToolEvent& e : out.all)
    if (auto c = builder.feed(e)) {
      names.push_back(std::to_string(std::get<HeadCommand>(*c).index()));
      if (const auto* grab = std::get_if<GrabFragment>(&std::get<HeadCommand>(*c))) {
        EXPECT_LT((grab->fragment.at_mm - Vec3(-30, 5, 0)).norm(), 1e-6);
      }
      if (const auto* drag = std::get_if<DragFragment>(&std::get<HeadCommand>(*c))) {
        EXPECT_LT((isometry(drag->to, {7, 7, 7}) * Vec3(1, 2, 3) - Vec3(1, 2, 12)).norm(), 1e-9);
      }
    }
  EXPECT_EQ(names, (std::vector<std::string>{"2", "3", "4"}));
}

HandPose hand(const Vec3& centre, const Vec3& pointing, bool closed) {
  HandPose h;
  h.valid = true, h.centre_mm = centre, h.forefinger.tip_mm = centre, h.pointing = pointing, h.closed = closed;
  h.aperture_mm = closed ? 10 : 70;
  return h;
}

TEST(BoneHand, TheGloveGrabsBoneWhileTheOtherHandHasAToolForIt) {
  const Snapshot s = snapshot_of(half_bone());
  for (const Ground ground : {Ground::skin, Ground::bone}) {
    for (const double x : {-30.0, 30.0}) {
      VirtualHand v{GloveParameters{}};
      Events out;
      int64_t tick = 0;
      for (; tick < 100; ++tick) v.tick(tick, hand({x, 0, 50}, -Vec3::UnitZ(), false), false, s, out, ground);
      const bool bone = ground == Ground::bone && x < 0, skin = ground == Ground::skin && x > 0;
      for (; tick < 110; ++tick) v.tick(tick, hand({x, 0, 50}, -Vec3::UnitZ(), true), false, s, out, ground);
      EXPECT_EQ(out.count(ToolEvent::bone_grab), bone);
      EXPECT_EQ(out.count(ToolEvent::hook_set), skin);
      if (!bone) continue;
      EXPECT_EQ(v.state().held_hook, 0);
      v.tick(tick++, hand({x, 0, 58}, -Vec3::UnitZ(), true), false, s, out, ground);
      EXPECT_LT((motion_of(v.state().carried) * Vec3(0, 0, 0) - Vec3(0, 0, 8)).norm(), 1e-12);
      v.tick(tick++, hand({x, 0, 58}, -Vec3::UnitZ(), false), false, s, out, ground);
      EXPECT_EQ(out.count(ToolEvent::bone_release), 1);
      EXPECT_EQ(v.state().carried.holds, 0);
      EXPECT_EQ(out.all.back().hand, 1);
    }
  }
}

}  // namespace test_bone_hand
}  // namespace limberg
