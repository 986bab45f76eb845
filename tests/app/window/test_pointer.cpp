// The mouse as a device, the camera in the hand, the ruler: plain objects, no window.
#include <gtest/gtest.h>

#include <cmath>

#include "app/window/orbit.h"
#include "app/window/pointer_source.h"
#include "app/window/ray_cast.h"
#include "app/window/ruler.h"
#include "tests/render/sample_snapshot.h"

namespace limberg {
namespace test_pointer {

Camera over_the_slab() {
  Camera c;
  c.eye_mm = {10, -80, 120}, c.target_mm = {2, 3, 0};
  return c;
}

struct Heard final : SampleSink {
  std::vector<StylusSample> stylus;
  std::vector<ControlSample> control;
  void on_sample(const Sample& s) override {
    if (const auto* c = std::get_if<ControlSample>(&s))
      control.push_back(*c);
    else
      stylus.push_back(std::get<StylusSample>(s));
  }
};

TEST(RayCast, FindsTheNearestOfAllTriangles) {
  const Snapshot s = testing::sample_snapshot();
  const auto& tri = s.topology->view.tri;
  const Vec3f eye(10, -80, 120);
  for (size_t t = 0; t < tri.size(); t += 97) {
    const Tri k = tri[t];
    const Vec3f middle = (s.x_mm[size_t(k[0])] + s.x_mm[size_t(k[1])] + s.x_mm[size_t(k[2])]) / 3;
    const Vec3f d = (middle - eye).normalized();
    const RayHit hit = cast_ray(s, eye, d);
    ASSERT_GE(hit.triangle, 0);
    EXPECT_LE(hit.distance_mm, (middle - eye).norm() * 1.0001f);  // itself, or what lies before it
    EXPECT_NEAR((hit.x_mm - eye).normalized().dot(d), 1, 1e-5);
    const Tri h = tri[size_t(hit.triangle)];
    Vec3f p = Vec3f::Zero();
    for (int i = 0; i < 3; ++i) p += hit.bary[i] * s.x_mm[size_t(h[size_t(i)])];
    EXPECT_LT((p - hit.x_mm).norm(), 1e-3f);
    EXPECT_LE(hit.normal.dot(d), 0);
  }
  EXPECT_EQ(cast_ray(s, eye, -Vec3f(0, 0, -1)).triangle, -1);
  EXPECT_EQ(cast_ray(Snapshot{}, eye, Vec3f(0, 0, -1)).triangle, -1);
}

TEST(Orbit, TurnsAboutTheTargetAndStopsAtThePoles) {
  Camera c = over_the_slab();
  const float distance = (c.eye_mm - c.target_mm).norm();
  const Camera start = c;
  turn(c, 0.7f, 0.2f);
  EXPECT_NEAR((c.eye_mm - c.target_mm).norm(), distance, 1e-3f);
  EXPECT_GT((c.eye_mm - start.eye_mm).norm(), 10);
  turn(c, -0.7f, -0.2f);
  EXPECT_LT((c.eye_mm - start.eye_mm).norm(), 1e-2f);
  for (int i = 0; i < 100; ++i) turn(c, 0.1f, 0.3f);
  const Vec3f arm = (c.eye_mm - c.target_mm).normalized();
  EXPECT_LT(std::abs(arm.dot(c.up)), 1);
  EXPECT_GT(arm.cross(c.up).norm(), 0.01f);
}

TEST(Orbit, ShiftKeepsTheTargetsPlaneUnderThePointer) {
  Camera c = over_the_slab();
  const Vec3f point = c.target_mm;
  shift(c, 40, -25, 720);
  const Vec3f px = c.view(1280.0 / 720).to_pixel(point, 1280, 720);
  EXPECT_NEAR(px.x(), 640 + 40, 0.5f);
  EXPECT_NEAR(px.y(), 360 - 25, 0.5f);
}

TEST(Orbit, ApproachHasLimits) {
  Camera c = over_the_slab();
  for (int i = 0; i < 200; ++i) approach(c, 0.8f);
  EXPECT_NEAR((c.eye_mm - c.target_mm).norm(), 10, 1e-2f);
  for (int i = 0; i < 200; ++i) approach(c, 1.3f);
  EXPECT_NEAR((c.eye_mm - c.target_mm).norm(), 3000, 1);
}

TEST(View, RayThroughAPixelGoesBackToIt) {
  const View v = over_the_slab().view(1.5);
  for (const auto& [x, y] : {std::pair{10.0f, 20.0f}, {450.0f, 300.0f}, {899.0f, 1.0f}}) {
    const Vec3f at = v.eye_mm + 77 * v.ray_through(x, y, 900, 600);
    const Vec3f px = v.to_pixel(at, 900, 600);
    EXPECT_NEAR(px.x(), x, 0.05f);
    EXPECT_NEAR(px.y(), y, 0.05f);
    const View part = v.part(0.25f, 0.75f);  // a part of a view shows every point where the whole does
    const Vec3f qx = part.to_pixel(at, 900, 600);
    EXPECT_NEAR(qx.x(), x, 0.05f);
    EXPECT_NEAR(qx.y(), y, 0.05f);
  }
}

struct Mouse {
  PointerFeed feed;
  PointerReader reader{feed};
  Snapshot s = testing::sample_snapshot({.wound = false, .hooks = 0});
  View view = over_the_slab().view(16.0 / 9);
  Heard heard;
  Mouse() {
    feed.sight.writing() = {view, 1600, 900};
    feed.sight.publish();
  }
  void run(PointerSource& source, int64_t from_ms, int64_t to_ms) {
    for (int64_t t = from_ms; t < to_ms; ++t) {
      source.look(s);
      source.poll(t * 1'000'000, heard);
    }
  }
};

TEST(Pointer, TheTipIsWhatLiesUnderTheMouse) {
  Mouse m;
  PointerSource source(m.feed, {});
  ControlSample choice;
  choice.tool = Tool::scalpel;
  m.feed.choices.push(choice);
  m.reader.pointer(700, 450);
  m.run(source, 0, 40);
  m.reader.left_button(true);
  for (int i = 0; i < 20; ++i) m.reader.pointer(700.0f + 5 * float(i), 450), m.run(source, 40 + 8 * i, 48 + 8 * i);
  m.reader.left_button(false);
  m.run(source, 200, 230);
  ASSERT_EQ(m.heard.control.size(), 1u);
  EXPECT_EQ(m.heard.control[0].t_ns, 0);
  ASSERT_GT(m.heard.stylus.size(), 20u);
  int edges = 0;
  for (size_t i = 0; i < m.heard.stylus.size(); ++i) {
    const StylusSample& p = m.heard.stylus[i];
    const RayHit on = cast_ray(m.s, m.view.eye_mm, (p.tip_mm.cast<float>() - m.view.eye_mm).normalized());
    EXPECT_LT((on.x_mm - p.tip_mm.cast<float>()).norm(), 1e-2f);
    if (i == 0) continue;
    EXPECT_GT(p.t_ns, m.heard.stylus[i - 1].t_ns);
    EXPECT_EQ(p.seq, m.heard.stylus[i - 1].seq + 1);
    edges += p.buttons != m.heard.stylus[i - 1].buttons;
  }
  EXPECT_EQ(edges, 2);
  const Vec3f last = m.view.to_pixel(m.heard.stylus.back().tip_mm.cast<float>(), 1600, 900);
  EXPECT_NEAR(last.x(), 795, 0.5f);
}

TEST(Pointer, AHeldHookMovesInThePlaneOfTheScreenAndTheWheelLiftsIt) {
  Mouse m;
  PointerSource source(m.feed, {});
  ControlSample choice;
  choice.tool = Tool::hook;
  m.feed.choices.push(choice);
  m.reader.pointer(800, 450);
  m.reader.left_button(true);
  m.run(source, 0, 20);
  ASSERT_FALSE(m.heard.stylus.empty());
  const Vec3 grip = m.heard.stylus.back().tip_mm;
  m.reader.pointer(900, 380);
  m.run(source, 20, 40);
  const Vec3 moved = m.heard.stylus.back().tip_mm;
  const Vec3 toward = (m.view.eye_mm.cast<double>() - grip).normalized();
  EXPECT_GT((moved - grip).norm(), 3);
  EXPECT_NEAR((moved - grip).dot(toward), 0, 0.02);
  m.reader.wheel(4);
  m.run(source, 40, 60);
  EXPECT_NEAR((m.heard.stylus.back().tip_mm - moved).dot(toward), 6, 0.02);  // 1.5 mm a notch
  m.reader.left_button(false);
  m.run(source, 60, 80);
  EXPECT_EQ(m.heard.stylus.back().buttons, 0u);
}

TEST(Pointer, PanelsKeepThePatientFromBeingTouched) {
  Mouse m;
  PointerSource source(m.feed, {});
  m.feed.panels_have_pointer = true;
  m.reader.pointer(700, 450);
  m.reader.left_button(true);
  m.run(source, 0, 40);
  EXPECT_TRUE(m.heard.stylus.empty());
}

TEST(Pointer, NextShowsOneStepOfTheLesson) {
  Mouse m;
  const auto steps = lesson_steps({Incise{{{-10, 0}, {10, 0}}, 3, 90, false}, Wait{0.1}, Stage{"cut"}, ReleaseHook{1}});
  ASSERT_EQ(steps.size(), 2u);  // a rest and a stage belong to the act before them
  PointerSource source(m.feed, steps);
  m.run(source, 0, 50);
  EXPECT_TRUE(m.heard.stylus.empty());
  m.feed.next_wanted = 1;
  m.run(source, 50, 4000);
  EXPECT_EQ(m.feed.next_shown, 1);
  EXPECT_FALSE(m.feed.showing);
  ASSERT_GT(m.heard.stylus.size(), 50u);
  double pressed_from = 1e9, pressed_to = -1e9;
  for (size_t i = 0; i < m.heard.stylus.size(); ++i) {
    const StylusSample& p = m.heard.stylus[i];
    EXPECT_EQ(p.device_id, PointerSource::kDevice);
    if (i > 0) {
      EXPECT_GT(p.t_ns, m.heard.stylus[i - 1].t_ns);
    }
    if (p.buttons) pressed_from = std::min(pressed_from, p.tip_mm.x()), pressed_to = std::max(pressed_to, p.tip_mm.x());
  }
  EXPECT_NEAR(pressed_from, -10, 0.6);
  EXPECT_NEAR(pressed_to, 10, 0.6);
}

// Bone alone: the same button, another hand. It saws and carries
// with the stylus; a skull has no chart for the other one to aim on.
TEST(Pointer, NextShowsStepsOnBone) {
  Mouse m;
  auto bone = std::make_shared<SurfaceTopology>(*m.s.topology);
  bone->body = nullptr;
  bone->organ.assign(bone->view.tri.size(), Organ::bone);
  bone->object.assign(bone->view.tri.size(), 0);
  m.s.topology = bone;
  CutBone cut;
  cut.contour_mm = {{-8, -6, 0}, {8, -6, 0}, {0, 8, 0}};
  MoveFragment move;
  move.fragment = {-1, {2, 1, 0}}, move.by.translation_mm = {0, 0, 6}, move.by.rotation_deg = {0, 0, 30},
  move.by.about_mm = Vec3::Zero(), move.seconds = 1;
  const auto steps = lesson_steps({Stage{"before"}, HeadCommand(cut), HeadCommand(move)});
  ASSERT_EQ(steps.size(), 3u);
  PointerSource source(m.feed, steps);
  m.feed.next_wanted = 3;
  m.run(source, 0, 16000);
  EXPECT_EQ(m.feed.next_shown, 3);
  EXPECT_FALSE(m.feed.showing);
  std::vector<Tool> tools;
  for (const ControlSample& c : m.heard.control)
    if (c.kind == ControlSample::select_tool) tools.push_back(c.tool);
  EXPECT_EQ(tools, (std::vector<Tool>{Tool::saw, Tool::grab}));
  // The second press carries: from the place on the fragment to where the move takes it, the stylus turned with it.
  std::vector<size_t> down, up;
  for (size_t i = 1; i < m.heard.stylus.size(); ++i) {
    if (m.heard.stylus[i].buttons && !m.heard.stylus[i - 1].buttons) down.push_back(i);
    if (!m.heard.stylus[i].buttons && m.heard.stylus[i - 1].buttons) up.push_back(i - 1);
  }
  ASSERT_EQ(down.size(), 2u);
  ASSERT_EQ(up.size(), 2u);
  const StylusSample &a = m.heard.stylus[down[1]], &b = m.heard.stylus[up[1]];
  const Eigen::Isometry3d map = isometry(move.by, Vec3::Zero());
  EXPECT_LT((map * a.tip_mm - b.tip_mm).norm(), 1e-6);
  const Eigen::Quaterniond qa(a.quat[0], a.quat[1], a.quat[2], a.quat[3]),
      qb(b.quat[0], b.quat[1], b.quat[2], b.quat[3]);
  EXPECT_LT((qb * qa.inverse()).angularDistance(Eigen::Quaterniond(map.linear())), 1e-6);
}

TEST(Ruler, PointsStayInTheTissue) {
  Snapshot s = testing::sample_snapshot({.wound = false, .wave_mm = 0});
  Ruler ruler;
  const auto touch = [&](float x, float y) { ruler.add(s, cast_ray(s, {x, y, 50}, {0, 0, -1})); };
  touch(-10.3f, 0.2f);
  EXPECT_EQ(ruler.read(s).at_mm.size(), 1u);
  touch(9.7f, 0.2f);
  EXPECT_NEAR(ruler.read(s).length_mm, 20, 1e-3);
  for (Vec3f& x : s.x_mm) x.x() *= 1.1f;  // the skin is stretched
  EXPECT_NEAR(ruler.read(s).length_mm, 22, 1e-2);
  EXPECT_NEAR(ruler.read(s).rest_mm, 20, 1e-3);
  auto cut = std::make_shared<SurfaceTopology>(*s.topology);  // a topology made anew
  cut->version += 5;
  s.topology = cut, s.topology_version = cut->version;
  EXPECT_NEAR(ruler.read(s).length_mm, 22, 1e-2);
  touch(9.7f * 1.1f, 15.2f);
  EXPECT_NEAR(ruler.read(s).angle_deg, 90, 0.2);
  touch(0, 0);  // a fourth begins anew
  EXPECT_EQ(ruler.read(s).at_mm.size(), 1u);
}

}  // namespace test_pointer
}  // namespace limberg
