// Pointing, grabbing, carrying, two hands at once.
#include <gtest/gtest.h>

#include "devices/fastrak/virtual_line.h"
#include "devices/front_end.h"
#include "devices/log_source.h"
#include "devices/motion.h"
#include "devices/virtual_hand.h"
#include "tests/devices/flat_patient.h"
#include "tests/devices/samples.h"

namespace limberg {
namespace test_virtual_hand {

using namespace test;

TEST(RigidGrip, TurnsAboutTheHandsCentreAndScalesTheWay) {
  RigidGrip g;
  const Eigen::Quaterniond q0(Eigen::AngleAxisd(0.3, Vec3(1, 2, 3).normalized())),
      turn(Eigen::AngleAxisd(0.7, Vec3::UnitZ()));
  const Vec3 c0(10, 20, 30);
  g.begin(c0, q0, 0.5);
  EXPECT_LT((g.follow(c0, q0, false) * Vec3(1, 2, 3) - Vec3(1, 2, 3)).norm(), 1e-12);  // nothing jumps
  const Vec3 x(15, 20, 30);
  // Turned in place: about the centre.
  EXPECT_LT((g.follow(c0, turn * q0, false) * x - (c0 + turn * (x - c0))).norm(), 1e-12);
  // Moved by 8: by 4.
  EXPECT_LT((g.follow(c0 + Vec3(8, 0, 0), q0, false) * x - (x + Vec3(4, 0, 0))).norm(), 1e-12);
  // Clutch: the hand goes back, the object stays; afterwards it goes on from there.
  const Eigen::Isometry3d before = g.motion();
  g.follow(c0 + Vec3(8, 0, 0), q0, true);
  g.follow(c0 - Vec3(20, 5, 0), turn * q0, true);
  EXPECT_TRUE(g.motion().matrix() == before.matrix());
  g.follow(c0 - Vec3(20, 5, 0), turn * q0, false);
  EXPECT_LT((g.follow(c0 - Vec3(20, 5, 0) + Vec3(0, 6, 0), turn * q0, false) * x - (x + Vec3(4, 3, 0))).norm(), 1e-12);
  // Many small motions lead to where one does.
  g.begin(c0, q0, 1);
  for (int i = 1; i <= 1000; ++i)
    g.follow(c0 + Vec3(0.01 * i, 0, 0), Eigen::Quaterniond(Eigen::AngleAxisd(0.001 * i, Vec3::UnitY())) * q0, false);
  const Eigen::Isometry3d one =
      Eigen::Translation3d(c0 + Vec3(10, 0, 0)) * Eigen::AngleAxisd(1.0, Vec3::UnitY()) * Eigen::Translation3d(-c0);
  EXPECT_LT((g.motion().matrix() - one.matrix()).norm(), 1e-9);
}

TEST(Pointing, TheClosestPlaceInTheForefingersDirection) {
  const Snapshot s = snapshot_of(flat_topology(60, 1),
                                 [](const Vec3& X) { return Vec3(X.x(), X.y(), std::abs(X.x()) < 10 ? 15.0 : 0.0); });
  PointingSearch search;
  const Vec3 tip(3, 4, 100), down(0, 0, -1);
  const PointedPlace p = search.find(s, tip, down);
  ASSERT_GE(p.triangle, 0);
  EXPECT_LT((p.x_mm - Vec3(3, 4, 15)).norm(), 1e-4);  // the plateau, not what lies under it
  EXPECT_EQ(p.beside_rad, 0);
  // Spread over ticks: the same.
  for (int i = 0; i <= PointingSearch::kSlices; ++i) search.step(s, tip, down);
  EXPECT_EQ(search.place().triangle, p.triangle);
  // Beside everything: the place least beside, within the cone; away from it: none.
  const PointedPlace beside = search.find(s, Vec3(0, 68, 100), down);
  ASSERT_GE(beside.triangle, 0);
  EXPECT_NEAR(beside.x_mm.y(), 60, 2.1);
  EXPECT_LT(search.find(s, tip, -down).triangle, 0);
}

/// A glove that comes down over (20, -10), closes, moves by (0,
/// 30, 10), opens; and a stylus in the other hand that draws.
std::vector<Sample> both_hands() {
  const auto way = [](double t) { return minimum_jerk((t - 2.5) / 1.0); };
  const fastrak::Motion motion = [=](int station, double t) {
    fastrak::StationPose p;
    if (station == 3) {
      p.pos_mm = Vec3(-40 + 50 * minimum_jerk((t - 1.5) / 2.0), 30, t > 1.4 && t < 3.6 ? 0.1 : 8.0);
      p.pressed = t > 1.45 && t < 3.55;
      return p;
    }
    const double shut = minimum_jerk((t - 1.6) / 0.3) - minimum_jerk((t - 4.0) / 0.3);
    const double aperture = 70 - 58 * shut;
    // The sensor's x points down; a finger that closes bends by 30 degrees, and would point 23 mm beside.
    p.orientation = Eigen::Quaterniond(Eigen::AngleAxisd(M_PI / 2 + 0.52 * shut, Vec3::UnitY()));
    const Vec3 fore = Vec3(20, -10, 40) + way(t) * Vec3(0, 30, 10);
    p.pos_mm = station == 1 ? fore : Vec3(fore + Vec3(0, -aperture, 0));
    return p;
  };
  fastrak::LinkSettings link;
  link.role = fastrak::parse_roles("fts");
  // All of it in front of the transmitter, or the device would answer with the mirror image.
  for (Vec3& h : link.hemisphere) h = Vec3::Zero();
  std::vector<Sample> samples = fastrak::readings_of(motion, 6, link);
  ControlSample scalpel;
  scalpel.device_id = 1;
  scalpel.kind = ControlSample::select_tool;
  scalpel.tool = Tool::scalpel;
  samples.insert(samples.begin(), scalpel);
  return samples;
}

TEST(TwoHands, TheGloveHoldsSkinWhileTheStylusDraws) {
  Snapshot s = snapshot_of(flat_topology(60, 1));
  Calibration c;
  c.glove.closed_mm = 12, c.glove.open_mm = 70;
  DeviceFrontEnd front(c);
  front.add(std::make_unique<LogSource>(both_hands()));
  Events events;
  Samples recorded;
  ToolState stylus;
  Vec3 furthest = Vec3::Zero();
  int held_ticks = 0;
  for (int64_t tick = 0; tick < 6000; ++tick) {
    front.tick(tick, s, events, recorded, stylus);
    const SecondHand& g = front.second_hand();
    if (g.held_hook != 0) {
      ++held_ticks;
      const Vec3 at(g.hook_mm[0], g.hook_mm[1], g.hook_mm[2]);
      if (at.norm() > furthest.norm()) furthest = at;
    }
  }
  EXPECT_EQ(events.count(ToolEvent::hook_set), 1);
  EXPECT_EQ(events.count(ToolEvent::hook_release), 1);
  EXPECT_EQ(events.count(ToolEvent::stroke_begin), 1);
  EXPECT_EQ(events.count(ToolEvent::stroke_end), 1);
  EXPECT_GT(events.count(ToolEvent::stroke_point), 50);
  EXPECT_NEAR(held_ticks, 2400, 250);
  for (size_t i = 0; i < events.all.size(); ++i) EXPECT_EQ(events.all[i].seq, int64_t(i));  // one count for both hands
  for (const ToolEvent& e : events.all)
    if (e.kind == ToolEvent::hook_set) {
      EXPECT_EQ(e.hand, 1);
      EXPECT_GE(e.id, VirtualHand::kFirstHook);
      EXPECT_NEAR(e.chart_x, 20, 1.5);  // what was pointed at before the hand closed
      EXPECT_NEAR(e.chart_y, -10, 1);
    }
  // While the hand opens again its centre goes with the thumb, and its bending fingers turn what lies 40 mm below them,
  // until the release is seen: at most 35 % of the way.
  EXPECT_LT((furthest - Vec3(20, 20, 10)).norm(), 0.5 * 58 * 0.35 + 45 * 0.52 * 0.35 + 4);
  EXPECT_EQ(front.counts().grabs, 1);
}

TEST(TwoHands, WithoutAGloveThereIsNoSecondHand) {
  Snapshot s = snapshot_of(flat_topology(20, 1));
  DeviceFrontEnd front{Calibration{}};
  front.add(std::make_unique<LogSource>(stream(200)));
  Events events;
  Samples recorded;
  ToolState stylus;
  for (int64_t tick = 0; tick < 2000; ++tick) front.tick(tick, s, events, recorded, stylus);
  EXPECT_EQ(front.second_hand().valid, 0);
  EXPECT_EQ(front.counts().glove.forefinger.used, 0);
}

}  // namespace test_virtual_hand
}  // namespace limberg
