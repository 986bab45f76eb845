// A beginner's first minutes with the mouse and the keys alone, through everything that a session with a window has:
// the tour, errors, being shown, stitches, the summary. What is pressed goes the way of a real mouse (InputRouter,
// PointerSource). With LIMBERG_PICTURES=DIR in the environment every screen is drawn into files at two sizes, with
// LIMBERG_4K=1 at a third, and with LIMBERG_LANGUAGE=de in German.
#include <gtest/gtest.h>
#include <imgui_internal.h>

#include <cstdlib>
#include <functional>

#include "app/assembly/assembly.h"
#include "app/pictures/pictures.h"
#include "app/program/places.h"
#include "app/program/temporary_folder.h"
#include "app/session/lockstep.h"
#include "app/window/pointer_source.h"
#include "app/words/chosen_words.h"
#include "devices/skin_chart.h"
#include "sim/commands/script.h"
#include "tests/app/window/drawn_window.h"

namespace limberg {
namespace test_first_minutes {

using Path = std::vector<ChartPoint>;

/// One thing that the beginner does; called every millisecond with how long it has lasted, until it is over.
using Deed = std::function<bool(double t_s)>;

/// English, as the test reads it; pictures also in another language (LIMBERG_LANGUAGE).
Words shown_words() {
  const char* language = std::getenv("LIMBERG_PICTURES") ? std::getenv("LIMBERG_LANGUAGE") : nullptr;
  return language ? chosen_words({language, ""}).typeset() : Words();
}

class Walk final : testing::ShippedLesson, public Source, public PictureSink {
 public:
  Walk(const std::string& lesson_name, int width, int height, LessonMode mode = LessonMode::guided, bool tour = true)
      : ShippedLesson(lesson_name, shown_words()), name_(lesson_name) {
    WindowSettings set;
    set.facts.w = plan.w;
    set.facts.scene = scene.name, set.facts.device = "mouse", set.facts.goal = plan.goal;
    set.facts.head = scene.head.has_value(), set.facts.skin = scene.flesh;
    set.facts.max_depth_mm = scene.tools.max_depth_mm;
    set.camera = scene_camera(scene), set.lesson = plan, set.mode = mode;
    if (tour) set.memory_file = folder_.path().string() + "/window.toml";
    screen.width = width_ = width, screen.height = height_ = height;
    window = std::make_unique<WindowFrames>(screen, feed, &gauges, set);
    router.look_with([this](bool) { return seen_; });
    if (const char* dir = std::getenv("LIMBERG_PICTURES")) pictures_ = dir;
  }

  // What a beginner does.
  Walk& key(int32_t code, uint32_t mods = 0) {
    return add([=, this](double) { return testing::press_key(router, code, mods), true; }).rest(0.25);
  }
  Walk& rest(double s) {
    return add([s](double t) { return t > s; });
  }
  Walk& shoot(const std::string& what) {
    add([=, this](double) {
      if (pictures_.empty()) return true;
      if (shot_.empty()) return shot_ = what, false;
      if (shot_ != "done") return false;
      return shot_.clear(), true;
    });
    return *this;
  }
  /// In pixels of the window as it stands.
  Walk& to(std::function<Vec2()> where) {
    return add([=, this](double) { return move(where()), true; }).rest(0.3);
  }
  Walk& click(std::function<Vec2()> where) {
    return to(where)
        .add([this](double) { return button(true), true; })
        .rest(0.15)
        .add([this](double) { return button(false), true; })
        .rest(0.3);
  }
  /// The left button is held along a way on the skin; `shot` in its middle, when one is wanted.
  Walk& drag(Path way, bool closed = false, const std::string& shot = "") {
    if (closed) way.push_back(way.front());
    add([=, this](double) { return move(on_skin(way[0])), true; }).rest(0.3);
    add([this](double) { return button(true), true; }).rest(0.3);
    for (size_t i = 0; i + 1 < way.size(); ++i) {
      add([=, this](double t) {
        const double whole = std::max(0.15, (way[i + 1] - way[i]).norm() / 40);
        const double u = std::min(1.0, t / whole);
        if (int64_t(t * 1000) % 8 == 0 || u >= 1) move(on_skin(way[i] + u * (way[i + 1] - way[i])));
        return u >= 1;
      });
      rest(way.size() < 8 ? 0.45 : 0.02);
      if (!shot.empty() && i == way.size() / 2 - (way.size() > 2 ? 0 : 1)) shoot(shot);
    }
    rest(0.2);
    return add([this](double) { return button(false), true; }).rest(0.9);
  }
  Walk& until_shown(const std::string& shot = "") {
    if (!shot.empty()) rest(1.2).shoot(shot);
    return rest(0.3).add([this](double t) { return !feed.showing || t > 60; }).rest(1.2);
  }
  Walk& see(std::function<void()> look) {
    return add([=](double) { return look(), true; });
  }
  Walk& add(Deed d) { return deeds_.push_back(std::move(d)), *this; }

