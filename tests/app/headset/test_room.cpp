// The patient's place in a headset's room, and hands as stations of a tracker.
#include <gtest/gtest.h>

#include <cmath>

#include "app/headset/headset_source.h"
#include "app/headset/room.h"
#include "devices/glove.h"
#include "sim/base/error.h"

namespace limberg {
namespace test_room {

Camera scene_view() {
  Camera c;
  c.eye_mm = {10, -200, 180}, c.target_mm = {10, 5, 2}, c.up = Vec3f::UnitZ();
  return c;
}

RoomPose head_at(double yaw, double pitch) {
  RoomPose h;
  h.at_m = {0.3, 1.65, -0.2};
  h.turned = Eigen::AngleAxisd(yaw, Vec3::UnitY()) * Eigen::AngleAxisd(pitch, Vec3::UnitX());
  return h;
}

TEST(Room, ThePatientLiesBeforeThePersonAtTheHeightOfATable) {
  for (const double yaw : {0.0, 0.7, 2.9, -1.8})
    for (const double pitch : {0.0, -0.6, -1.5}) {
      const RoomPose head = head_at(yaw, pitch);
      const RoomSettings set;
      const PatientPlace p = PatientPlace::before(head, true, scene_view(), set);
      const Vec3 at = p.to_room({10, 5, 2});
      EXPECT_NEAR(at.y(), set.table_m, 1e-9);
      const Vec3 ahead(-std::sin(yaw), 0, -std::cos(yaw));
      EXPECT_LT((Vec3(at.x(), 0, at.z()) - Vec3(head.at_m.x(), 0, head.at_m.z()) - set.reach_m * ahead).norm(), 1e-6)
          << yaw << " " << pitch;
      // Up stays up; the camera's right is the person's.
      EXPECT_LT((p.direction(Vec3::UnitY()) - Vec3::UnitZ()).norm(), 1e-9);
      EXPECT_LT((p.direction(ahead.cross(Vec3::UnitY())) - Vec3::UnitX()).norm(), 1e-6);
      EXPECT_LT((p.to_patient(p.to_room({3, -4, 8})) - Vec3(3, -4, 8)).norm(), 1e-9);
    }
}

TEST(Room, LargerThanLifeTheHandGoesLessFar) {
  RoomSettings set;
  set.scale = 4;
  const PatientPlace p = PatientPlace::before(head_at(0.4, 0), true, scene_view(), set);
  const Vec3 a(0.1, 1, -0.5), b(0.13, 1.04, -0.5);  // 50 mm apart
  EXPECT_NEAR((p.to_patient(a) - p.to_patient(b)).norm(), 50.0 / 4, 1e-9);
}

TEST(Room, OneWhoSitsHasItBelowTheEyes) {
  RoomPose head = head_at(0, 0);
  head.at_m.y() = 1.1;
  const RoomSettings set;
  EXPECT_NEAR(PatientPlace::before(head, true, scene_view(), set).at_m().y(), 1.1 - set.below_m, 1e-9);
  head.at_m.y() = 0;  // no floor is known: the eyes are the origin
  EXPECT_NEAR(PatientPlace::before(head, false, scene_view(), set).at_m().y(), -set.below_m, 1e-9);
}

TEST(Room, ACameraStraightFromAboveHasASideToo) {
  Camera c = scene_view();
  c.eye_mm = {10, 5, 300};
  const PatientPlace p = PatientPlace::before(head_at(0, 0), true, c, {});
  EXPECT_TRUE(p.to_patient(Vec3(1, 2, 3)).allFinite());
  EXPECT_LT((p.direction(Vec3::UnitY()) - Vec3::UnitZ()).norm(), 1e-9);
}

TEST(Room, TheTableIsBelowThePatient) {
  const PatientPlace p = PatientPlace::before(head_at(0.4, 0), true, scene_view(), {});
  const PropMesh room = room_props(p, {-60, -60, -10}, {60, 60, 0}, 0.95);
  ASSERT_FALSE(room.tri.empty());
  float highest = -1e9f;
  for (const PropVertex& v : room.vertex) highest = std::max(highest, v.x_mm.z());
  EXPECT_LT(highest, -10);
  EXPECT_GT(highest, -20);
  // Each triangle looks the way of its normal: else it would be lit from below.
  for (const auto& t : room.tri) {
    const Vec3f a = room.vertex[t[0]].x_mm, b = room.vertex[t[1]].x_mm, c = room.vertex[t[2]].x_mm;
    EXPECT_GT((b - a).cross(c - a).dot(room.vertex[t[0]].normal), 0);
  }
}

TEST(Room, TheTabletLooksAtThePersonAndIsPointedAt) {
  const RoomPose head = head_at(-0.9, -0.3);
  const PatientPlace p = PatientPlace::before(head, true, scene_view(), {});
  const BoardPlace b = tablet_place(p, head, 16. / 9);
  const Vec3f eyes = p.to_patient(head.at_m).cast<float>();
  EXPECT_GT(b.normal().dot((eyes - b.centre_mm).normalized()), 0.99f);
  EXPECT_NEAR(b.right_mm.norm() / b.up_mm.norm(), 16. / 9, 1e-4);
  const auto meets = [&](float right, float up, float& u, float& v) {
    float way = 0;
    const Vec3f to = b.centre_mm + right * b.right_mm + up * b.up_mm - eyes;
    const bool on = b.meets(eyes, to.normalized(), u, v, way);
    EXPECT_TRUE(!on || std::abs(way - to.norm()) < 0.01f);
    return on;
  };
  float u = 0, v = 0;
  ASSERT_TRUE(meets(-0.5f, 0.8f, u, v));
  EXPECT_NEAR(u, 0.25f, 1e-4f);
  EXPECT_NEAR(v, 0.1f, 1e-4f);
  EXPECT_FALSE(meets(1.1f, 0, u, v));
  EXPECT_FALSE(meets(0, -1.2f, u, v));
  float way = 0;  // from behind
  EXPECT_FALSE(b.meets(b.centre_mm - 100 * b.normal(), b.normal(), u, v, way));
}

// ---- Hands

PatientPlace place() { return PatientPlace::before(head_at(0.4, 0), true, scene_view(), {}); }

TEST(HeadsetHands, AControllerIsAStylusWhoseTipIsBeforeIt) {
  HandStations hand(true);
  HandReading r;
  r.controller = true, r.press = true, r.clutch = true;
  r.aim.at_m = {0.2, 1.1, -0.5};
  r.aim.turned = Eigen::AngleAxisd(0.8, Vec3(1, 2, 0.3).normalized());
  TrackerSample out[3];
  ASSERT_EQ(hand.samples(r, place(), false, out), 1);
  EXPECT_EQ(out[0].role, StationRole::stylus);
  EXPECT_EQ(out[0].buttons, 3u);
  const Vec3 controller = place().to_patient(r.aim.at_m), tip = out[0].pos_mm;
  EXPECT_NEAR((controller - tip).norm(), 50 / RoomSettings{}.scale, 1e-6);
  const Eigen::Quaterniond q(out[0].quat[0], out[0].quat[1], out[0].quat[2], out[0].quat[3]);
  EXPECT_LT((q * Vec3::UnitZ() - (controller - tip).normalized()).norm(), 1e-9);  // from the tip to the hand
  ASSERT_EQ(hand.samples(r, place(), true, out), 1);
  EXPECT_EQ(out[0].buttons, 2u);  // the trigger meant the tablet
  EXPECT_EQ(out[0].seq, 1);
}

TEST(HeadsetHands, ATrackedHandIsTheGlove) {
  HandStations hand(false);
  HandReading r;
  r.fingers = true;
  r.forefinger.at_m = {0, 1, -0.5}, r.thumb.at_m = {-0.03, 1, -0.5};
  r.forefinger.turned = r.thumb.turned = Eigen::AngleAxisd(-0.7, Vec3(0.2, 1, 0.5).normalized());
  TrackerSample out[3];
  ASSERT_EQ(hand.samples(r, place(), false, out), 2);
  EXPECT_EQ(out[0].role, StationRole::forefinger);
  EXPECT_EQ(out[1].role, StationRole::thumb);
  // By the glove's own tracking: it points where the finger does, and is as open as it is.
  GloveTracker glove{Calibration{}};
  for (int64_t t = 0; t < 60; ++t) {
    ASSERT_EQ(hand.samples(r, place(), false, out), 2);
    for (int k = 0; k < 2; ++k) out[k].t_ns = out[k].true_ns = (t + 1) * 4'000'000 + k, glove.add(out[k]);
    glove.at((t + 1) * 4'000'000 + 2);
  }
  const HandPose pose = glove.at(61 * 4'000'000);
  ASSERT_TRUE(pose.valid);
  EXPECT_NEAR(pose.aperture_mm, 30, 0.1);
  EXPECT_LT((pose.pointing - place().direction(-(r.forefinger.turned * Vec3::UnitZ()))).norm(), 0.01);
}

TEST(HeadsetHands, ATriggerClosesTheHandAsFastAsAHandCloses) {
  HandStations hand(false);
  HandReading r;
  r.controller = true;
  r.aim.at_m = {0, 1, -0.5};
  GloveTracker glove{Calibration{}};
  TrackerSample out[3];
  int closed_after = -1;
  for (int t = 0; t < 250; ++t) {
    r.press = t >= 100;
    ASSERT_EQ(hand.samples(r, place(), false, out), 2);
    for (int k = 0; k < 2; ++k) out[k].t_ns = out[k].true_ns = (t + 1) * 4'000'000 + k, glove.add(out[k]);
    if (glove.at((t + 1) * 4'000'000 + 2).closed && closed_after < 0) closed_after = t;
  }
  EXPECT_GT(closed_after, 100);
  EXPECT_LT(closed_after, 100 + 60);  // a quarter of a second
  EXPECT_EQ(glove.counts().thumb.jumps, 0);
}

TEST(HeadsetHands, TheHandOfTheStylusIsTheOtherGloveWithoutItsController) {
  HandStations hand(true);
  HandReading r;
  r.fingers = true;
  TrackerSample out[3];
  ASSERT_EQ(hand.samples(r, place(), false, out), 2);
  EXPECT_EQ(out[0].role, StationRole::other_forefinger);
  EXPECT_EQ(out[1].role, StationRole::other_thumb);
  EXPECT_NE(out[0].device_id, HeadsetSettings::kDevice);
  EXPECT_EQ(HandStations(true).samples({}, place(), false, out), 0);
}

TEST(HeadsetOptions, ACalibrationOfAnotherTrackerIsRefused) {
  Calibration c;
  c.glove.open_mm = 60;
  EXPECT_NO_THROW(check_calibration(c));
  c.tip_offset_mm = {0, 0, 80};
  EXPECT_THROW(check_calibration(c), InputError);
  c.tip_offset_mm.setZero(), c.world_from_tracker_mm = {100, 0, 0};
  EXPECT_THROW(check_calibration(c), InputError);
}

TEST(HeadsetOptions, AreReadOrRefused) {
  EXPECT_TRUE(parse_headset("left").left_handed);
  EXPECT_EQ(parse_headset("scale=3,table=0.8").eyes.room.scale, 3);
  EXPECT_EQ(parse_headset("scale=3,table=0.8").eyes.room.table_m, 0.8);
  EXPECT_FALSE(parse_headset("").left_handed);
  for (const char* bad : {"up", "scale=", "scale=0", "scale=nan", "table=9", "scale", "left;right", "scale=3x"})
    EXPECT_THROW(parse_headset(bad), InputError) << bad;
}

}  // namespace test_room
}  // namespace limberg
