// Gestures on flat and pulled skin, and the index that finds it.
#include <gtest/gtest.h>

#include "devices/command_builder.h"
#include "devices/gestures.h"
#include "devices/skin_chart.h"
#include "sim/geometry/bvh.h"
#include "tests/devices/flat_patient.h"
#include "tests/devices/samples.h"

namespace limberg {
namespace test_gestures {

using namespace test;

Pose pose_at(const Vec3& tip, const Vec3& shaft = Vec3::UnitZ()) {
  Pose p;
  p.tip_mm = tip;
  p.shaft = shaft.normalized();
  p.valid = true;
  return p;
}

/// A hand driven by hand: one tick per call.
struct Hand {
  explicit Hand(Snapshot s) : snapshot(std::move(s)) {}
  void choose(Tool tool, std::array<double, 4> value = {}) {
    ControlSample c;
    c.kind = ControlSample::select_tool;
    c.tool = tool;
    c.value = value;
    g.control(c, tick, snapshot, events);
  }
  void control(int kind, double value = 0) {
    ControlSample c;
    c.kind = kind;
    c.value[0] = value;
    g.control(c, tick, snapshot, events);
  }
  void at(const Vec3& tip, bool pressed, const Vec3& shaft = Vec3::UnitZ()) {
    g.tick(tick++, pose_at(tip, shaft), pressed, pressed != before, snapshot, events);
    before = pressed;
  }
  void blind(bool pressed, int ticks) {
    for (int i = 0; i < ticks; ++i)
      g.tick(tick++, Pose{}, pressed, pressed != before, snapshot, events), before = pressed;
  }
  void draw(const Vec3& a, const Vec3& b, const Vec3& shaft = Vec3::UnitZ(), int steps = 200) {
    for (int i = 0; i <= steps; ++i) at(a + double(i) / steps * (b - a), true, shaft);
  }
  std::optional<Command> command() {
    std::optional<Command> c;
    for (; built < events.all.size(); ++built)
      if (auto k = builder.feed(events.all[built])) c = k;
    return c;
  }
  Snapshot snapshot;
  Gestures g;
  Events events;
  CommandBuilder builder;
  size_t built = 0;
  int64_t tick = 0;
  bool before = false;
};

TEST(SurfaceIndex, ClosestIsThatOfTheTree) {
  // Against the bounding volume hierarchy, on a wavy skin of uneven triangles.
  const auto topology = flat_topology(40, 1);
  const Snapshot s = snapshot_of(topology, [](const Vec3& X) {
    return Vec3(X.x() + 3 * std::sin(X.y() / 9), X.y() * 0.9, 5 * std::sin(X.x() / 17) * std::cos(X.y() / 13));
  });
  const SurfaceIndex index;
  std::vector<Vec3> x;
  for (const Vec3f& v : s.x_mm) x.push_back(v.cast<double>());
  const Bvh bvh(x, topology->view.tri.flat());
  Dice dice{12};
  int32_t hint = -1;
  Vec3 p(0, 0, 4);
  for (int k = 0; k < 3000; ++k) {
    p += 0.4 * Vec3(dice.normal(), dice.normal(), 0.3 * dice.normal());
    p = p.cwiseMax(Vec3(-58, -50, -2)).cwiseMin(Vec3(58, 50, 10));
    const auto want = bvh.closest(p);
    const SkinTouch all = index.closest(s, p, -1), walked = index.closest(s, p, hint);
    ASSERT_NEAR(all.distance_mm, want.distance_mm, 1e-6) << k;
    ASSERT_LT(walked.distance_mm, want.distance_mm + 1.5);  // a walk may be caught behind a wave ...
    hint = k % 4 == 0 ? all.triangle : walked.triangle;     // ... for at most a few ticks
  }
}

TEST(SkinChart, PointsAreFoundWhereTheyLieNow) {
  auto map = [](const Vec3& X) { return Vec3(2 * X.x(), X.y() + 7, 0.1 * X.x()); };
  const auto topology = flat_topology(30, 1, [](double x, double y) { return std::hypot(x - 10, y) < 6; });
  const Snapshot s = snapshot_of(topology, map);
  SkinChart skin;
  skin.build(*topology);
  Dice dice{5};
  for (int k = 0; k < 2000; ++k) {
    const ChartPoint c(130 * dice.unit() - 65, 130 * dice.unit() - 65);
    const SkinTouch t = skin.at(s, c);
    const bool outside = c.cwiseAbs().maxCoeff() > 60;
    if (outside || (c - ChartPoint(10, 0)).norm() < 2) {
      EXPECT_EQ(t.triangle, -1);
    } else if ((c - ChartPoint(10, 0)).norm() > 10) {
      ASSERT_GE(t.triangle, 0);
      EXPECT_LT((t.chart - c).norm(), 1e-9);
      EXPECT_LT((t.x_mm - map(Vec3(c.x(), c.y(), 0))).norm(), 1e-4);
    }
    // With slack the rim answers, and the answer is as near as it says.
    const SkinTouch near = skin.at(s, c, 3);
    if (near.triangle >= 0) {
      EXPECT_NEAR((near.chart - c).norm(), near.distance_mm, 1e-9);
    }
    if (outside && c.cwiseAbs().maxCoeff() < 62) {
      EXPECT_GE(near.triangle, 0);
    }
  }
}

// A blade that leans goes in where its own line meets the skin, not at the skin that is nearest.
TEST(SkinChart, ABladeThatLeansMeetsTheSkinOnItsOwnLine) {
  auto map = [](const Vec3& X) { return Vec3(X.x(), X.y() + 7, 0.5 * X.x()); };
  const auto topology = flat_topology(30, 1, [](double x, double y) { return std::hypot(x - 10, y) < 6; });
  const Snapshot s = snapshot_of(topology, map);
  Dice dice{6};
  int met = 0;
  for (int k = 0; k < 2000; ++k) {
    const Vec3 X(100 * dice.unit() - 50, 100 * dice.unit() - 50, 4 * dice.unit() - 2);
    const Vec3 out(1.5 * dice.unit() - 0.75, 1.5 * dice.unit() - 0.75, 1);
    const Vec3 want = X - X.z() * out;  // where z is 0
    const SkinTouch t = SkinChart::on_line_at_rest(s, X, out, 5);
    if (std::hypot(want.x() - 10, want.y()) < 2) {
      EXPECT_EQ(t.triangle, -1) << "a hole";
    } else if (std::hypot(want.x() - 10, want.y()) > 10) {
      ASSERT_GE(t.triangle, 0);
      EXPECT_LT((t.X_mm - want).norm(), 1e-9);
      EXPECT_LT((t.x_mm - map(want)).norm(), 1e-4);
      EXPECT_NEAR(t.distance_mm, std::abs(X.z()) * out.norm(), 1e-9);
      EXPECT_EQ(SkinChart::on_line_at_rest(s, X, out, 0.99 * t.distance_mm).triangle, -1) << "out of reach";
      EXPECT_EQ(SkinChart::on_line_at_rest(s, X, -out, 5).triangle, -1) << "from below";
      ++met;
    }
  }
  EXPECT_GT(met, 1000);
}

TEST(Gestures, AScalpelStrokeBecomesAnIncision) {
  Hand h(snapshot_of(flat_topology(60, 1)));
  h.choose(Tool::scalpel, {5, 0, 0, 0});
  h.at(Vec3(-20, 0, 1), false);
  h.draw(Vec3(-20, 0, 0.2), Vec3(15, 10, 0.2));
  h.at(Vec3(15, 10, 1), false);
  EXPECT_EQ(h.events.count(ToolEvent::stroke_begin), 1);
  EXPECT_EQ(h.events.count(ToolEvent::stroke_end), 1);
  ChartPoint last(1e9, 1e9);
  for (size_t i = 0; i < h.events.all.size(); ++i) {
    const ToolEvent& e = h.events.all[i];
    EXPECT_EQ(e.seq, int64_t(i));
    if (e.kind != ToolEvent::stroke_point || i + 2 >= h.events.all.size()) continue;
    const ChartPoint c(e.chart_x, e.chart_y);
    EXPECT_GE((c - last).norm(), 0.4 - 1e-9);
    last = c;
  }
  const auto c = h.command();
  ASSERT_TRUE(c && std::holds_alternative<Incise>(*c));
  const auto& i = std::get<Incise>(*c);
  EXPECT_EQ(i.depth_mm, 5);
  EXPECT_NEAR(i.angle_deg, 90, 1e-6);
  ASSERT_EQ(i.path.size(), 2u);
  EXPECT_LT((i.path[0] - ChartPoint(-20, 0)).norm(), 1e-6);
  EXPECT_LT((i.path[1] - ChartPoint(15, 10)).norm(), 1e-6);
}

TEST(Gestures, TheBladeLeansAsTheShaftDoes) {
  // Along +x, left is +y. A handle that leans to the left makes
  // an angle below 90; its lean along the path says nothing.
  for (double deg : {60.0, 90.0, 115.0}) {
    Hand h(snapshot_of(flat_topology(60, 1)));
    h.choose(Tool::scalpel);
    const double a = deg * M_PI / 180;
    h.at(Vec3(-20, 0, 1), false);
    h.draw(Vec3(-20, 0, 0.2), Vec3(20, 0, 0.2), Vec3(-0.4, std::cos(a), std::sin(a)));
    h.at(Vec3(20, 0, 0.2), false);
    const auto c = h.command();
    ASSERT_TRUE(c);
    EXPECT_NEAR(std::get<Incise>(*c).angle_deg, deg, 1e-6);
  }
  Hand h(snapshot_of(flat_topology(60, 1)));
  h.choose(Tool::scalpel, {4, 70, 0, 0});  // said outright
  h.draw(Vec3(-20, 0, 0.2), Vec3(20, 0, 0.2));
  h.at(Vec3(20, 0, 0.2), false);
  EXPECT_EQ(std::get<Incise>(*h.command()).angle_deg, 70);
}

TEST(Gestures, PointsAreMaterialPoints) {
  auto map = [](const Vec3& X) { return Vec3(1.5 * X.x() + 4, X.y(), -2); };
  Hand h(snapshot_of(flat_topology(60, 1), map));
  h.choose(Tool::suture);
  h.at(map(Vec3(3, 4, 0)) + Vec3(0, 0, 1), false);
  h.at(map(Vec3(3, 4, 0)), true);
  h.at(map(Vec3(3, 4, 0)) + Vec3(0, 0, 15), true);
  for (int i = 0; i < 20; ++i) h.at(map(Vec3(-7, 9, 0)) + Vec3(0, 0, 20 - i), true);
  h.at(map(Vec3(-7, 9, 0)), false);
  const auto c = h.command();
  ASSERT_TRUE(c && std::holds_alternative<Suture>(*c));
  EXPECT_LT((std::get<Suture>(*c).a - ChartPoint(3, 4)).norm(), 1e-4);
  EXPECT_LT((std::get<Suture>(*c).b - ChartPoint(-7, 9)).norm(), 1e-4);
}

TEST(Gestures, ARestingHandMeansTheMiddleOfItsTremor) {
  Hand h(snapshot_of(flat_topology(60, 1)));
  h.choose(Tool::suture);
  auto tremble = [&](const Vec3& p, int ticks, bool pressed, double hz) {
    for (int i = 0; i < ticks; ++i)
      h.at(p + Vec3(0.3 * std::sin(2 * M_PI * hz * i * 1e-3 + 1), 0.3 * std::cos(2 * M_PI * hz * i * 1e-3 + 1), 0),
           pressed);
  };
  tremble(Vec3(3, 4, 0.2), 150, false, 10);
  tremble(Vec3(-7, 9, 0.2), 150, true, 10);
  h.at(Vec3(-7, 9, 0.2), false);
  const auto c = h.command();
  ASSERT_TRUE(c);
  // The press is seen on the first tick after the rest at a, when
  // the hand has already left: the point of the press counts.
  EXPECT_LT((std::get<Suture>(*c).b - ChartPoint(-7, 9)).norm(), 0.02);

  tremble(Vec3(3, 4, 0.2), 150, false, 10);
  tremble(Vec3(3, 4, 0.2), 150, true, 10);
  h.at(Vec3(3, 4, 0.2), false);
  ASSERT_TRUE(h.command());
  const ToolEvent* a = nullptr;
  for (const ToolEvent& e : h.events.all)
    if (e.kind == ToolEvent::suture_a) a = &e;
  EXPECT_LT((ChartPoint(a->chart_x, a->chart_y) - ChartPoint(3, 4)).norm(), 0.02);
}

TEST(Gestures, ASutureThatEndsInTheAirIsCancelled) {
  Hand h(snapshot_of(flat_topology(60, 1)));
  h.choose(Tool::suture);
  h.at(Vec3(0, 0, 0), true);
  h.at(Vec3(0, 0, 30), true);
  h.at(Vec3(0, 0, 30), false);
  EXPECT_EQ(h.events.count(ToolEvent::suture_cancel), 1);
  EXPECT_FALSE(h.command());
}

TEST(Gestures, HooksAreSetHeldLeftTakenAndReleased) {
  Hand h(snapshot_of(flat_topology(60, 1)));
  size_t next = 0;
  auto follow = [&] { move_hooks(h.snapshot, h.events.all, next, h.g.state()); };
  h.choose(Tool::hook, {0, 0, 0, 5});
  h.at(Vec3(0, 0, 0), true);
  follow();
  EXPECT_EQ(h.g.state().held_hook, 5);
  for (int i = 1; i <= 10; ++i) h.at(Vec3(i, 0, i), true), follow();
  h.at(Vec3(10, 0, 10), false);
  EXPECT_EQ(h.g.state().held_hook, 0);
  EXPECT_EQ(h.events.count(ToolEvent::hook_release), 0);
  auto c = h.command();
  ASSERT_TRUE(c && std::holds_alternative<MoveHook>(*c));
  EXPECT_LT((std::get<MoveHook>(*c).to_mm - Vec3(10, 0, 10)).norm(), 1e-9);
  // Taken again, near its handle, without a number.
  h.choose(Tool::hook);
  h.at(Vec3(11, 0, 10), true);
  follow();
  EXPECT_EQ(h.g.state().held_hook, 5);
  EXPECT_EQ(h.events.count(ToolEvent::hook_take), 1);
  h.at(Vec3(0, 9, 10), true);
  h.at(Vec3(0, 9, 10), false);
  // A second hook on the skin gets a number of its own.
  h.at(Vec3(-30, 0, 0), true);
  EXPECT_EQ(h.g.state().held_hook, 6);
  h.at(Vec3(-30, 0, 0), false);
  h.control(ControlSample::release_hook, 5);
  EXPECT_EQ(h.events.all.back().kind, ToolEvent::hook_release);
  EXPECT_EQ(h.events.all.back().id, 5);
}

TEST(Gestures, PressedInTheAirIsAMissedPress) {
  Hand h(snapshot_of(flat_topology(60, 1)));
  for (Tool t : {Tool::scalpel, Tool::hook, Tool::suture}) {
    h.choose(t);
    h.at(Vec3(0, 0, 20), true);
    h.at(Vec3(0, 0, 0), true);  // coming down with the button pressed does not begin anything
    h.at(Vec3(0, 0, 20), false);
  }
  EXPECT_TRUE(h.events.all.empty());
  EXPECT_EQ(h.g.missed_presses(), 3);
}

TEST(Gestures, AStrokeOutlivesAShortGapButNotALongOne) {
  Hand h(snapshot_of(flat_topology(60, 1)));
  h.choose(Tool::scalpel);
  h.draw(Vec3(-20, 0, 0), Vec3(0, 0, 0));
  h.blind(true, 500);
  h.draw(Vec3(1, 0, 0), Vec3(20, 0, 0));
  h.at(Vec3(20, 0, 0), false);
  EXPECT_EQ(h.events.count(ToolEvent::stroke_end), 1);
  EXPECT_EQ(h.events.count(ToolEvent::stroke_cancel), 0);
  ASSERT_TRUE(h.command());

  h.draw(Vec3(-20, 5, 0), Vec3(0, 5, 0));
  h.blind(true, 1500);
  EXPECT_EQ(h.events.count(ToolEvent::stroke_cancel), 1);
  h.draw(Vec3(1, 5, 0), Vec3(20, 5, 0));  // still pressed: nothing begins
  h.at(Vec3(20, 5, 0), false);
  EXPECT_EQ(h.events.count(ToolEvent::stroke_begin), 2);
  EXPECT_FALSE(h.command());

  h.draw(Vec3(-20, 9, 0), Vec3(0, 9, 0));
  h.blind(true, 50);
  h.draw(Vec3(40, -9, 0), Vec3(50, -9, 0));  // came back elsewhere
  EXPECT_EQ(h.events.count(ToolEvent::stroke_cancel), 2);
}

TEST(Gestures, LiftingEndsAStroke) {
  Hand h(snapshot_of(flat_topology(60, 1)));
  h.choose(Tool::scalpel);
  h.draw(Vec3(-20, 0, 0), Vec3(0, 0, 0));
  h.draw(Vec3(0, 0, 0), Vec3(0, 0, 20));
  EXPECT_EQ(h.events.count(ToolEvent::stroke_end), 1);
  h.draw(Vec3(0, 0, 20), Vec3(0, 0, 0));
  h.draw(Vec3(0, 0, 0), Vec3(10, 0, 0));
  EXPECT_EQ(h.events.count(ToolEvent::stroke_begin), 1);
}

TEST(Gestures, ANewToolCancelsAStroke) {
  Hand h(snapshot_of(flat_topology(60, 1)));
  h.choose(Tool::scalpel);
  h.draw(Vec3(-20, 0, 0), Vec3(0, 0, 0));
  h.choose(Tool::excise);
  h.at(Vec3(0, 0, 0), false);
  EXPECT_EQ(h.events.count(ToolEvent::stroke_cancel), 1);
  EXPECT_EQ(h.events.count(ToolEvent::stroke_end), 0);
}

TEST(Gestures, ChangingTopologyUnderAStrokeIsFollowed) {
  Hand h(snapshot_of(flat_topology(60, 1)));
  h.choose(Tool::scalpel);
  h.draw(Vec3(-20, 0, 0), Vec3(0, 0, 0));
  h.snapshot = snapshot_of(flat_topology(45, 2));
  h.draw(Vec3(0, 0, 0), Vec3(20, 0, 0));
  h.at(Vec3(20, 0, 0), false);
  const auto c = h.command();
  ASSERT_TRUE(c);
  EXPECT_LT((std::get<Incise>(*c).path.back() - ChartPoint(20, 0)).norm(), 1e-5);
  h.snapshot = Snapshot{};  // nothing to touch
  h.at(Vec3(20, 0, 0), true);
  EXPECT_EQ(h.g.touched().triangle, -1);
}

TEST(Gestures, AFullSinkIsCounted) {
  Hand h(snapshot_of(flat_topology(60, 1)));
  h.events.room = false;
  h.choose(Tool::scalpel);
  h.draw(Vec3(-20, 0, 0), Vec3(0, 0, 0));
  EXPECT_EQ(h.g.events_lost(), int64_t(h.events.all.size()));
  EXPECT_GT(h.g.events_lost(), 10);
}

TEST(Gestures, SkinThatIsNotANumberIsNotTouched) {
  Snapshot s = snapshot_of(flat_topology(20, 1));
  for (Vec3f& x : s.x_mm) x.setConstant(std::nanf(""));
  Hand h(std::move(s));
  h.choose(Tool::scalpel);
  h.draw(Vec3(-20, 0, 0), Vec3(0, 0, 0));
  EXPECT_TRUE(h.events.all.empty());
}

/// Two sheets, of skin at rest below y = -2 and above y = 2. The first is laid over the second, 6 mm further up, and
/// climbs along x: it is the nearer one of the two for a hand on the second at the left end only.
Snapshot two_sheets() {
  const auto t = flat_topology(120, 1, [](double, double y) { return std::abs(y) < 2; });
  return snapshot_of(t, [](const Vec3& X) { return X.y() < 0 ? Vec3(X.x(), X.y() + 8, 0.2 + 0.1 * (X.x() + 10)) : X; });
}

TEST(Gestures, ARowIsOnTheSkinThatStaysNearest) {
  for (const bool backwards : {false, true}) {
    Hand h(two_sheets());
    h.choose(Tool::suture_row, {0, 0, 3, 0});
    const Vec3 left(-10, 4, 0.15),
        right(10, 4, 0.05);  // the first sheet is 0.05 mm away at the left end, 2.15 at the right
    for (int row = 0; row < 2; ++row) {
      h.draw(backwards ? right : left, backwards ? left : right);
      h.at(backwards ? left : right, false);
    }
    const auto c = h.command();
    ASSERT_TRUE(c);
    const auto* r = std::get_if<SutureRow>(&*c);
    ASSERT_TRUE(r);
    for (const auto* path : {&r->a, &r->b}) {
      ASSERT_EQ(path->size(), 2u);
      for (const ChartPoint& p : *path) EXPECT_NEAR(p.y(), 4, 0.05);
      EXPECT_NEAR(path->front().x(), backwards ? 10 : -10, 0.3);
      EXPECT_NEAR(path->back().x(), backwards ? -10 : 10, 0.3);
    }
  }
}

/// The same, and the topology says where the wound's edges are, at y = -2 and 2.
Snapshot two_edges() {
  const auto t = flat_topology(120, 1, [](double, double y) { return std::abs(y) < 2; });
  for (size_t i = 0; i < t->view.tri.size(); ++i) {
    uint8_t rim = 0;
    for (size_t k = 0; k < 3 && t->view.kind[i] == FaceKind::skin; ++k) {
      const Vec3 &a = t->view.X_mm[size_t(t->view.tri[i][k])], &b = t->view.X_mm[size_t(t->view.tri[i][(k + 1) % 3])];
      if (std::abs(std::abs(a.y()) - 2) < 1e-9 && a.y() == b.y()) rim |= uint8_t(1 << k);
    }
    t->view.rim.push_back(rim);
  }
  Snapshot s = two_sheets();
  s.topology = t;
  return s;
}

// Where two edges lie on each other, both strokes of a row may find the same one nearest.
TEST(Gestures, ARowsSecondEdgeIsNotItsFirst) {
  const Vec3 left(-10, 4, 0.15), right(10, 4, 0.05);
  const auto rows = [&](bool as_meant) {
    Hand h(two_edges());
    GestureSettings set;
    set.as_meant = as_meant;
    h.g = Gestures(set);
    h.choose(Tool::suture_row, {0, 0, 3, 0});
    std::vector<SutureRow> got;
    for (int stroke = 0; stroke < 2; ++stroke) {
      h.draw(left, right);
      h.at(right, false);
    }
    for (; h.built < h.events.all.size(); ++h.built)
      if (auto c = h.builder.feed(h.events.all[h.built])) got.push_back(std::get<SutureRow>(*c));
    return got;
  };
  const auto mean_y = [](const std::vector<ChartPoint>& path) { return 0.5 * (path.front().y() + path.back().y()); };
  const std::vector<SutureRow> meant = rows(true), before = rows(false);
  ASSERT_EQ(meant.size(), 1u);
  EXPECT_NEAR(mean_y(meant[0].a), 4, 0.1) << "nearest over all of it";
  EXPECT_NEAR(mean_y(meant[0].b), -4, 0.1) << "the other one";
  ASSERT_EQ(before.size(), 1u);
  EXPECT_NEAR(mean_y(before[0].b), 4, 0.1) << "as recordings from before have it";
}

TEST(Gestures, AStitchEndsOnOtherSkinThanItBegan) {
  Hand h(two_sheets());
  h.choose(Tool::suture);
  // Begun on the first sheet, at rest at (-8, -4.5); let go 1 mm on, where that sheet covers the second.
  for (int i = 0; i < 3; ++i) h.at(Vec3(-8, 3.5, 0.45), true);
  h.at(Vec3(-7, 3.5, 0.4), true);
  h.at(Vec3(-7, 3.5, 0.4), false);
  const auto c = h.command();
  ASSERT_TRUE(c);
  const auto* stitch = std::get_if<Suture>(&*c);
  ASSERT_TRUE(stitch);
  EXPECT_NEAR(stitch->a.y(), -4.5, 0.1);
  EXPECT_NEAR(stitch->b.y(), 3.5, 0.1);
  EXPECT_NEAR(stitch->b.x(), -7, 0.1);
  // Where there is no other skin, it ends on the same.
  for (int i = 0; i < 40; ++i) h.at(Vec3(0, -30 + 8, 1.2), i >= 20);
  h.at(Vec3(1, -30 + 8, 1.3), true);
  h.at(Vec3(1, -30 + 8, 1.3), false);
  const auto d = h.command();
  ASSERT_TRUE(d);
  EXPECT_NEAR(std::get<Suture>(*d).b.y(), -30, 0.2);
}

TEST(CommandBuilder, AFirstRowAloneIsDroppedWhenSomethingElseBegins) {
  Hand h(snapshot_of(flat_topology(60, 1)));
  h.choose(Tool::suture_row, {0, 0, 3, 0});
  h.draw(Vec3(-20, 0, 0), Vec3(0, 0, 0));
  h.at(Vec3(0, 0, 0), false);
  h.choose(Tool::scalpel);
  h.draw(Vec3(-20, 9, 0), Vec3(0, 9, 0));
  h.at(Vec3(0, 9, 0), false);
  const auto c = h.command();
  ASSERT_TRUE(c && std::holds_alternative<Incise>(*c));
  EXPECT_EQ(h.builder.dropped(), 1);
}

}  // namespace test_gestures
}  // namespace limberg
