// What the window keeps of a session beside the patient: the list of acts, and what the pen has drawn.
#include <gtest/gtest.h>

#include "app/pictures/pen_sheet.h"
#include "app/window/act_history.h"
#include "tests/devices/flat_patient.h"

namespace limberg {
namespace test_desk_parts {

Notice of(int32_t kind, const Command& c = Undo{}, const std::string& words = "") {
  Notice n;
  n.kind = kind, n.command = std::make_shared<const Command>(c);
  Notice::put(n.text, words);
  return n;
}

TEST(ActHistory, GoesBackAndForthAndForgetsWhatAnotherActReplaces) {
  ActHistory h;
  h.hear(of(Notice::done, Incise{}, "first"));
  h.hear(of(Notice::done, SetHook{}, "a hook is no entry"));
  h.hear(of(Notice::done, Stage{"cut"}));
  h.hear(of(Notice::done, Mark{}));
  h.hear(of(Notice::refused, Incise{}));
  h.hear(of(Notice::done, Excise{}, "second"));
  h.hear(of(Notice::done, Suture{}, "third"));
  ASSERT_EQ(h.entries().size(), 3u);
  h.hear(of(Notice::undone)), h.hear(of(Notice::undone));
  EXPECT_EQ(h.standing(), 1u);
  EXPECT_EQ(h.entries().size(), 3u);
  h.hear(of(Notice::redone));
  EXPECT_EQ(h.standing(), 2u);
  h.hear(of(Notice::done, Suture{}, "another"));
  ASSERT_EQ(h.entries().size(), 3u);
  EXPECT_EQ(h.entries()[1].text, "second");
  EXPECT_EQ(h.entries()[2].text, "another");
  EXPECT_EQ(h.standing(), 3u);
}

TEST(ActHistory, PiecesOfAStrokeAreOneAct) {
  ActHistory h;
  InciseMore piece;
  for (const int stroke : {1, 1, 1, 2}) piece.stroke = stroke, h.hear(of(Notice::done, piece));
  EXPECT_EQ(h.entries().size(), 2u);
  EXPECT_EQ(h.standing(), 2u);
}

TEST(ActHistory, WantsAPictureAtOnceAndOneAtRest) {
  ActHistory h;
  ASSERT_EQ(h.unseen(true), &h.start());  // before the first act too
  h.unseen(true)->taken = 2;
  EXPECT_EQ(h.unseen(true), nullptr);
  h.hear(of(Notice::done, Incise{}));
  ASSERT_NE(h.unseen(false), nullptr);
  h.unseen(false)->taken = 1;
  EXPECT_EQ(h.unseen(false), nullptr);
  ASSERT_NE(h.unseen(true), nullptr);
  h.unseen(true)->taken = 2;
  EXPECT_EQ(h.unseen(true), nullptr);
}

TEST(Thumbnail, KeepsTheMiddleAndTheMeanColour) {
  Image image(200, 100, {10, 20, 30});
  for (int y = 0; y < 100; ++y)
    for (int x = 100; x < 200; ++x) image.set(x, y, {210, 120, 130});
  const Image small = thumbnail(image, 0, 0, 200, 100, 20, 20);
  ASSERT_EQ(small.width, 20);
  EXPECT_EQ(small.at(4, 10), (Rgb8{10, 20, 30}));
  EXPECT_EQ(small.at(15, 10), (Rgb8{210, 120, 130}));
}

TEST(PenSheet, ALineIsMeasuredAsTheSkinLiesAndAtRest) {
  const auto topology = test::flat_topology(60, 1);
  const Snapshot stretched = test::snapshot_of(topology, [](const Vec3& X) { return Vec3(1.5 * X.x(), X.y(), 0); });
  PenSheet pen;
  pen.hear(Mark{{{-10, 3}, {10, 3}}, false});
  pen.hear(Mark{{{0, 20}}, false});  // a dot
  pen.draw(stretched, {});
  ASSERT_EQ(pen.lengths().size(), 1u);
  EXPECT_EQ(pen.lengths()[0].text, "30.0 mm (20.0 at rest)");
  EXPECT_NEAR(pen.lengths()[0].at_mm.x(), 15, 0.1);
  EXPECT_FALSE(pen.props().vertex.empty());
  pen.draw(test::snapshot_of(topology), {});
  EXPECT_EQ(pen.lengths()[0].text, "20.0 mm");
}

TEST(PenSheet, OnSkinThatSlopesALineIsAsLongAsTheSkinUnderIt) {
  const auto topology = test::flat_topology(60, 1);
  for (Vec3& X : topology->view.X_mm) X.z() = X.x();
  PenSheet pen;
  pen.hear(Mark{{{-10, 3}, {10, 3}}, false});  // 20 mm on the chart
  pen.draw(test::snapshot_of(topology), {});
  ASSERT_EQ(pen.lengths().size(), 1u);
  EXPECT_EQ(pen.lengths()[0].text, "28.3 mm");
}

TEST(PenSheet, ASwabWipesOffWhatItPasses) {
  const Snapshot flat = test::snapshot_of(test::flat_topology(60, 1));
  PenSheet pen;
  const auto left = [&](const std::vector<Command>& acts) {
    for (const Command& c : acts) pen.hear(c);
    pen.draw(flat, {});
    return pen.lines();
  };
  EXPECT_EQ(
      left({Mark{{{-10, 0}, {10, 0}}, false}, Mark{{{-10, 12}, {10, 12}}, false}, Mark{{{0, 30}}, false}, Incise{}}),
      3u);
  EXPECT_EQ(left({Mark{{{0, -20}, {0, -5}}, true}}), 3u) << "too far from each";
  EXPECT_EQ(left({Mark{{{4, -3}, {4, 3}}, true}}), 2u);
  EXPECT_EQ(left({Mark{{{1, 29}}, true}}), 1u);
  EXPECT_EQ(left({Mark{{{-10, 20}, {10, 20}}, false}, Mark{{{0, 20}}, true}}), 1u) << "both before it is drawn";
}

TEST(PenSheet, ALineStaysOverAHoleAndComesBackWithTheSkin) {
  const auto whole = test::flat_topology(60, 1);
  const auto hole = test::flat_topology(60, 2, [](double x, double y) { return std::abs(x) < 5 && std::abs(y) < 5; });
  PenSheet pen;
  pen.hear(Mark{{{-10, 0}, {10, 0}}, false});
  pen.draw(test::snapshot_of(whole), {});
  EXPECT_EQ(pen.lengths()[0].text, "20.0 mm");
  pen.draw(test::snapshot_of(hole), {});
  const double left_mm = std::stod(pen.lengths().at(0).text);
  EXPECT_NEAR(left_mm, 12, 1.2) << "of cells of 2 mm four are gone; at each border a step of .6 mm";
  pen.draw(test::snapshot_of(test::flat_topology(60, 3)), {});
  EXPECT_EQ(pen.lengths()[0].text, "20.0 mm");
}

TEST(PenSheet, TheWayOfAStrokeIsSeenWhileItIsDrawn) {
  const Snapshot s = test::snapshot_of(test::flat_topology(60, 1));
  PenSheet pen;
  ToolState hand;
  hand.valid = 1;
  const auto led = [&](Tool tool, double from, double to, bool pressed) {
    hand.tool = int32_t(tool), hand.pressed = pressed;
    for (double x = from; x <= to; x += 1) hand.tip_mm[0] = x, pen.follow(hand);
    pen.draw(s, {});
    return pen.trail();
  };
  for (const Tool tool : {Tool::excise, Tool::undermine, Tool::scalpel, Tool::saw}) {
    EXPECT_EQ(led(tool, -10, 0, false), 0u) << "in the air";
    EXPECT_GT(led(tool, 0, 20, true), 15u);
    EXPECT_FALSE(pen.props().vertex.empty());
    EXPECT_EQ(led(tool, 20, 21, false), 0u) << "what was drawn is an act by now";
  }
  EXPECT_EQ(led(Tool::suture, 0, 20, true), 0u) << "a stitch goes from place to place";
  // Of a row the first edge is seen until the second was drawn along it.
  led(Tool::suture_row, 0, 0, false);
  const size_t first = led(Tool::suture_row, 0, 20, true);
  EXPECT_EQ(led(Tool::suture_row, 20, 30, false), first);
  EXPECT_EQ(led(Tool::none, 20, 30, false), first);
  EXPECT_GT(led(Tool::suture_row, 0, 20, true), first);
  EXPECT_EQ(led(Tool::suture_row, 20, 21, false), 0u);
  // It is given up as soon as something else is done.
  led(Tool::suture_row, 0, 20, true), led(Tool::suture_row, 20, 21, false);
  EXPECT_GT(pen.trail(), 0u);
  pen.hear(Shown{true});
  EXPECT_EQ(pen.trail(), 0u);
}

}  // namespace test_desk_parts
}  // namespace limberg