  /// Of a panel, in pixels from its corner in the panels' own units.
  Vec2 in_panel(const char* name, float x, float y) const {
    const ImGuiWindow* w = ImGui::FindWindowByName(name);
    if (!w) return {5, 5};
    const double scale = double(width_) / double(ImGui::GetIO().DisplaySize.x);
    return {scale * double(w->Pos.x + (x < 0 ? w->Size.x + x : x)), scale * double(w->Pos.y + y)};
  }
  Vec2 on_skin(const ChartPoint& c) {
    if (!seen_ || !seen_->topology) return {0, 0};
    if (!chart_.built_for(*seen_)) chart_.build(*seen_->topology);
    const SkinTouch t = chart_.at(*seen_, c, 4);
    feed_view();
    const Vec3f px =
        view_.to_pixel(t.triangle < 0 ? Vec3f(float(c.x()), float(c.y()), -2) : t.x_mm.cast<float>(), width_, height_);
    return {double(px.x()), double(px.y())};
  }
  const Coach& coach() const { return *window->coach(); }

  void run() {
    AssemblyOptions o;
    o.workers = 2, o.sink = this, o.draw_frames = true, o.progressive_cut = true;
    Assembly a(scene, Calibration{}, o);
    struct Borrowed final : Source {
      Walk& w;
      explicit Borrowed(Walk& x) : w(x) {}
      void look(const Snapshot& s) override { w.look(s); }
      void poll(int64_t now_ns, SampleSink& sink) override { w.poll(now_ns, sink); }
      bool done() const override { return w.done(); }
      SourceCounts counts() const override { return {0, 0, 0}; }
    };
    a.front.add(std::make_unique<Borrowed>(*this));
    SessionSettings s = a.session_settings();
    s.ticks_per_frame = 33, s.settle_steps = 0;
    run_lockstep(a.lanes(nullptr), s);
  }

