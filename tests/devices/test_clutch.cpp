// The clutch as a control sample: hands move, what they hold does not, and afterwards it follows without a jump.
#include <gtest/gtest.h>

#include "devices/fastrak/virtual_line.h"
#include "devices/front_end.h"
#include "devices/log_source.h"
#include "devices/motion.h"
#include "devices/recording.h"
#include "devices/rigid_grip.h"
#include "tests/devices/flat_patient.h"
#include "tests/devices/samples.h"
#include "tests/devices/temporary.h"

namespace limberg {
namespace test_clutch {

using namespace test;

constexpr double kDown_s = 2.4, kUp_s = 4.0;

Sample control(int32_t kind, double t_s, int64_t seq, Tool tool, double value) {
  ControlSample c;
  c.device_id = 50, c.seq = seq, c.t_ns = int64_t(t_s * 1e9), c.kind = kind, c.tool = tool;
  c.value[0] = value;
  return c;
}

void add_clutch(std::vector<Sample>& samples) {
  samples.push_back(control(ControlSample::clutch, kDown_s, 1, Tool::none, 1));
  samples.push_back(control(ControlSample::clutch, kUp_s, 2, Tool::none, 0));
}

/// 50 mm to the side while the clutch is down, 10 mm upwards after it.
Vec3 way(double t) {
  return minimum_jerk((t - 2.6) / 1.0) * Vec3(0, 50, 0) + minimum_jerk((t - 4.3) / 0.7) * Vec3(0, 0, 10);
}

std::vector<Sample> glove() {
  const fastrak::Motion motion = [](int station, double t) {
    fastrak::StationPose p;
    const double shut = minimum_jerk((t - 1.6) / 0.3), aperture = 70 - 58 * shut;
    p.orientation = Eigen::Quaterniond(Eigen::AngleAxisd(M_PI / 2, Vec3::UnitY()));  // the sensor's x points down
    const Vec3 fore = Vec3(20, -10, 40) + way(t);
    p.pos_mm = station == 1 ? fore : Vec3(fore + Vec3(0, -aperture, 0));
    return p;
  };
  fastrak::LinkSettings link;
  link.role = fastrak::parse_roles("ft");
  for (Vec3& h : link.hemisphere) h = Vec3::Zero();
  std::vector<Sample> samples = fastrak::readings_of(motion, 6, link);
  add_clutch(samples);
  return samples;
}

std::vector<Sample> stylus_with_hook() {
  std::vector<Sample> samples{control(ControlSample::select_tool, 0, 0, Tool::hook, 0)};
  for (int i = 0; i < 800; ++i) {
    const double t = double(i) * 0.008;
    samples.push_back(stylus(i, int64_t(i) * 8'000'000,
                             Vec3(5, -8, 0.1) + minimum_jerk((t - 1.5) / 0.5) * Vec3(0, 0, 6) + way(t),
                             t > 1 && t < 5.6));
  }
  add_clutch(samples);
  return samples;
}

struct Tick {
  ToolState stylus;
  SecondHand glove;
};

struct Ticked {
  std::vector<Tick> ticks;
  Events events;
  Samples recorded;
};

Ticked run(std::vector<Sample> samples, int64_t ticks) {
  Ticked r;
  Calibration c;
  c.glove.closed_mm = 12, c.glove.open_mm = 70;
  const Snapshot s = snapshot_of(flat_topology(60, 1));
  DeviceFrontEnd front(c);
  front.add(std::make_unique<LogSource>(std::move(samples)));
  ToolState stylus;
  for (int64_t tick = 0; tick < ticks; ++tick) {
    front.tick(tick, s, r.events, r.recorded, stylus);
    r.ticks.push_back({stylus, front.second_hand()});
  }
  return r;
}

Vec3 at(const double (&p)[3]) { return {p[0], p[1], p[2]}; }

/// Held places by tick: still while the clutch is down, 10 mm upwards afterwards, never a jump.
template <class Where>
void expect_clutched(const Ticked& r, int64_t until, Where where) {
  const Vec3 before = where(r.ticks[size_t(kDown_s * 1000) - 1]), still = where(r.ticks[size_t(kDown_s * 1000)]);
  EXPECT_LT((still - before).norm(), 0.02);
  for (size_t t = size_t(kDown_s * 1000); t <= size_t(kUp_s * 1000); ++t) ASSERT_EQ(where(r.ticks[t]), still) << t;
  // A minimum-jerk way of 10 mm in 0.7 s is at most 10 / 0.7 *
  // 15 / 8 = 27 mm/s, 0.027 mm a tick; the filter may overshoot.
  for (size_t t = size_t(kUp_s * 1000); t < size_t(until); ++t)
    ASSERT_LT((where(r.ticks[t]) - where(r.ticks[t - 1])).norm(), 0.06) << t;
  EXPECT_LT((where(r.ticks[size_t(until) - 1]) - still - Vec3(0, 0, 10)).norm(), 0.3);
}

TEST(Clutch, TheGloveMovesAndWhatItHoldsDoesNot) {
  const Ticked r = run(glove(), 5900);
  ASSERT_EQ(r.events.count(ToolEvent::hook_set), 1);
  const SecondHand &down = r.ticks[2400].glove, &up = r.ticks[4000].glove;
  EXPECT_NEAR((at(up.forefinger_mm) - at(down.forefinger_mm)).norm(), 50, 0.5) << "the hand itself moves";
  EXPECT_EQ(up.points, 1);
  EXPECT_EQ(at(up.pointed_mm), at(up.hook_mm));
  expect_clutched(r, 5900, [](const Tick& t) { return at(t.glove.hook_mm); });
}

TEST(Clutch, TheStylusMovesAndItsHookDoesNot) {
  const Ticked r = run(stylus_with_hook(), 6300);
  ASSERT_EQ(r.events.count(ToolEvent::hook_set), 1);
  for (size_t t = 2400; t < 5500; ++t) ASSERT_NE(r.ticks[t].stylus.held_hook, 0);
  expect_clutched(r, 5590, [](const Tick& t) { return at(t.stylus.tip_mm); });
  EXPECT_NEAR((at(r.ticks[5500].stylus.shift_mm) - Vec3(0, -50, 0)).norm(), 0, 0.5);
  // It is let go where it is held; then the tool is in the hand again.
  ASSERT_EQ(r.events.count(ToolEvent::hook_leave), 1);
  EXPECT_LT((at(r.events.all.back().world_mm) - Vec3(5, -8, 16.1)).norm(), 0.5);
  EXPECT_LT((at(r.ticks[6299].stylus.tip_mm) - Vec3(5, 42, 16.1)).norm(), 0.5);
  EXPECT_EQ(at(r.ticks[6299].stylus.shift_mm), Vec3::Zero());
}

TEST(Clutch, AFragmentInTheStylusNeitherMovesNorTurns) {
  auto t = flat_topology(30, 1);
  t->organ.assign(t->view.tri.size(), Organ::bone);
  t->object.assign(t->view.tri.size(), 3);
  for (FaceKind& k : t->view.kind) k = FaceKind::free;
  const Snapshot s = snapshot_of(t);
  Gestures g;
  Events out;
  g.control(std::get<ControlSample>(control(ControlSample::select_tool, 0, 0, Tool::grab, 0)), 0, s, out);
  int64_t tick = 1;
  Pose hand;
  hand.valid = true, hand.tip_mm = Vec3(-30, 5, 0);
  for (int i = 0; i < 20; ++i) g.tick(tick++, hand, false, 0, s, out);
  g.tick(tick++, hand, true, 1, s, out);
  hand.tip_mm.z() = 4;
  g.tick(tick++, hand, true, 0, s, out);
  ASSERT_EQ(g.state().carried.holds, 1);
  const Eigen::Isometry3d held = motion_of(g.state().carried);
  for (int i = 1; i <= 50; ++i) {
    hand.tip_mm = Vec3(-30, 5 + i, 4), hand.orientation = Eigen::AngleAxisd(0.02 * i, Vec3::UnitX());
    g.tick(tick++, hand, true, 0, s, out, true);
    ASSERT_TRUE(motion_of(g.state().carried).isApprox(held, 1e-12)) << i;
  }
  g.tick(tick++, hand, true, 0, s, out);
  EXPECT_TRUE(motion_of(g.state().carried).isApprox(held, 1e-12)) << "let go of, the clutch moves nothing";
  hand.tip_mm.x() += 3;
  g.tick(tick++, hand, true, 0, s, out);
  EXPECT_TRUE(motion_of(g.state().carried).isApprox(Eigen::Translation3d(3, 0, 0) * held, 1e-12));
}

TEST(Clutch, ARecordingOfItReplaysToTheSameBits) {
  TemporaryFolder dir;
  for (const std::vector<Sample>& samples : {glove(), stylus_with_hook()}) {
    const Ticked live = run(samples, 6000);
    RecordingWriter w;
    w.open(dir / "clutch.lcm", {}, {}, true);
    for (const Sample& s : live.recorded.all) w.on_sample(s);
    ASSERT_TRUE(w.finish(6000, 0));
    const Recording file = read_recording(dir / "clutch.lcm");
    EXPECT_EQ(file.damage.total(), 0) << file.damage.first_message;
    ASSERT_EQ(file.samples.size(), live.recorded.all.size());
    const Ticked again = run(file.samples, 6000);
    ASSERT_EQ(again.events.all.size(), live.events.all.size());
    for (size_t t = 0; t < live.ticks.size(); ++t) {
      ASSERT_EQ(at(again.ticks[t].glove.hook_mm), at(live.ticks[t].glove.hook_mm)) << t;
      ASSERT_EQ(at(again.ticks[t].stylus.tip_mm), at(live.ticks[t].stylus.tip_mm)) << t;
    }
  }
}

}  // namespace test_clutch
}  // namespace limberg
