// The tools that a hand chooses: what a press, a way and letting go mean with each, on flat skin.
#include <gtest/gtest.h>

#include <map>

#include "devices/command_builder.h"
#include "devices/emulator.h"
#include "devices/gestures.h"
#include "sim/commands/script.h"
#include "sim/geometry/triangle.h"
#include "tests/devices/flat_patient.h"

namespace limberg {
namespace test_hand_tools {

using namespace test;

/// Two squares of skin with a slit of 2 mm along x = 0 between them, whose sides are edges of a wound.
Snapshot slit() {
  auto t = flat_topology(60, 1, [](double x, double) { return std::abs(x) < 2; });
  auto& view = const_cast<SurfaceTopology&>(*t).view;
  for (size_t k = 0; k < view.tri.size(); ++k) {
    uint8_t rim = 0;
    for (size_t c = 0; c < 3; ++c) {
      const double a = view.X_mm[size_t(view.tri[k][c])].x(), b = view.X_mm[size_t(view.tri[k][(c + 1) % 3])].x();
      if (view.kind[k] == FaceKind::skin && std::abs(a) == 2 && a == b) rim |= uint8_t(1 << c);
    }
    view.rim.push_back(rim);
  }
  return snapshot_of(t);
}

struct Missed final : EventSink {
  std::vector<MissedPress> all;
  std::vector<ToolEvent> events;
  bool push(const ToolEvent& e) override { return events.push_back(e), true; }
  void missed(const MissedPress& m) override { all.push_back(m); }
};

struct Hand {
  Snapshot s;
  Gestures g;
  Missed out;
  CommandBuilder builder;
  std::vector<Command> done;
  int64_t tick = 0;
  bool before = false;
  size_t built = 0;