  // Source.
  void look(const Snapshot& s) override { seen_ = &s, pointer_.look(s); }
  void poll(int64_t now_ns, SampleSink& sink) override {
    now_s_ = double(now_ns) * 1e-9;
    LaneGauges::set(gauges.tick, now_ns / 1'000'000);
    LaneGauges::set(gauges.solver_ns, 6'100'000), LaneGauges::set(gauges.device_ns, 12'000);
    LaneGauges::set(gauges.frame_ns, 21'000'000);
    if (next_ < deeds_.size()) {
      if (began_s_ < 0) began_s_ = now_s_;
      if (deeds_[next_](now_s_ - began_s_)) ++next_, began_s_ = -1;
    }
    router.pump(now_ns);
    pointer_.poll(now_ns, sink);
  }
  bool done() const override { return next_ == deeds_.size() && !feed.showing; }
  SourceCounts counts() const override { return {0, 0, 0}; }

  // PictureSink.
  void prepare(const SurfaceTopology& first) override { window->prepare(first); }
  void notice(const Notice& n) override { window->notice(n); }
  void missed(const MissedPress& m, const Snapshot& s) override { window->missed(m, s); }
  bool wants_frame() override { return true; }
  void stage(const std::string&, const Snapshot&) override {}
  void finish() override { window->finish(); }
  void frame(const Snapshot& s, const ToolState& t) override {
    const bool wanted = !shot_.empty() && shot_ != "done";
    if (!wanted && ++calls_ % 3 != 0) return;
    window->wants_frame();
    window->frame(s, t);
    if (!wanted) return;
    for (const auto& [w, h] : {std::pair{800, 600}, {1280, 720}, {3840, 2160}}) {
      if (w > 2000 && !std::getenv("LIMBERG_4K")) continue;
      screen.width = w, screen.height = h;
      for (int i = 0; i < 4; ++i) window->wants_frame(), window->frame(s, t);
      write_png(pictures_ + "/" + std::to_string(w) + "-" + name_ + "-" + std::to_string(1000 + shots_).substr(1) +
                    "-" + shot_ + ".png",
                window->picture());
    }
    screen.width = width_, screen.height = height_;
    for (int i = 0; i < 3; ++i) window->wants_frame(), window->frame(s, t);
    ++shots_, shot_ = "done";
  }

  using ShippedLesson::plan;
  testing::MemoryScreen screen;
  HandFeed feed;
  LaneGauges gauges;
  InputRouter router{screen, feed};
  std::unique_ptr<WindowFrames> window;

 private:
  void move(const Vec2& px) {
    WindowEvent e;
    e.x = float(px.x()), e.y = float(px.y());
    router.take(e);
  }
  void button(bool down) {
    WindowEvent e;
    e.kind = WindowEvent::button, e.code = 0, e.down = down;
    router.take(e);
  }
  void feed_view() {
    feed.seen.update();
    view_ = feed.seen.reading().view;
  }

  std::string name_, pictures_, shot_;
  TemporaryFolder folder_;
  PointerSource pointer_{feed};
  const Snapshot* seen_ = nullptr;
  SkinChart chart_;
  View view_;
  std::vector<Deed> deeds_;
  size_t next_ = 0;
  double began_s_ = -1, now_s_ = 0;
  int width_ = 0, height_ = 0, calls_ = 0, shots_ = 0;
};

/// Turned and stretched about its first point.
Path bent(Path p, double turn_deg, double by, size_t from = 1) {
  const double a = turn_deg * 3.14159265358979 / 180, c = std::cos(a), s = std::sin(a);
  for (size_t i = from; i < p.size(); ++i) {
    const Vec2 d = p[i] - p[0];
    p[i] = p[0] + by * Vec2(c * d.x() - s * d.y(), s * d.x() + c * d.y());
  }
  return p;
}

std::string all_said(const Coach& c) {
  std::string all;
  for (const Coach::Said& w : c.said()) all += "  " + std::to_string(w.t_s).substr(0, 5) + "  " + w.word + "\n";
  return all;
}

struct FirstMinutes : ::testing::TestWithParam<const char*> {
  void SetUp() override {
    try {
      make_osmesa_context();
    } catch (const RenderUnavailable&) {
      GTEST_SKIP() << "no OSMesa here";
    }
  }
};

/// In pictures alone: what a test need not wait for.
bool pictures_wanted() { return std::getenv("LIMBERG_PICTURES") != nullptr; }

TEST_P(FirstMinutes, WithTheMouse) {
  const std::string lesson = GetParam();
  if (lesson != "rhomboid" && !pictures_wanted()) GTEST_SKIP() << "drawn when pictures are wanted";
  Walk w(lesson, 1280, 720);
  const Excise defect = std::get<Excise>(w.plan.acts[0].command);
  const Incise flap = std::get<Incise>(w.plan.acts[1].command);
  const Undermine pocket = std::get<Undermine>(w.plan.acts[2].command);
  const auto tool_at = [&](int row) { return [&w, row] { return w.in_panel("tools", 60, 40 + 21 * float(row)); }; };
  const auto back = [&] { w.key('Z', WindowEvent::control).rest(0.5); };
  bool finished = false;
  w.rest(0.4).shoot("tour-1");
  for (int card = 2; card <= DeskTour::kCards; ++card)
    w.key(WindowEvent::enter).rest(0.2).shoot("tour-" + std::to_string(card));
  w.key(WindowEvent::enter).rest(0.5).shoot("begins");
  if (pictures_wanted()) {
    w.to(tool_at(2)).rest(0.6).shoot("tooltip");
    w.to(tool_at(30)).rest(16).shoot("hint").rest(32).shoot("hint-later");
  }
  // In a wrong order.
  w.key('3').drag(pocket.outline, true, "undermine-first-stroke").shoot("undermined-first");
  w.key('2').drag(flap.path, false, "flap-first-stroke").shoot("flap-first");
  back(), w.shoot("taken-back");
  w.key('4').drag(bent(defect.outline, 0, 1.02), true, "defect-stroke").shoot("defect");
  // The answer to a place that is asked for, with the knife in the hand: first as if it were to cut.
  if (lesson == "rhomboid") {
    w.drag({flap.path[0], flap.path[1]}).shoot("question-cut");
    w.click([&] { return w.on_skin(flap.path[0] + 3.0 * (flap.path[1] - flap.path[0])); }).rest(0.4);
    w.see([&] {
      EXPECT_EQ(w.coach().says().question, nullptr);
      if (w.plan.w.language() != "en") return;
      EXPECT_EQ(w.coach().says().answer.rfind("Not quite", 0), 0u) << w.coach().says().answer;
      EXPECT_EQ(w.coach().standing().size(), 1u) << "no click was an act";
    });
  } else {
    w.click([&] { return w.in_panel("next step", 20, 48); }).rest(0.3);
  }
  w.shoot("answered");
  w.key('2').drag({defect.outline[0] * 0.5 + defect.outline[2] * 0.5, flap.path[1]}).shoot("over-the-defect");
  if (lesson != "rhomboid") back();  // so near to its edge that it begins there
  w.drag({flap.path[0], flap.path[0] + 0.8 * (flap.path[1] - flap.path[0])}).shoot("too-short");
  back();
  Path wide = flap.path;
  const Vec2 side = flap.path[2] - flap.path[1];
  wide[2] = wide[1] + Vec2(0.86 * side.x() - 0.5 * side.y(), 0.5 * side.x() + 0.86 * side.y());
  w.drag(wide, false, "wrong-angle-stroke").shoot("wrong-angle");
  back();
  for (int i = 0; i < 5; ++i) w.key(']');
  w.shoot("deeper").drag(flap.path).shoot("too-deep");
  back();
  for (int i = 0; i < 5; ++i) w.key('[');
  w.drag(flap.path, false, "flap-stroke").shoot("flap");
  w.key('3').drag(pocket.outline, true, "undermine-stroke").shoot("undermined");
  w.click([&] { return w.in_panel("next step", 20, 48); }).rest(0.3).shoot("choice-answered");
  w.key('5').drag({flap.path[1], defect.outline[0]}).shoot("hook-elsewhere");
  w.key('N').until_shown("being-shown").shoot("shown");
  if (pictures_wanted()) {
    for (int i = 0; i < 3; ++i) w.key('N').until_shown();
    w.shoot("raised").key('6');
    w.drag({flap.path[0] + Vec2(1, 0.2), flap.path[0] + Vec2(1, 3)}, false, "one-edge").shoot("one-edge-told");
    back();
    for (int i = 0; i < 3; ++i) w.key('N').until_shown();
    w.shoot("half").key('U').rest(0.4).shoot("history");
    w.key('7').drag({flap.path[0], flap.path[1]}, false, "row-first-edge").shoot("row-half").key('1').key('U');
    for (int i = 0; i < 12; ++i) w.key('N').until_shown();
    w.see([&] { finished = w.coach().says().finished; });  // before going back in the history
    w.rest(0.5).shoot("finished").key(WindowEvent::escape).rest(0.3).shoot("finished-closed");
    w.key('U').rest(0.3).shoot("history-full");
    w.click([&] { return w.in_panel("history", 100, 60); }).rest(1.5).shoot("history-back").key('U');
    w.key('V').rest(0.5).shoot("colours").key('V', WindowEvent::shift);
    w.key('B').rest(0.5).shoot("wipe").key('B').key('B').key('M');
    w.click([&] { return w.on_skin(defect.outline[1]); }).shoot("ruler-1");
    w.click([&] { return w.on_skin(flap.path[1]); }).shoot("ruler-2").key('M');
    w.key('1', WindowEvent::shift).drag({defect.outline[1], flap.path[1]}).shoot("pen").key('1');
  }
  w.run();
  const std::string all = all_said(w.coach());
  if (pictures_wanted()) {
    std::puts(all.c_str());
    EXPECT_TRUE(finished) << all;
    return;
  }
  size_t from = 0;  // each is said after the one before it
  for (const char* words :
       {"cut the skin first", "Out of order: \"defect\" comes before \"flap cut\"", "As planned",
        "A question is open: click on the place", "began over the defect", "too short", "angle at E is 9", "planned 60",
        "mm deeper than planned", "As planned", "As planned", "mm from where the hook should be"}) {
    const size_t at = all.find(words, from);
    EXPECT_NE(at, std::string::npos) << "not said, or too early: " << words << "\nsaid:\n" << all;
    if (at != std::string::npos) from = at + 1;
  }
  EXPECT_EQ(all.find("too short to be a cut"), std::string::npos) << all;
  EXPECT_EQ(w.coach().says().word, "") << "of what was done before the program showed";
}

/// On one's own: what the lesson keeps to itself in the free mode and in an examination.
TEST_P(FirstMinutes, OnOnesOwn) {
  const std::string lesson = GetParam();
  if (lesson != "rhomboid") GTEST_SKIP() << "the same in every lesson";
  for (const LessonMode mode : {LessonMode::free_hand, LessonMode::examination}) {
    const std::string name = mode == LessonMode::examination ? "exam" : "free";
    Walk w(lesson, 1280, 720, mode, false);
    const Excise defect = std::get<Excise>(w.plan.acts[0].command);
    const Incise flap = std::get<Incise>(w.plan.acts[1].command);
    w.rest(0.4).shoot(name + "-begins");
    w.key('4').drag(bent(defect.outline, 0, 1.02), true).shoot(name + "-defect");
    w.key('2').drag({flap.path[0], flap.path[0] + 0.8 * (flap.path[1] - flap.path[0])}).shoot(name + "-too-short");
    w.click([&] { return w.in_panel("##MainMenuBar", 30, 10); }).rest(0.3).shoot(name + "-menu");
    w.key(WindowEvent::escape).rest(0.3);
    if (mode == LessonMode::examination) w.key('N').rest(1).shoot(name + "-asked-to-show");
    w.run();
    const std::string all = all_said(w.coach());
    EXPECT_EQ(w.coach().standing().size(), 2u) << "and nothing was shown";
    EXPECT_EQ(w.coach().says().hint, "");
    if (mode == LessonMode::free_hand) continue;
    EXPECT_EQ(all.find("As planned"), std::string::npos) << all;
    EXPECT_EQ(all.find("too short"), std::string::npos) << all;
  }
}

INSTANTIATE_TEST_SUITE_P(OfALesson, FirstMinutes, ::testing::Values("rhomboid", "cheek-rhomboid"));

}  // namespace test_first_minutes
}  // namespace limberg
