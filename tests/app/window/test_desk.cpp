// The window drawn into memory: what keys, clicks and the session's news do to the picture and to the feed.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "app/window/waiting.h"
#include "sim/commands/actions.h"
#include "tests/app/window/drawn_window.h"
#include "tests/render/sample_snapshot.h"

namespace limberg {
namespace test_desk {

struct Window : testing::DrawnWindow {
  LaneGauges gauges;

  Window() : DrawnWindow(testing::sample_snapshot()) {
    WindowSettings set;
    set.facts = {"rhomboid", "mouse", "", "Close the defect.", false, true, 9};
    set.camera.eye_mm = {5, -90, 130};
    open(set, &gauges);
  }
  void move(float x, float y) {
    WindowEvent e;
    e.x = x, e.y = y;
    router.take(e);
  }
  void button(int32_t which, bool down) {
    WindowEvent e;
    e.kind = WindowEvent::button, e.code = which, e.down = down;
    router.take(e);
  }
  int choices(std::vector<ControlSample>& out) {
    for (HandInput i; feed.input.pop(i);)
      if (const auto* c = std::get_if<ControlSample>(&i))
        out.push_back(*c);
      else if (const auto* p = std::get_if<PointerReading>(&i))
        presses += p->pressed;
    return int(out.size());
  }
  int presses = 0;  // of the mouse on the patient, in what choices() has read
  View sight() {
    feed.seen.update();
    return feed.seen.reading().view;
  }
  bool on_panel(float x, float y) {
    feed.seen.update();
    return feed.seen.reading().on_panel(x, y);
  }
};

// Pixels that differ by more than so many of 255 levels, of a part of the frame.
int different(const Image& a, const Image& b, int x0, int y0, int x1, int y1, int levels = 0) {
  int n = 0;
  for (int y = y0; y < y1; ++y)
    for (int x = x0; x < x1; ++x) {
      const Rgb8 p = a.at(x, y), q = b.at(x, y);
      n += std::max({std::abs(p.r - q.r), std::abs(p.g - q.g), std::abs(p.b - q.b)}) > levels;
    }
  return n;
}

class DeskTest : public ::testing::Test {
 protected:
  void SetUp() override {
    try {
      make_osmesa_context();
    } catch (const RenderUnavailable&) {
      GTEST_SKIP() << "no OSMesa here";
    }
  }
};

TEST_F(DeskTest, KeysChooseToolsAndTheFeedHearsIt) {
  Window w;
  std::vector<ControlSample> c;
  w.key('2');
  ASSERT_EQ(w.choices(c), 1);
  EXPECT_EQ(c[0].kind, ControlSample::select_tool);
  EXPECT_EQ(c[0].tool, Tool::scalpel);
  EXPECT_EQ(c[0].value[kDepth], 4);
  EXPECT_EQ(c[0].value[kAngle], 90);
  w.key('2');
  EXPECT_EQ(w.choices(c), 1);  // chosen already
  w.key('Z', WindowEvent::control);
  w.key('Y', WindowEvent::control);
  w.key('5');
  ASSERT_EQ(w.choices(c), 4);
  EXPECT_EQ(c[1].kind, ControlSample::undo);
  EXPECT_EQ(c[2].kind, ControlSample::redo);
  EXPECT_EQ(c[3].tool, Tool::hook);
}

TEST_F(DeskTest, SpaceIsTheClutchWhileItIsHeld) {
  Window w;
  std::vector<ControlSample> c;
  WindowEvent e;
  e.kind = WindowEvent::key, e.code = WindowEvent::space, e.down = 1;
  for (int i = 0; i < 3; ++i) w.router.take(e), w.settle();  // a held key repeats
  ASSERT_EQ(w.choices(c), 1);
  EXPECT_EQ(c[0].kind, ControlSample::clutch);
  EXPECT_EQ(c[0].value[0], 1);
  e.down = 0;
  w.router.take(e), w.settle();
  ASSERT_EQ(w.choices(c), 2);
  EXPECT_EQ(c[1].kind, ControlSample::clutch);
  EXPECT_EQ(c[1].value[0], 0);
}

TEST_F(DeskTest, TheGloveIsDrawnWhereItIs) {
  Window w;
  w.key('S'), w.key('S');  // one quality, whatever the machine's speed
  const Image none = w.frames->picture();
  SecondHand hand;
  hand.forefinger_mm[2] = 14, hand.thumb_mm[1] = -10, hand.thumb_mm[2] = 14;
  hand.pointing[0] = 0, hand.pointing[2] = -1, hand.points = 1;
  w.frames->second_hand(hand, {});
  w.settle();
  EXPECT_EQ(different(none, w.frames->picture(), 200, 0, 1000, 600), 0) << "there is no glove";
  hand.valid = 1;
  w.frames->second_hand(hand, {});
  w.settle();
  const Vec3f p = w.sight().to_pixel(Vec3f(0, 0, 14), w.screen.width, w.screen.height);
  const int x = int(p.x()), y = int(p.y());
  const Image glove = w.frames->picture();
  EXPECT_GT(different(none, glove, x - 12, y - 12, x + 12, y + 12, 20), 100);
  EXPECT_EQ(different(none, glove, 200, 450, 400, 600), 0);
  const int64_t before = w.frames->patient_drawn();
  hand.forefinger_mm[0] += 1;
  w.frames->second_hand(hand, {});
  w.settle();
  EXPECT_GT(w.frames->patient_drawn(), before) << "it has moved";
}

TEST_F(DeskTest, AClickOnThePaletteDoesNotReachThePatient) {
  Window w;
  w.move(60, 78);  // on the second row of the tools
  w.settle();
  EXPECT_TRUE(w.on_panel(60, 78));
  w.button(0, true), w.button(0, false);
  w.move(640, 300), w.button(0, true), w.button(0, false);  // at once on the patient
  std::vector<ControlSample> c;
  EXPECT_EQ(w.choices(c), 0) << "the panels have not answered";
  EXPECT_EQ(w.presses, 0);
  w.settle();
  ASSERT_EQ(w.choices(c), 1);
  EXPECT_EQ(c[0].kind, ControlSample::select_tool);
  EXPECT_NE(c[0].tool, Tool::none);
  EXPECT_EQ(w.presses, 1) << "the second click, and it alone";
  EXPECT_FALSE(w.on_panel(640, 300));
}

TEST_F(DeskTest, TheHelpCoversThePatientWhereItIsSeen) {
  Window w;
  EXPECT_FALSE(w.on_panel(640, 360));
  w.key(WindowEvent::f1);
  EXPECT_TRUE(w.on_panel(640, 360));
  std::vector<ControlSample> c;
  w.move(640, 360), w.button(0, true), w.settle(), w.button(0, false), w.settle();
  w.choices(c);
  EXPECT_EQ(w.presses, 0);
  w.key(WindowEvent::escape);  // closes it
  EXPECT_FALSE(w.on_panel(640, 360));
  EXPECT_EQ(w.choices(c), 0);
}

TEST_F(DeskTest, EveryToolHasItsKeyItsRowInThePaletteAndItsWordInTheHelp) {
  Window w;
  std::string help;
  for (const DeskKey& k : desk_keys())
    help += std::string(k.hand == HandKey::tool ? tools_in_words({}) : k.what) + "\n";
  std::vector<ControlSample> by_key;
  for (const DeskTool& t : kDeskTools) {
    std::string name = t.name;
    name[0] = char(name[0] - 'A' + 'a');
    EXPECT_NE(help.find(name), std::string::npos) << name;
    w.key(t.key, t.shift ? WindowEvent::shift : 0);
    w.choices(by_key);
    if (t.tool == Tool::none) continue;  // as at first
    ASSERT_FALSE(by_key.empty());
    EXPECT_EQ(by_key.back().tool, t.tool) << t.name;
  }
  EXPECT_EQ(by_key.size(), kDeskTools.size() - 1);
  EXPECT_EQ(by_key.back().tool, Tool::scissors);
  // Down the palette, row by row: every tool for skin, each once.
  std::vector<ControlSample> by_row;
  for (float y = 50; y < 392; y += 5) {
    w.move(60, y), w.button(0, true), w.button(0, false), w.settle(), w.settle();
    w.choices(by_row);
  }
  std::vector<Tool> rows;
  for (const ControlSample& c : by_row)
    if (c.kind == ControlSample::select_tool && (rows.empty() || rows.back() != c.tool)) rows.push_back(c.tool);
  std::vector<Tool> wanted;
  for (const DeskTool& t : kDeskTools)
    if (!acts_on_bone(t.tool)) wanted.push_back(t.tool);
  EXPECT_EQ(rows, wanted);
}

TEST(ToolSliders, AreThoseOfTheTableOfActs) {
  const auto names = [](Tool tool) {
    std::string s;
    for (const ToolSlider& k : tool_sliders(tool, 9)) s += k.name + " ";
    return s;
  };
  EXPECT_EQ(names(Tool::scalpel), "depth angle ");
  EXPECT_EQ(names(Tool::undermine), "depth ");
  EXPECT_EQ(names(Tool::excise), "depth ");
  EXPECT_EQ(names(Tool::suture_row), "spacing ");
  EXPECT_EQ(names(Tool::suture_running), "spacing ");
  for (const Tool tool : {Tool::suture_buried, Tool::suture_corner, Tool::scissors})
    EXPECT_EQ(names(tool), "depth ") << int(tool);
  for (const Tool tool :
       {Tool::none, Tool::hook, Tool::suture, Tool::saw, Tool::grab, Tool::hook_out, Tool::marker, Tool::swab})
    EXPECT_EQ(names(tool), "") << int(tool);
  const ActionField &angle = action_field("incise", "angle_deg"), &spacing = action_field("suture_row", "spacing_mm");
  const ToolSlider of_angle = tool_sliders(Tool::scalpel, 9)[1], of_spacing = tool_sliders(Tool::suture_row, 9)[0],
                   of_depth = tool_sliders(Tool::scalpel, 7.5)[0];
  EXPECT_EQ(of_angle.from, float(angle.field.usual_from));
  EXPECT_EQ(of_angle.to, float(angle.field.usual_to));
  EXPECT_EQ(of_angle.help, angle.field.help);
  EXPECT_EQ(of_angle.format, "%.0f\u00b0");
  EXPECT_EQ(of_spacing.to, float(spacing.field.usual_to));
  EXPECT_EQ(of_spacing.format, "%.1f\u202fmm");
  EXPECT_EQ(of_depth.to, 7.5f) << "the scene allows no more";
  HandChoice hand;
  hand.*of_spacing.value = 6;
  EXPECT_EQ(hand.spacing_mm, 6);
}

TEST_F(DeskTest, TheRightButtonTurnsAndHomeComesBack) {
  Window w;
  const Vec3f start = w.sight().eye_mm;
  w.move(640, 300), w.button(1, true), w.settle();
  w.move(700, 330), w.settle();
  w.button(1, false), w.settle();
  EXPECT_GT((w.sight().eye_mm - start).norm(), 10);
  w.move(100, 100), w.settle();
  const Vec3f turned = w.sight().eye_mm;
  w.move(500, 500), w.settle();
  EXPECT_EQ(w.sight().eye_mm, turned);  // let go
  w.key(WindowEvent::home);
  EXPECT_EQ(w.sight().eye_mm, start);
}

TEST_F(DeskTest, NothingIsDrawnWhenNothingHappens) {
  Window w;
  int wanted = 0;
  for (int i = 0; i < 100; ++i) {
    const bool draw = w.frames->wants_frame();
    wanted += draw;
    if (draw) w.frames->frame(w.s, ToolState{});
  }
  EXPECT_LE(wanted, 100 / 15 + 2);  // the figures on the panels, twice a second, and once the finer picture
  EXPECT_LE(w.frames->patient_drawn(), 3);
  const int64_t before = w.frames->patient_drawn();
  w.gauges.tick = 5000;
  w.settle();
  EXPECT_EQ(w.frames->patient_drawn(), before);  // panels only
  for (Vec3f& x : w.s.x_mm) x.z() += 0.005f;
  w.settle();
  EXPECT_EQ(w.frames->patient_drawn(), before);  // cannot be seen
  for (Vec3f& x : w.s.x_mm) x.z() += 0.1f;
  w.settle();
  EXPECT_EQ(w.frames->patient_drawn(), before + 1);
}

TEST_F(DeskTest, EveryFieldHasItsColoursAndLegendAndCostsNothingWhenOff) {
  Window w;
  w.key('S'), w.key('S');  // one quality, whatever the machine's speed
  for (Vec3f& x : w.s.x_mm) x.x() *= 1.03f, x.z() += 0.05f * x.y();
  w.settle();
  const Image plain = w.frames->picture();
  std::vector<Image> seen{plain};
  for (int k = 1; k < kSkinFields; ++k) {
    w.key('V');
    const Image image = w.frames->picture();
    EXPECT_GT(different(plain, image, 300, 150, 800, 500, 20), 20000) << k;  // the skin
    EXPECT_GT(different(seen.back(), image, 890, 115, 1010, 200), 50) << k;  // the legend's words
    seen.push_back(image);
  }
  w.key('V');
  EXPECT_EQ(different(plain, w.frames->picture(), 0, 0, 1280, 600), 0);  // off again
  EXPECT_FALSE(w.frames->wants_field());                                 // the solver is not asked for any of it
  EXPECT_FALSE(w.frames->wants_lattice());
}

TEST_F(DeskTest, TheLatticeIsDrawnWithItsCopies) {
  Window w;
  const Image plain = w.frames->picture();
  w.key('X');
  EXPECT_TRUE(w.frames->wants_lattice());
  LatticeShown l;
  l.edges = std::make_shared<std::vector<LatticeShown::Edge>>(
      std::vector<LatticeShown::Edge>{{0, 1, false}, {2, 3, true}, {0, 99, true}});  // the last has no node: left out
  l.node_mm = {Vec3f(-20, 15, 2), Vec3f(20, 15, 2), Vec3f(-20, -15, 2), Vec3f(20, -15, 2)};
  w.frames->lattice(l);
  w.settle();
  const Image with = w.frames->picture();
  int orange = 0;
  for (int y = 0; y < 600; ++y)
    for (int x = 180; x < 1000; ++x) {
      const Rgb8 p = plain.at(x, y), q = with.at(x, y);
      orange += q.r >= p.r && q.b + 60 < p.b;
    }
  EXPECT_GT(orange, 100);
  EXPECT_GT(different(plain, with, 180, 0, 1000, 600, 40), 300);
}

TEST_F(DeskTest, ASilentOrUncalibratedDeviceIsSaid) {
  testing::MemoryScreen screen;
  HandFeed feed;
  LaneGauges gauges;
  const Snapshot s = testing::sample_snapshot();
  const auto device_panel = [&](bool own, bool calibrated, int samples) {
    WindowSettings set;
    set.facts.scene = "rhomboid", set.facts.device = "fastrak", set.facts.own_device = own,
    set.facts.calibrated = calibrated;
    set.camera.eye_mm = {5, -90, 130};
    WindowFrames f(screen, feed, &gauges, set);
    f.prepare(*s.topology);
    gauges.tick = 0, gauges.samples = 0;
    f.frame(s, ToolState{});
    gauges.tick = 3000, gauges.samples = samples;
    f.frame(s, ToolState{});
    f.frame(s, ToolState{});
    return f.picture();
  };
  const auto amber = [](const Image& image) {  // letters of a warning
    int n = 0;
    for (int y = 300; y < 720; ++y)
      for (int x = 0; x < 168; ++x) {
        const Rgb8 c = image.at(x, y);
        n += c.r > 200 && c.g > 120 && c.g < 200 && c.b < 130;
      }
    return n;
  };
  EXPECT_LT(amber(device_panel(false, false, 0)), 5);  // the mouse needs neither
  EXPECT_LT(amber(device_panel(true, true, 180)), 5);
  const int uncalibrated = amber(device_panel(true, false, 180)), silent = amber(device_panel(true, true, 0));
  EXPECT_GT(uncalibrated, 100);
  EXPECT_GT(silent, 100);
}

TEST_F(DeskTest, AFirstWordIsSeenUntilSomethingIsDone) {
  testing::MemoryScreen screen;
  HandFeed feed;
  LaneGauges gauges;
  const Snapshot s = testing::sample_snapshot();
  const auto frames = [&](const std::string& word) {
    WindowSettings set;
    set.facts.scene = "rhomboid", set.facts.word = word;
    set.camera.eye_mm = {5, -90, 130};
    auto f = std::make_unique<WindowFrames>(screen, feed, &gauges, set);
    f->prepare(*s.topology);
    for (int i = 0; i < 3; ++i) f->frame(s, ToolState{});
    return f;
  };
  const Image silent = frames("")->picture();
  const auto said = frames("out/a.lcm: a session that was cut off after 12.3 s");
  EXPECT_GT(different(silent, said->picture(), 400, 560, 900, 640), 300);
  said->notice(Notice{});
  for (int i = 0; i < 3; ++i) said->frame(s, ToolState{});
  EXPECT_LT(different(silent, said->picture(), 400, 560, 900, 640, 20), 50);
}

TEST_F(DeskTest, HelpAndRefusalsAreSeen) {
  Window w;
  const Image plain = w.frames->picture();
  ASSERT_EQ(plain.width, 1280);
  w.key(WindowEvent::f1);
  const Image help = w.frames->picture();
  EXPECT_GT(different(plain, help, 450, 200, 830, 500), 20000);
  w.key(WindowEvent::escape);
  EXPECT_EQ(different(plain, w.frames->picture(), 300, 100, 900, 550), 0);
  Notice n;
  n.kind = Notice::refused, n.t_s = 3;
  Notice::put(n.action, "incise"), Notice::put(n.text, "depth 10 mm is deeper than the scene allows");
  w.frames->notice(n);
  w.settle();
  EXPECT_GT(different(plain, w.frames->picture(), 1020, 300, 1280, 720), 300);  // in the list
  EXPECT_GT(different(plain, w.frames->picture(), 400, 560, 900, 640), 300);    // as the last word
}

TEST_F(DeskTest, AWipeShowsBeforeOnItsLeft) {
  Window w;
  const Image before = w.frames->picture();
  for (Vec3f& x : w.s.x_mm) x.z() -= 3;
  w.settle();
  const Image now = w.frames->picture();
  // The stage lies between 168 and 1012; the wipe parts it at 590. Each half is drawn with a cropped frustum, whose
  // rounding and whose background shade differ a little.
  constexpr int kLevels = 24;
  const int moved_left = different(before, now, 170, 100, 580, 600, kLevels),
            moved_right = different(before, now, 600, 100, 1010, 600, kLevels);
  ASSERT_GT(std::min(moved_left, moved_right), 4000);
  w.key('B');
  const Image both = w.frames->picture();
  EXPECT_LT(different(before, both, 170, 100, 580, 600, kLevels), 0.1 * moved_left);
  EXPECT_GT(different(now, both, 170, 100, 580, 600, kLevels), 0.8 * moved_left);
  EXPECT_LT(different(now, both, 600, 100, 1010, 600, kLevels), 0.1 * moved_right);
  EXPECT_GT(different(before, both, 600, 100, 1010, 600, kLevels), 0.8 * moved_right);
}

TEST_F(DeskTest, AnaglyphIsOfThePatientAlone) {
  Window w;
  const Image plain = w.frames->picture();
  w.key('A'), w.key('A');
  const Image stereo = w.frames->picture();
  EXPECT_GT(different(plain, stereo, 200, 100, 1000, 600), 50000);
  EXPECT_EQ(different(plain, stereo, 2, 560, 160, 600), 0);  // panels are not doubled
}

// Rows and columns of a picture that are not all of one colour; the corner's is the paper's.
std::array<int, 4> written(const Image& a) {
  std::array<int, 4> box{a.width, a.height, -1, -1};
  for (int y = 0; y < a.height; ++y)
    for (int x = 0; x < a.width; ++x)
      if (!(a.at(x, y) == a.at(0, 0)))
        box = {std::min(box[0], x), std::min(box[1], y), std::max(box[2], x), std::max(box[3], y)};
  return box;
}

TEST_F(DeskTest, UntilThereIsAPatientTheWindowSaysWhatIsMade) {
  testing::MemoryScreen screen;
  for (const auto& [width, height] : {std::pair{1280, 720}, {640, 480}, {3840, 2160}}) {
    screen.width = width, screen.height = height;
    const Image head = show_words(screen, "Making the head ..."), nothing = show_words(screen, "");
    ASSERT_EQ(head.width, width);
    ASSERT_EQ(head.height, height);
    const auto [left, top, right, bottom] = written(head);
    ASSERT_GT(right, left);
    EXPECT_NEAR(0.5 * (left + right), 0.5 * width, 4);
    EXPECT_NEAR(0.5 * (top + bottom), 0.5 * height, 8);
    EXPECT_GT(bottom - top, height / 80);
    EXPECT_LT(right - left, width / 2);
    EXPECT_LT(written(nothing)[2], 0);
  }
}

}  // namespace test_desk
}  // namespace limberg