  explicit Hand(Snapshot patient, const GestureSettings& set = {}) : s(std::move(patient)), g(set) {}
  void choose(Tool tool, double depth_mm = 0, double spacing_mm = 0) {
    ControlSample c;
    c.tool = tool, c.value[kDepth] = depth_mm, c.value[kSpacing] = spacing_mm;
    g.control(c, tick, s, out);
    build();
  }
  void at(double x, double y, bool pressed, double z = 0, int ticks = 120) {
    Pose p;
    p.tip_mm = Vec3(x, y, z), p.valid = true;
    for (int i = 0; i < ticks; ++i) g.tick(tick++, p, pressed, pressed != before, s, out), before = pressed;
    build();
  }
  void draw(double x0, double y0, double x1, double y1) {
    at(x0, y0, false), at(x0, y0, true);
    for (int i = 1; i <= 60; ++i) at(x0 + (x1 - x0) * i / 60, y0 + (y1 - y0) * i / 60, true, 0, 4);
    at(x1, y1, true), at(x1, y1, false);
  }
  void build() {
    for (; built < out.events.size(); ++built)
      if (auto c = builder.feed(out.events[built])) done.push_back(*c);
  }
  template <class C>
  const C* last() const {
    return done.empty() ? nullptr : std::get_if<C>(&done.back());
  }
};

TEST(HandTools, ABuriedStitchHasTheDepthThatWasChosenAndASingleOneNone) {
  Hand h(slit());
  for (const auto& [tool, depth] : {std::pair(Tool::suture, 0.0), {Tool::suture_buried, 1.5}}) {
    h.choose(tool, 1.5);
    h.at(-3, 5, false), h.at(-3, 5, true);
    EXPECT_EQ(h.g.state().bites, 1);
    EXPECT_NEAR(h.g.state().bite_mm[0][0], -3, 0.01) << "where the thread is seen to leave the skin";
    h.at(3, 5, true), h.at(3, 5, false);
    EXPECT_EQ(h.g.state().bites, 0);
    const auto* s = h.last<Suture>();
    ASSERT_NE(s, nullptr);
    EXPECT_EQ(s->depth_mm, depth);
    EXPECT_NEAR(s->a.x(), -3, 0.01);
    EXPECT_NEAR(s->b.x(), 3, 0.01);
  }
}

TEST(HandTools, AStitchBesideTheEndOfACutTakesTheOtherBankThoughTheSkinHangsTogetherRoundIt) {
  // A cut along x = 0 that ends at y = 0; .7 mm above the bank on the right lies a leaf of other skin.
  auto t = std::make_shared<SurfaceTopology>(*flat_topology(240, 1));
  SurfaceView& view = t->view;
  view.rim.assign(view.tri.size(), 0);
  std::map<int32_t, int32_t> other;
  for (size_t k = 0; k < view.tri.size(); ++k) {
    Vec3 middle = Vec3::Zero();
    for (const int32_t v : view.tri[k]) middle += view.X_mm[size_t(v)] / 3;
    if (std::abs(middle.x()) > 0.6 || middle.y() > 0 || middle.y() < -20) continue;
    const auto on_cut = [&](int32_t v) { return view.X_mm[size_t(v)].x() == 0; };
    for (size_t c = 0; c < 3; ++c)
      if (on_cut(view.tri[k][c]) && on_cut(view.tri[k][(c + 1) % 3])) view.rim[k] |= uint8_t(1 << c);
    for (int32_t& v : view.tri[k]) {
      if (middle.x() < 0 || !on_cut(v) || view.X_mm[size_t(v)].y() >= 0) continue;
      const auto [at, anew] = other.try_emplace(v, int32_t(view.X_mm.size()));
      if (anew) view.X_mm.push_back(Vec3(view.X_mm[size_t(v)]));
      v = at->second;
    }
  }
  const auto n = int32_t(view.X_mm.size());
  for (const Vec3& X : {Vec3(0.2, -3, 0.7), Vec3(3, -3, 0.7), Vec3(0.2, 2, 0.7)}) view.X_mm.push_back(X);
  view.tri.push_back({n, n + 1, n + 2}), view.kind.push_back(FaceKind::skin), view.rim.push_back(0);
  for (const bool in_space : {true, false}) {  // false: a recording from before
    GestureSettings set;
    set.in_space = in_space;
    Hand h(snapshot_of(t), set);
    h.choose(Tool::suture);
    h.at(-0.7, -0.7, false), h.at(-0.7, -0.7, true), h.at(0.7, -0.7, true), h.at(0.7, -0.7, false);
    ASSERT_EQ(h.out.events.size(), 2u);
    EXPECT_NEAR(h.out.events.back().rest_mm[2], in_space ? 0 : 0.7, 1e-6);
    EXPECT_TRUE(h.out.all.empty());
    // On one bank it is the leaf that is meant, and where there is none the hand is told.
    h.at(0.7, -0.7, false), h.at(0.7, -0.7, true), h.at(0.7, -1.9, true), h.at(0.7, -1.9, false);
    EXPECT_NEAR(h.out.events.back().rest_mm[2], 0.7, 1e-6);
    h.at(5, -0.7, false), h.at(5, -0.7, true), h.at(5, -1.9, true), h.at(5, -1.9, false);
    EXPECT_EQ(h.out.all.size(), 1u);
  }
}

TEST(HandTools, ACornersStitchTakesBankTipAndBank) {
  Hand h(slit());
  h.choose(Tool::suture_corner, 1);
  h.at(-3, -4, false), h.at(-3, -4, true);
  h.at(3, 0, true), h.at(3, 0, false);
  EXPECT_TRUE(h.done.empty()) << "two bites are no corner's stitch";
  EXPECT_EQ(h.g.state().bites, 2);
  h.at(-3, 4, false), h.at(-3, 4, true), h.at(-3, 4, false);
  const auto* c = h.last<SutureCorner>();
  ASSERT_NE(c, nullptr);
  EXPECT_NEAR((c->a - ChartPoint(-3, -4)).norm(), 0, 0.01);
  EXPECT_NEAR((c->tip - ChartPoint(3, 0)).norm(), 0, 0.01);
  EXPECT_NEAR((c->b - ChartPoint(-3, 4)).norm(), 0, 0.01);
  EXPECT_EQ(c->depth_mm, 1);
  // Begun and given up for another tool: nothing is left of it.
  h.at(-3, -4, false), h.at(-3, -4, true), h.at(3, 0, true), h.at(3, 0, false);
  h.choose(Tool::suture);
  EXPECT_EQ(h.g.state().bites, 0);
  h.at(-3, 9, false), h.at(-3, 9, true), h.at(3, 9, true), h.at(3, 9, false);
  EXPECT_NE(h.last<Suture>(), nullptr);
}

TEST(HandTools, TwoEdgesDrawnWithTheRunningStitchAreOneThread) {
  Hand h(slit());
  for (const Tool tool : {Tool::suture_row, Tool::suture_running}) {
    h.choose(tool, 0, 5);
    h.draw(-3, -20, -3, 20);
    h.draw(3, -20, 3, 20);
    const auto* row = h.last<SutureRow>();
    ASSERT_NE(row, nullptr);
    EXPECT_EQ(row->running, tool == Tool::suture_running);
    EXPECT_EQ(row->spacing_mm, 5);
    EXPECT_EQ(row->depth_mm, 0);
  }
}

TEST(HandTools, BiteAfterBiteIsOneThreadAndAKnotEndsIt) {
  Hand h(slit());
  h.choose(Tool::suture_knot);
  h.at(3, 0, false), h.at(3, 0, true), h.at(3, 0, false);
  ASSERT_EQ(h.out.all.size(), 1u);
  EXPECT_EQ(h.out.all[0].kind, MissedPress::no_thread);
  h.choose(Tool::suture_bites, 1.5);
  for (const double y : {-4.0, 0.0, 4.0}) {
    h.at(-3, y, false), h.at(-3, y, true);
    EXPECT_EQ(h.g.state().bites, 1);
    h.at(4, y, true), h.at(4, y, false);
    const auto* bite = h.last<SutureBite>();
    ASSERT_NE(bite, nullptr);
    EXPECT_NEAR((bite->a - ChartPoint(-3, y)).norm(), 0, 0.01);
    EXPECT_NEAR((bite->b - ChartPoint(4, y)).norm(), 0, 0.01);
    EXPECT_EQ(bite->depth_mm, 0);
  }
  EXPECT_EQ(h.done.size(), 3u);
  h.s.sewn.thread = 1, h.s.sewn.bites = 3, h.s.sewn.end_mm = Vec3f(4, 4, 0);
  h.choose(Tool::suture_knot);
  h.at(20, 4, false), h.at(20, 4, true), h.at(20, 4, false);
  EXPECT_EQ(h.out.all.size(), 2u) << "a knot far from the last bite";
  h.at(5, 5, false), h.at(5, 5, true), h.at(5, 5, false);
  EXPECT_NE(h.last<TieSuture>(), nullptr);
}

TEST(HandTools, AHandThatTakesAnotherToolLetsGoOfAnUntiedThread) {
  for (const bool slips : {true, false}) {  // false: a recording from before
    GestureSettings set;
    set.threads_slip = slips;
    Hand h(slit(), set);
    const auto let_go = [&] {
      return std::count_if(h.done.begin(), h.done.end(),
                           [](const Command& c) { return std::holds_alternative<LetThreadGo>(c); });
    };
    h.choose(Tool::suture_bites);
    h.at(-3, 0, false), h.at(-3, 0, true), h.at(4, 0, true), h.at(4, 0, false);
    h.s.sewn.thread = 1, h.s.sewn.bites = 1, h.s.sewn.end_mm = Vec3f(4, 0, 0);
    for (const Tool tool : {Tool::suture_knot, Tool::suture_bites, Tool::swab}) {
      h.choose(tool), h.at(4, 0, false);
      EXPECT_EQ(let_go(), 0) << int(tool);  // the swab is in the other hand
    }
    h.choose(Tool::hook), h.at(4, 0, false);  // also from the swab
    EXPECT_EQ(let_go(), slips ? 1 : 0);
    h.choose(Tool::scalpel), h.at(4, 0, false);
    EXPECT_EQ(let_go(), slips ? 1 : 0) << "once";
    // Knotted, and laid down before the patient shows it.
    h.choose(Tool::suture_knot);
    h.at(4, 0, false), h.at(4, 0, true), h.at(4, 0, false);
    h.choose(Tool::hook), h.at(4, 0, false);
    EXPECT_EQ(let_go(), slips ? 1 : 0);
    // Tied: nothing is let go.
    h.choose(Tool::suture_knot);
    h.s.sewn = {};
    h.choose(Tool::none), h.at(4, 0, false);
    EXPECT_EQ(let_go(), slips ? 1 : 0);
  }
}

TEST(HandTools, ABuriedRowHasItsDepthAndARowNone) {
  Hand h(slit());
  h.choose(Tool::suture_row_buried, 1.5, 5);
  h.draw(-3, -20, -3, 20), h.draw(3, -20, 3, 20);
  const auto* row = h.last<SutureRow>();
  ASSERT_NE(row, nullptr);
  EXPECT_EQ(row->depth_mm, 1.5);
  EXPECT_FALSE(row->running);
}

TEST(HandTools, ADeepStitchSaysWhichFaceItGoesInto) {
  // Skin at 0; below it, beside the slit, a floor that looks up and a ceiling that looks down.
  auto t = std::make_shared<SurfaceTopology>(*slit().topology);
  SurfaceView& view = t->view;
  const auto face = [&](std::array<Vec3, 3> c) {
    const auto n = int32_t(view.X_mm.size());
    for (const Vec3& p : c) view.X_mm.push_back(p);
    view.tri.push_back({n, n + 1, n + 2}), view.kind.push_back(FaceKind::wall), view.rim.push_back(0);
  };
  face({Vec3(-1, -1, -4), Vec3(1, -1, -4), Vec3(0, 1, -4)});    // a bed
  face({Vec3(45, -2, -4), Vec3(46, 0, -4), Vec3(47, -2, -4)});  // a flap's underside
  Hand h(snapshot_of(t));
  h.choose(Tool::suture_deep);
  h.at(0, 0, false, -4), h.at(0, 0, true, -4);
  h.at(46, -1.5, true, -4), h.at(46, -1.5, false, -4);
  const auto* deep = h.last<InSpace>();
  ASSERT_NE(deep, nullptr) << h.done.size() << " acts, " << h.out.events.size() << " events, " << h.out.all.size()
                           << " presses missed";
  const auto* s = std::get_if<Suture>(&deep->act);
  ASSERT_NE(s, nullptr);
  EXPECT_EQ(s->side_a, HeldSide::bed);
  EXPECT_EQ(s->side_b, HeldSide::under);
  ASSERT_EQ(deep->z_mm.size(), 2u);
  EXPECT_NEAR(deep->z_mm[0], -4.2, 0.01) << "in its tissue, below the face";
  EXPECT_NEAR(deep->z_mm[1], -3.8, 0.01) << "in its tissue, above the face";
  // Skin on both sides: a stitch like any other.
  h.at(-5, 9, false), h.at(-5, 9, true), h.at(5, 9, true), h.at(5, 9, false);
  EXPECT_NE(h.last<Suture>(), nullptr);
}

TEST(HandTools, ARowThatIsTakenAgainBeginsAnewAndASliderGoesOnWithIt) {
  Hand h(slit());
  h.choose(Tool::suture_row, 0, 3);
  h.draw(-3, -20, -3, 20);
  h.choose(Tool::suture_row, 0, 3);  // another row
  h.draw(-3, 0, -3, 20);
  EXPECT_EQ(h.last<SutureRow>(), nullptr) << "an edge of the row before was taken for one of this";
  EXPECT_EQ(h.builder.dropped(), 1);
  h.choose(Tool::suture_row, 0, 2);  // nearer to each other
  h.draw(3, 0, 3, 20);
  const auto* row = h.last<SutureRow>();
  ASSERT_NE(row, nullptr);
  EXPECT_EQ(row->spacing_mm, 2);
  EXPECT_NEAR(row->a.front().y(), 0, 0.5);
}

TEST(HandTools, OfTwoSheetsAPressMeansTheOneThatIsExactlyNearest) {
  // A bed of large triangles at 0, and above it a leaf at 1.2 whose corners lie nearer to the tip than the bed's.
  auto t = std::make_shared<SurfaceTopology>(*flat_topology(12, 1));
  SurfaceView& view = t->view;
  const auto n = int32_t(view.X_mm.size());
  for (const Vec3& X : {Vec3(1, 1, 1.2), Vec3(2, 1, 1.2), Vec3(1, 2, 1.2)}) view.X_mm.push_back(X);
  view.tri.push_back({n, n + 1, n + 2}), view.kind.push_back(FaceKind::skin);
  if (!view.rim.empty()) view.rim.push_back(0);
  const Snapshot s = snapshot_of(t);
  SurfaceIndex index;
  index.another(s);
  const Vec3 tip(1.2, 1.2, 0.4);
  EXPECT_GT(index.closest(s, tip, -1).distance_mm, 0.5) << "by the nearest vertex: the leaf";
  EXPECT_NEAR(index.closest_of_all(s, tip).distance_mm, 0.4, 1e-6);
  // The other side of a stitch that began on the bed: of the leaf and a large sheet at 0.9, the sheet.
  auto three = std::make_shared<SurfaceTopology>(*t);
  const auto m = int32_t(three->view.X_mm.size());
  for (const Vec3& X : {Vec3(-30, -30, 0.9), Vec3(30, -30, 0.9), Vec3(0, 40, 0.9)}) three->view.X_mm.push_back(X);
  three->view.tri.push_back({m, m + 1, m + 2}), three->view.kind.push_back(FaceKind::skin);
  three->version = 2;
  const Snapshot with_sheet = snapshot_of(three);
  SurfaceIndex of_three;
  of_three.another(with_sheet);
  const Vec3 above(1.2, 1.2, 0.5);
  const SkinTouch bed = of_three.closest(with_sheet, Vec3(0, 0, 0), -1);
  EXPECT_NEAR(of_three.closest_apart(with_sheet, above, bed, 1.5).distance_mm, 0.7, 1e-6);
  EXPECT_NEAR(of_three.closest_apart(with_sheet, above, bed, 1.5, true).distance_mm, 0.4, 1e-6);
  EXPECT_EQ(of_three.closest_apart(with_sheet, above, bed, 0.3, true).triangle, -1);
  // Against every triangle, from many places.
  for (int i = 0; i < 200; ++i) {
    const Vec3 p(0.37 * (i % 17) - 3, 0.41 * (i % 13) - 2, 0.09 * (i % 19));
    double least = 1e9;
    for (const Tri& k : view.tri)
      least = std::min(
          least,
          (closest_on_triangle(p, view.X_mm[size_t(k[0])], view.X_mm[size_t(k[1])], view.X_mm[size_t(k[2])]).point - p)
              .norm());
    EXPECT_NEAR(index.closest_of_all(s, p).distance_mm, least, 1e-5) << p.transpose();
  }
}

TEST(HandTools, AHookIsTakenOutWhereItHoldsAndAtItsHandle) {
  Hand h(slit());
  h.s.hooks.push_back({1, Vec3f(10, 0, 0), Vec3f(20, 0, 15), Vec3f::Zero()});
  h.s.hooks.push_back({2, Vec3f(-10, 0, 0), Vec3f(-20, 0, 15), Vec3f::Zero()});
  h.choose(Tool::hook_out);
  h.at(10, 1, false), h.at(10, 1, true), h.at(10, 1, false);
  ASSERT_NE(h.last<ReleaseHook>(), nullptr);
  EXPECT_EQ(h.last<ReleaseHook>()->id, 1);
  h.at(-20, 0, false, 16), h.at(-20, 0, true, 16), h.at(-20, 0, false, 16);
  EXPECT_EQ(h.last<ReleaseHook>()->id, 2);
  EXPECT_TRUE(h.out.all.empty());
  h.at(30, 30, false), h.at(30, 30, true), h.at(30, 30, false);
  ASSERT_EQ(h.out.all.size(), 1u);
  EXPECT_EQ(h.out.all[0].kind, MissedPress::no_hook);
  EXPECT_EQ(h.done.size(), 2u);
}

TEST(HandTools, ScissorsCutAThreadElseTissueFromAnEdge) {
  Hand h(slit());
  h.s.sutures.push_back({7, Vec3f(-3, 20, 0), Vec3f(3, 20, 0)});
  h.choose(Tool::scissors, 3);
  h.at(4, 20, false), h.at(4, 20, true), h.at(4, 20, false);
  EXPECT_NE(h.last<CutSuture>(), nullptr);
  h.draw(3, 0, 15, 0);
  const auto* cut = h.last<Incise>();
  ASSERT_NE(cut, nullptr);
  EXPECT_EQ(cut->depth_mm, 3);
  EXPECT_EQ(cut->angle_deg, 90);
  EXPECT_NEAR((cut->path.back() - ChartPoint(15, 0)).norm(), 0, 0.3);
  EXPECT_TRUE(h.out.all.empty());
  h.draw(30, 0, 40, 0);  // in the middle of the skin
  ASSERT_EQ(h.out.all.size(), 1u);
  EXPECT_EQ(h.out.all[0].kind, MissedPress::no_edge);
  EXPECT_EQ(h.done.size(), 2u);
}

TEST(HandTools, ThePenMarksAndTheSwabWipes) {
  Hand h(slit());
  h.choose(Tool::marker);
  h.draw(10, -10, 10, 10);
  ASSERT_NE(h.last<Mark>(), nullptr);
  EXPECT_FALSE(h.last<Mark>()->wipes);
  EXPECT_NEAR((h.last<Mark>()->path.back() - h.last<Mark>()->path.front()).norm(), 20, 0.5);
  h.choose(Tool::swab);
  h.draw(5, 0, 15, 0);
  ASSERT_NE(h.last<Mark>(), nullptr);
  EXPECT_TRUE(h.last<Mark>()->wipes);
  h.at(0, 0, false, 0), h.at(0, 0, true), h.at(0, 0, false);  // into the wound: that is what a swab is for
  h.at(0, 0, true, 30), h.at(0, 0, false, 30);
  EXPECT_TRUE(h.out.all.empty());
}

TEST(HandTools, AMarkIsWrittenInAScriptAndReadAgain) {
  Mark drawn;
  drawn.path = {{1, 2}, {3, 4}}, drawn.wipes = true;
  const Command again = parse_command(to_json_line(Command(drawn)), "a script", 1);
  const auto* m = std::get_if<Mark>(&again);
  ASSERT_NE(m, nullptr);
  EXPECT_TRUE(m->wipes);
  EXPECT_EQ(m->path.size(), 2u);
}

}  // namespace test_hand_tools
}  // namespace limberg
