// The mouse as a device, the camera in the hand, the ruler: plain objects, no window.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <thread>

#include "app/window/input_router.h"
#include "app/window/orbit.h"
#include "app/window/pointer_source.h"
#include "app/window/ray_cast.h"
#include "app/window/ruler.h"
#include "devices/command_builder.h"
#include "devices/front_end.h"
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
  std::vector<CommandSample> commands;
  void on_sample(const Sample& s) override {
    if (const auto* c = std::get_if<ControlSample>(&s))
      control.push_back(*c);
    else if (const auto* k = std::get_if<CommandSample>(&s))
      commands.push_back(*k);
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

// Straight down on edges and corners of the mesh: in single precision some rays fell between two triangles.
TEST(RayCast, FallsThroughNoEdge) {
  const Snapshot s = testing::sample_snapshot({.wound = false, .wave_mm = 0, .hooks = 0});
  const auto& tri = s.topology->view.tri;
  const Vec3f eye(3.1f, -20.3f, 207);
  int rays = 0;
  for (size_t t = 0; t < tri.size(); t += 5) {
    if (!s.topology->is_ground(t, Ground::skin)) continue;
    for (size_t k = 0; k < 3; ++k) {
      const Vec3f &a = s.x_mm[size_t(tri[t][k])], &b = s.x_mm[size_t(tri[t][(k + 1) % 3])];
      if (std::max(a.head<2>().cwiseAbs().maxCoeff(), b.head<2>().cwiseAbs().maxCoeff()) > 20)
        continue;  // the slab's rim
      for (const float w : {0.0f, 0.25f, 0.37f}) {
        const Vec3f at = a + w * (b - a);
        const RayHit hit = cast_ray(s, eye, (at - eye).normalized());
        ASSERT_GE(hit.triangle, 0);
        ASSERT_LT((hit.x_mm - at).norm(), 0.01f) << at.transpose();
        ++rays;
      }
    }
  }
  EXPECT_GT(rays, 500);
  std::printf("  %d rays on %zu triangles\n", rays, tri.size());
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

struct NoScreen final : Screen {
  std::unique_ptr<GlContext> context() override { return nullptr; }
};

/// Main and device thread of a window, by hand; the render thread is a frame that was drawn once.
struct Mouse {
  NoScreen screen;
  HandFeed feed;
  InputRouter router;
  Snapshot s = testing::sample_snapshot({.wound = false, .hooks = 0});
  View view = over_the_slab().view(16.0 / 9);
  Heard heard;
  Mouse() : router(screen, feed) {
    router.look_with([this](bool) { return &s; });
    show();
  }
  /// A frame is drawn: what the person sees from now on.
  void show(std::vector<FrameRect> panels = {}, bool typing = false) {
    FrameSeen& f = feed.seen.writing();
    f = {};
    f.view = view, f.width = 1600, f.height = 900, f.typing = typing;
    for (const FrameRect& r : panels) f.panel[f.panels++] = r;
    feed.seen.publish();
  }
  /// ... by the render thread, which has taken all events until now. They are returned.
  std::vector<WindowEvent> draw() {
    std::vector<WindowEvent> all;
    for (WindowEvent e; screen.events.pop(e);) all.push_back(e);
    if (!all.empty()) feed.answered.store(all.back().number);
    return all;
  }
  void move(float x, float y) {
    WindowEvent e;
    e.x = x, e.y = y;
    router.take(e);
  }
  void button(bool down, int32_t which = 0) {
    WindowEvent e;
    e.kind = WindowEvent::button, e.code = which, e.down = down;
    router.take(e);
  }
  void wheel(float notches) {
    WindowEvent e;
    e.kind = WindowEvent::wheel, e.y = notches;
    router.take(e);
  }
  void key(int32_t code, bool down = true, uint32_t mods = 0) {
    WindowEvent e;
    e.kind = WindowEvent::key, e.code = code, e.down = down, e.mods = mods;
    router.take(e);
    e.kind = WindowEvent::text, e.code = code < 128 ? code : 0;
    if (down && e.code && !mods) router.take(e);  // as a desktop does
  }
  void run(Source& source, int64_t from_ms, int64_t to_ms) {
    for (int64_t t = from_ms; t < to_ms; ++t) {
      router.pump(t * 1'000'000);
      source.look(s);
      source.poll(t * 1'000'000, heard);
    }
  }
};

TEST(Pointer, TheTipIsWhatLiesUnderTheMouse) {
  Mouse m;
  PointerSource source(m.feed);
  m.key('2');
  m.move(700, 450);
  m.run(source, 0, 40);
  m.button(true);
  for (int i = 0; i < 20; ++i) m.move(700.0f + 5 * float(i), 450), m.run(source, 40 + 8 * i, 48 + 8 * i);
  m.button(false);
  m.run(source, 200, 230);
  ASSERT_EQ(m.heard.control.size(), 1u);
  EXPECT_EQ(m.heard.control[0].t_ns, 0);
  EXPECT_EQ(m.heard.control[0].tool, Tool::scalpel);
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
  PointerSource source(m.feed);
  m.key('5');
  m.move(800, 450);
  m.button(true);
  m.run(source, 0, 20);
  ASSERT_FALSE(m.heard.stylus.empty());
  const Vec3 grip = m.heard.stylus.back().tip_mm;
  m.move(900, 380);
  m.run(source, 20, 40);
  const Vec3 moved = m.heard.stylus.back().tip_mm;
  const Vec3 toward = (m.view.eye_mm.cast<double>() - grip).normalized();
  EXPECT_GT((moved - grip).norm(), 3);
  EXPECT_NEAR((moved - grip).dot(toward), 0, 0.02);
  m.wheel(4);
  m.run(source, 40, 60);
  EXPECT_NEAR((m.heard.stylus.back().tip_mm - moved).dot(toward), 6, 0.02);  // 1.5 mm a notch
  m.button(false);
  m.run(source, 60, 80);
  EXPECT_EQ(m.heard.stylus.back().buttons, 0u);
}

/// What comes of it on the device side.
std::vector<int32_t> gestures_of(Mouse& m, int64_t from_ms, int64_t to_ms, DeviceFrontEnd& front) {
  struct Events final : EventSink {
    std::vector<int32_t> kinds;
    bool push(const ToolEvent& e) override { return kinds.push_back(e.kind), true; }
  } events;
  ToolState tool;
  for (int64_t t = from_ms; t < to_ms; ++t) {
    m.router.pump(t * 1'000'000);
    front.tick(t, m.s, events, m.heard, tool);
  }
  return events.kinds;
}

TEST(InputOrder, AToolChosenByAKeyIsTheToolOfTheClickThatFollows) {
  Mouse m;
  DeviceFrontEnd front{Calibration{}};
  front.add(std::make_unique<PointerSource>(m.feed));
  m.key('2');
  m.move(800, 450);
  EXPECT_TRUE(gestures_of(m, 0, 50, front).empty());
  // No frame is drawn meanwhile, and all of it happens within one millisecond.
  m.key('5'), m.button(true), m.button(false), m.key('2'), m.button(true), m.button(false);
  m.key('Z', true, WindowEvent::control);
  const std::vector<int32_t> got = gestures_of(m, 50, 200, front);
  EXPECT_EQ(got, (std::vector<int32_t>{ToolEvent::hook_set, ToolEvent::hook_leave, ToolEvent::stroke_begin,
                                       ToolEvent::stroke_end, ToolEvent::undo}));
}

TEST(InputOrder, TheClutchComesBetweenTheMovesThatItParts) {
  Mouse m;
  PointerSource source(m.feed);
  m.key('5');
  m.move(800, 450), m.button(true), m.move(820, 450);
  m.key(WindowEvent::space), m.key(WindowEvent::space);  // it repeats
  m.move(900, 450);
  m.key(WindowEvent::space, false);
  std::vector<std::string> order;
  struct Order final : SampleSink {
    std::vector<std::string>& all;
    explicit Order(std::vector<std::string>& a) : all(a) {}
    void on_sample(const Sample& x) override {
      const auto* c = std::get_if<ControlSample>(&x);
      all.push_back(!c                                 ? std::get<StylusSample>(x).buttons ? "down" : "up"
                    : c->kind == ControlSample::clutch ? c->value[0] != 0 ? "clutch" : "follow"
                                                       : "tool");
    }
  } sink(order);
  for (int64_t t = 0; t < 8; ++t) source.look(m.s), source.poll(t * 1'000'000, sink);
  // The hook is pressed and drawn, and only then does the clutch hold it.
  EXPECT_EQ(order, (std::vector<std::string>{"tool", "up", "down", "down", "clutch", "down", "follow"}));
}

TEST(InputOrder, AClickOnAPanelNeverReachesThePatient) {
  Mouse m;
  PointerSource source(m.feed);
  m.key('2');
  m.show({{0, 0, 300, 900}});
  m.move(200, 450), m.button(true), m.button(false);
  m.run(source, 0, 40);
  EXPECT_TRUE(m.heard.stylus.empty());
  std::vector<WindowEvent> seen = m.draw();
  ASSERT_FALSE(seen.empty());
  EXPECT_EQ(seen.back().kind, WindowEvent::button);
  EXPECT_TRUE(seen.back().for_panels);
  m.run(source, 40, 80);
  seen = m.draw();  // the release, which waited for the answer to the press
  ASSERT_EQ(seen.size(), 1u);
  EXPECT_TRUE(seen[0].for_panels && !seen[0].down);
  // A button that went down on a panel belongs to it until it is let go, wherever the mouse goes.
  m.button(true), m.draw(), m.move(800, 450), m.run(source, 80, 90), m.draw(), m.button(false);
  m.run(source, 90, 120);
  EXPECT_TRUE(m.draw().back().for_panels);
  EXPECT_TRUE(m.heard.stylus.empty());
}

// What counts is the frame that the person saw: a panel that is about to open does not take the click, on either
// thread.
TEST(InputOrder, APanelThatNobodyHasSeenYetTakesNoClick) {
  Mouse m;
  PointerSource source(m.feed);
  m.key('2');
  m.move(800, 450), m.button(true);
  m.run(source, 0, 10);
  ASSERT_FALSE(m.heard.stylus.empty());
  EXPECT_EQ(m.heard.stylus.back().buttons, 1u);
  m.show({{0, 0, 1600, 900}});
  EXPECT_FALSE(m.draw().back().for_panels);
  m.button(false);
  m.run(source, 10, 20);
  EXPECT_EQ(m.heard.stylus.back().buttons, 0u) << "a press that was the patient's is let go there";
  EXPECT_FALSE(m.draw().back().for_panels);
}

TEST(InputOrder, AClickAfterOneOnThePaletteActsWithTheToolThatWasChosenThere) {
  Mouse m;
  DeviceFrontEnd front{Calibration{}};
  front.add(std::make_unique<PointerSource>(m.feed));
  m.show({{0, 0, 300, 900}});
  m.key('2');
  gestures_of(m, 0, 30, front);
  m.move(200, 100), m.button(true), m.button(false);  // on the palette
  m.move(800, 450), m.button(true);                   // at once on the patient, a stroke of three places
  for (int i = 1; i <= 30; ++i) m.move(800.0f + 4 * float(i), 450);
  m.button(false);
  EXPECT_TRUE(gestures_of(m, 30, 60, front).empty()) << "the panels have not answered";
  m.draw();
  EXPECT_TRUE(gestures_of(m, 60, 90, front).empty()) << "a button of a panel acts when it is let go";
  m.feed.answers.push(HandChoice{Tool::excise, 3, 90, 4});
  m.draw();
  const std::vector<int32_t> got = gestures_of(m, 90, 200, front);
  ASSERT_GT(got.size(), 6u) << "the stroke was kept while it waited";
  EXPECT_EQ(got.front(), ToolEvent::stroke_begin);
  EXPECT_EQ(got.back(), ToolEvent::stroke_end);
  ASSERT_EQ(m.heard.control.size(), 2u);
  EXPECT_EQ(m.heard.control.back().tool, Tool::excise);
  EXPECT_EQ(m.heard.control.back().value[kDepth], 3);
  m.key('2');
  gestures_of(m, 200, 210, front);
  EXPECT_EQ(m.heard.control.back().value[kDepth], 3) << "what was set on a panel holds for the next tool";
}

// The same between three threads: whatever their pace, each click on the patient has the tool that was chosen for it.
TEST(InputOrder, HoldsBetweenThreeThreads) {
  Mouse m;
  m.show({{0, 0, 300, 900}});
  constexpr int kRounds = 60;
  const auto tool_of = [](int round) { return Tool(int(Tool::scalpel) + round % 3); };
  std::atomic<bool> stop{false};
  std::thread render([&] {  // draws, and answers each click on the palette when its button is let go
    int round = 0;
    while (!stop) {
      uint64_t last = 0;
      for (WindowEvent e; m.screen.events.pop(e);) {
        last = e.number;
        if (e.kind == WindowEvent::button && e.for_panels && !e.down)
          m.feed.answers.push(HandChoice{tool_of(round++), 3, 90, 4});
      }
      m.show({{0, 0, 300, 900}});
      if (last > 0) m.feed.answered.store(last);
      std::this_thread::sleep_for(std::chrono::microseconds(300));
    }
  });
  std::vector<Tool> pressed_with;
  std::atomic<int> pressed{0};
  std::thread device([&] {
    PointerSource source(m.feed);
    struct Hear final : SampleSink {
      std::vector<Tool>& all;
      std::atomic<int>& presses;
      Tool tool = Tool::none;
      bool down = false;
      Hear(std::vector<Tool>& a, std::atomic<int>& n) : all(a), presses(n) {}
      void on_sample(const Sample& x) override {
        if (const auto* c = std::get_if<ControlSample>(&x)) tool = c->tool;
        if (const auto* s = std::get_if<StylusSample>(&x)) {
          if (s->buttons && !down) all.push_back(tool), ++presses;
          down = s->buttons;
        }
      }
    } hear(pressed_with, pressed);
    for (int64_t tick = 0; !stop; ++tick) {
      source.look(m.s);
      source.poll(tick * 1'000'000, hear);
      std::this_thread::yield();
    }
  });
  const auto began = std::chrono::steady_clock::now();
  for (int round = 0; round < kRounds; ++round) {
    m.move(200, 100), m.button(true), m.button(false);
    m.move(800, 450), m.button(true), m.button(false);
  }
  while (pressed < kRounds && std::chrono::steady_clock::now() - began < std::chrono::seconds(60)) {
    m.router.pump(0);
    std::this_thread::sleep_for(std::chrono::microseconds(200));
  }
  stop = true;
  render.join(), device.join();
  ASSERT_EQ(pressed_with.size(), size_t(kRounds));
  for (int round = 0; round < kRounds; ++round) EXPECT_EQ(pressed_with[size_t(round)], tool_of(round)) << round;
}

TEST(InputOrder, KeysOfATextFieldChooseNoTool) {
  Mouse m;
  PointerSource source(m.feed);
  m.show({{0, 0, 300, 900}});
  m.move(200, 100), m.button(true), m.button(false);
  m.key('5');  // typed before the frame with the field is drawn
  m.run(source, 0, 10), m.draw();
  m.show({{0, 0, 300, 900}}, true);
  m.run(source, 10, 20), m.draw();
  m.run(source, 20, 30);
  const std::vector<WindowEvent> seen = m.draw();
  ASSERT_FALSE(seen.empty());
  EXPECT_EQ(seen[0].code, '5');
  EXPECT_TRUE(seen[0].for_panels);
  EXPECT_FALSE(seen[0].for_hand);
  EXPECT_TRUE(m.heard.control.empty());
  // Escape and a click beside it end the typing; the key after that is the hand's.
  m.run(source, 30, 40), m.draw();
  m.move(800, 450), m.button(true), m.button(false), m.key('5');
  for (int64_t t = 40; t < 90; t += 10) {
    m.run(source, t, t + 10);
    m.draw();
    m.show({{0, 0, 300, 900}}, false);
  }
  ASSERT_EQ(m.heard.control.size(), 1u);
  EXPECT_EQ(m.heard.control[0].tool, Tool::hook);
}

ShowActs shows(std::vector<Command> acts, int undos = 0) {
  return {undos, std::make_shared<const std::vector<Command>>(std::move(acts))};
}

TEST(Pointer, WhatIsShownIsBracketed) {
  Mouse m;
  PointerSource source(m.feed);
  m.key('5');
  m.run(source, 0, 50);
  EXPECT_TRUE(m.heard.stylus.empty());
  m.feed.answers.push(shows({Incise{{{-10, 0}, {10, 0}}, 3, 90, false}}, 1));
  m.run(source, 50, 100);
  EXPECT_TRUE(m.feed.showing);
  m.move(800, 450), m.button(true), m.button(false);  // the hand that shows has the tool
  m.run(source, 100, 4000);
  EXPECT_TRUE(m.feed.showing) << "until what was taken back is gone";
  m.s.step += 3;
  m.run(source, 4000, 8000);
  EXPECT_FALSE(m.feed.showing);
  ASSERT_EQ(m.heard.commands.size(), 2u);
  EXPECT_TRUE(std::get<Shown>(*m.heard.commands[0].command).begins);
  EXPECT_FALSE(std::get<Shown>(*m.heard.commands[1].command).begins);
  ASSERT_GT(m.heard.stylus.size(), 50u);
  double pressed_from = 1e9, pressed_to = -1e9;
  int presses = 0;
  for (size_t i = 0; i < m.heard.stylus.size(); ++i) {
    const StylusSample& p = m.heard.stylus[i];
    EXPECT_EQ(p.device_id, PointerSource::kDevice);
    if (i > 0) {
      EXPECT_GT(p.t_ns, m.heard.stylus[i - 1].t_ns);
      presses += p.buttons && !m.heard.stylus[i - 1].buttons;
    }
    if (p.buttons) pressed_from = std::min(pressed_from, p.tip_mm.x()), pressed_to = std::max(pressed_to, p.tip_mm.x());
  }
  EXPECT_EQ(presses, 1);
  EXPECT_NEAR(pressed_from, -10, 0.6);
  EXPECT_NEAR(pressed_to, 10, 0.6);
  // Afterwards a click uses the tool that was chosen before, not the last of those that the other hand took.
  ASSERT_GT(m.heard.control.size(), 3u);
  EXPECT_EQ(m.heard.control.front().tool, Tool::hook);
  EXPECT_EQ(m.heard.control[1].kind, ControlSample::undo);
  EXPECT_EQ(m.heard.control.back().kind, ControlSample::select_tool);
  EXPECT_EQ(m.heard.control.back().tool, Tool::hook);
}

// Bone alone: the same button, another hand. It saws and carries
// with the stylus; a skull has no chart for the other one to aim on.
TEST(Pointer, ActsOnBoneAreShown) {
  CutBone cut;
  cut.contour_mm = {{-8, -6, 0}, {8, -6, 0}, {0, 8, 0}};
  MoveFragment move;
  move.fragment = {-1, {2, 1, 0}}, move.by.translation_mm = {0, 0, 6}, move.by.rotation_deg = {0, 0, 30},
  move.by.about_mm = Vec3::Zero(), move.seconds = 1;
  const std::vector<Command> acts{HeadCommand(cut), HeadCommand(move)};
  Mouse m;
  auto bone = std::make_shared<SurfaceTopology>(*m.s.topology);
  bone->body = nullptr;
  bone->organ.assign(bone->view.tri.size(), Organ::bone);
  bone->object.assign(bone->view.tri.size(), 0);
  m.s.topology = bone;
  PointerSource source(m.feed);
  int64_t ms = 0;
  for (const Command& c : acts) {
    m.feed.answers.push(shows({c}));
    do m.run(source, ms, ms + 100), ms += 100;
    while (m.feed.showing && ms < 16000);
  }
  EXPECT_FALSE(m.feed.showing);
  std::vector<Tool> tools;
  for (const ControlSample& c : m.heard.control)
    if (c.kind == ControlSample::select_tool && c.tool != Tool::none) tools.push_back(c.tool);
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

// A lesson asks for a place: a click on the patient is its answer, and no act of the tool in the hand.
TEST(InputOrder, AClickThatAnswersIsNoAct) {
  Mouse m;
  DeviceFrontEnd front{Calibration{}};
  front.add(std::make_unique<PointerSource>(m.feed));
  m.key('2');
  m.move(800, 450);
  gestures_of(m, 0, 50, front);
  m.draw();
  FrameSeen& f = m.feed.seen.writing();
  f = {}, f.view = m.view, f.width = 1600, f.height = 900, f.asks = true;
  m.feed.seen.publish();
  m.button(true);
  std::vector<int32_t> got = gestures_of(m, 50, 100, front);
  const std::vector<WindowEvent> seen = m.draw();
  m.button(false);
  const std::vector<int32_t> after = gestures_of(m, 100, 150, front);
  got.insert(got.end(), after.begin(), after.end());
  EXPECT_TRUE(got.empty());
  ASSERT_FALSE(seen.empty());
  EXPECT_TRUE(seen.back().for_panels);
}

// Of a row one edge was drawn, and then the program is asked to show: its first edge is none of the learner's.
TEST(InputOrder, ARowThatIsBegunIsGivenUpWhenTheProgramShows) {
  CommandBuilder builder;
  const auto edge = [&](double y) {
    ToolEvent e;
    e.tool = int32_t(Tool::suture_row), e.spacing_mm = 4;
    std::optional<Command> done;
    for (int x = 0; x <= 20; ++x) {
      e.kind = x == 0 ? ToolEvent::stroke_begin : ToolEvent::stroke_point, e.chart_x = e.world_mm[0] = x, e.chart_y = y;
      builder.feed(e);
    }
    e.kind = ToolEvent::stroke_end;
    return builder.feed(e);
  };
  EXPECT_FALSE(edge(3));
  EXPECT_TRUE(edge(-3)) << "two edges make a row";
  EXPECT_FALSE(edge(3));
  ToolEvent told;
  told.kind = ToolEvent::told, told.command = std::make_shared<const Command>(Shown{true});
  EXPECT_TRUE(builder.feed(told));
  EXPECT_EQ(builder.dropped(), 1) << "and it is said";
  EXPECT_FALSE(edge(12));
  const std::optional<Command> row = edge(8);
  ASSERT_TRUE(row && std::holds_alternative<SutureRow>(*row));
  EXPECT_NEAR(std::get<SutureRow>(*row).a.front().y(), 12, 1e-6);
}

}  // namespace test_pointer
}  // namespace limberg
