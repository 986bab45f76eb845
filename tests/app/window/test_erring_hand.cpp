// A beginner's first minutes with the rhomboid lesson, by an emulated hand that errs: what the window says at each
// error. With LIMBERG_PICTURES=DIR in the environment the window is drawn into files at every word, at three sizes.
#include <gtest/gtest.h>

#include <cstdlib>
#include <functional>

#include "app/assembly/assembly.h"
#include "app/pictures/pictures.h"
#include "app/program/places.h"
#include "app/session/lockstep.h"
#include "app/window/window_frames.h"
#include "devices/emulator.h"
#include "sim/commands/script.h"
#include "tests/app/window/drawn_window.h"

namespace limberg {
namespace test_erring_hand {

/// One thing that the hand does: an act of a script, a press with a tool where there is nothing, or a rest.
struct Press {
  Tool tool = Tool::none;
  Vec3 at_mm = Vec3::Zero(), let_go_mm = Vec3::Zero();
};
struct Deed {
  std::vector<Command> acts;
  std::optional<Press> press;
  double rest_s = 0;
};

SurgeonSettings steady() {
  SurgeonSettings s;
  s.noise_mm = s.noise_rad = s.tremor_mm = 0, s.dropouts_per_s = 0;
  s.settle_s = 0.6, s.start_s = 0.2;
  return s;
}

class ErringHand final : public Source {
 public:
  explicit ErringHand(std::vector<Deed> deeds) : deeds_(std::move(deeds)) {}
  void look(const Snapshot& s) override {
    seen_ = &s;
    if (hand_) hand_->look(s);
  }
  void poll(int64_t now_ns, SampleSink& sink) override {
    struct Renumbered final : SampleSink {
      ErringHand& h;
      SampleSink& to;
      int64_t began_ns;
      Renumbered(ErringHand& hand, SampleSink& sink, int64_t began) : h(hand), to(sink), began_ns(began) {}
      void on_sample(const Sample& s) override {
        Sample c = s;
        std::visit([&](auto& x) { x.t_ns += began_ns, x.seq = h.seq_++; }, c);
        to.on_sample(c);
      }
    };
    if (next_ == deeds_.size()) return;
    Deed& d = deeds_[next_];
    if (began_ns_ < 0) began_ns_ = now_ns, sent_ = 0;
    if (!d.acts.empty()) {
      if (!hand_) hand_ = std::make_unique<EmulatedSurgeon>(d.acts, steady()), hand_->look(*seen_);
      Renumbered through(*this, sink, began_ns_);
      hand_->poll(now_ns - began_ns_, through);
      if (hand_->done()) end();
    } else if (d.press) {
      press(*d.press, now_ns, sink);
    } else if (double(now_ns - began_ns_) > d.rest_s * 1e9) {
      end();
    }
  }
  bool done() const override { return next_ == deeds_.size(); }
  SourceCounts counts() const override { return {seq_, 0, 0}; }

 private:
  void end() { hand_.reset(), ++next_, began_ns_ = -1; }
  void press(const Press& p, int64_t now_ns, SampleSink& sink) {
    const double t_s = double(now_ns - began_ns_) * 1e-9;
    if (sent_ == 0) {
      ControlSample c;
      c.device_id = 100, c.seq = seq_++, c.t_ns = now_ns, c.kind = ControlSample::select_tool, c.tool = p.tool;
      sink.on_sample(c);
    }
    if (t_s < double(sent_) * 0.01) return;
    ++sent_;
    StylusSample s;
    s.device_id = 100, s.seq = seq_++, s.t_ns = now_ns;
    s.buttons = t_s > 0.4 && t_s < 0.9;
    const double along = std::clamp((t_s - 0.5) / 0.3, 0.0, 1.0);
    s.tip_mm = p.at_mm + along * (p.let_go_mm - p.at_mm);
    sink.on_sample(s);
    if (t_s > 1.4) end();
  }
  std::vector<Deed> deeds_;
  size_t next_ = 0, sent_ = 0;
  int64_t began_ns_ = -1, seq_ = 0;
  std::unique_ptr<Source> hand_;
  const Snapshot* seen_ = nullptr;
};

/// Looks at the window twice a second; at every word, if pictures are wanted, at three sizes.
class Watched final : public PictureSink {
 public:
  Watched(testing::MemoryScreen& screen, WindowFrames& window, std::string pictures)
      : screen_(screen), window_(window), pictures_(std::move(pictures)) {}
  void prepare(const SurfaceTopology& first) override { window_.prepare(first); }
  void notice(const Notice& n) override { window_.notice(n); }
  void missed(const MissedPress& m, const Snapshot& s) override { window_.missed(m, s); }
  bool wants_frame() override { return true; }
  void stage(const std::string&, const Snapshot&) override {}
  void finish() override { window_.finish(); }
  void frame(const Snapshot& s, const ToolState& t) override {
    const int every = pictures_.empty() ? 15 : 3;
    if (++calls_ % every != 0) return;
    window_.wants_frame();
    window_.frame(s, t);
    if (pictures_.empty()) return;
    const Coach& c = *window_.coach();
    const bool stroke = !c.says().stroke.empty() && c.says().stroke[0].words != stroke_ && ++strokes_ % 6 == 0;
    const bool hint = c.says().hint.size() != hint_;
    if (c.said().size() == said_ && !stroke && !hint) return;
    const std::string what = stroke ? "stroke" : hint ? "hint" : "word";
    said_ = c.said().size(), hint_ = c.says().hint.size();
    for (const auto& [w, h] : {std::pair{800, 600}, {1280, 720}, {1920, 1080}}) {
      screen_.width = w, screen_.height = h;
      for (int i = 0; i < 4; ++i) window_.wants_frame(), window_.frame(s, t);
      write_png(
          pictures_ + "/" + std::to_string(w) + "-" + std::to_string(1000 + shots_).substr(1) + "-" + what + ".png",
          window_.picture());
    }
    screen_.width = 1280, screen_.height = 720;
    ++shots_;
  }

 private:
  testing::MemoryScreen& screen_;
  WindowFrames& window_;
  std::string pictures_, stroke_;
  int calls_ = 0, shots_ = 0, strokes_ = 0;
  size_t said_ = 0, hint_ = 0;
};

Deed act(Command c) { return {{std::move(c)}, std::nullopt, 0}; }
Deed press(Tool tool, const Vec3& at, const Vec3& let_go) { return {{}, Press{tool, at, let_go}, 0}; }
Deed rest(double s) { return {{}, std::nullopt, s}; }

TEST(ErringHand, IsToldAtEachErrorWhatIsOffAndWhatToDo) {
  try {
    make_osmesa_context();
  } catch (const RenderUnavailable&) {
    GTEST_SKIP() << "no OSMesa here";
  }
  const Scene scene = load_scene(source_dir() + "/app/scenes/rhomboid.toml");
  const Lesson lesson = open_lesson(source_dir() + "/app/lessons/rhomboid.toml");
  std::vector<Command> script;
  for (const ScriptLine& l : load_script(source_dir() + "/recordings/rhomboid.jsonl").lines)
    script.push_back(l.command);
  const LessonPlan plan = make_lesson_plan(&lesson, script);
  ASSERT_EQ(plan.steps.size(), 7u);
  const auto planned = [&](size_t i) { return plan.acts[i].command; };
  const Incise flap = std::get<Incise>(planned(1));
  const auto cut = [&](std::vector<ChartPoint> path, double depth_mm = 4) {
    return act(Incise{std::move(path), depth_mm, 90, false});
  };

  std::vector<Deed> deeds{rest(17),                                         // hesitates: a hint
                          act(planned(2)),                                  // undermines before anything is cut
                          press(Tool::excise, {90, 70, 20}, {95, 70, 20}),  // beside the patient
                          cut(flap.path),
                          act(Undo{}),                                   // the flap before the defect
                          act(planned(0)),                               // the defect, as planned
                          press(Tool::scalpel, {-9, 9, -4}, {8, 0, 0}),  // begins over the defect
                          cut({{0, 0}, {14, -8.1}}),
                          act(Undo{}),  // too short
                          cut({{0, 0}, {17.3, -10}, {9, -25.5}}),
                          act(Undo{}),  // a wrong angle
                          cut(flap.path, 6.5),
                          act(Undo{}),  // too deep
                          cut({{30, 20}, {45, 10}}),
                          act(Undo{}),                                      // elsewhere
                          cut(flap.path),                                   // as planned
                          press(Tool::hook, {-9, 9, -4}, {-9, 9, 4}),       // a hook on nothing
                          press(Tool::suture, {-22, 2, 0}, {-20.5, 0, 0}),  // both bites in one edge
                          press(Tool::suture, {-22, 2, 0}, {-9, 9, 25}),    // let go in the air
                          rest(1)};

  testing::MemoryScreen screen;
  HandFeed feed;
  WindowSettings set;
  set.facts.scene = scene.name, set.facts.device = "stylus", set.facts.own_device = set.facts.calibrated = true,
  set.facts.goal = lesson.goal;
  set.camera = scene_camera(scene), set.lesson = plan;
  WindowFrames window(screen, feed, nullptr, set);
  const char* pictures = std::getenv("LIMBERG_PICTURES");
  Watched watched(screen, window, pictures ? pictures : "");

  AssemblyOptions o;
  o.workers = 1, o.sink = &watched, o.draw_frames = true;
  Assembly a(scene, Calibration{}, o);
  a.front.add(std::make_unique<ErringHand>(std::move(deeds)));
  SessionSettings s = a.session_settings();
  s.ticks_per_frame = 33, s.settle_steps = 0;
  std::vector<Coach::Said> said;
  run_lockstep(a.lanes(nullptr), s);
  ASSERT_NE(window.coach(), nullptr);
  said = window.coach()->said();

  std::string all;
  for (const Coach::Said& w : said) all += "  " + std::to_string(w.t_s).substr(0, 5) + "  " + w.word + "\n";
  if (pictures) std::puts(all.c_str());
  size_t from = 0;  // each is said after the one before it
  for (const char* words :
       {"Not done: ", "cut the skin first", "began beside the patient",
        "Out of order: \"defect\" comes before \"flap cut\"", "As planned", "began over the defect", "too short",
        "the end at F is missing", "angle at E is 9", "planned 60", "mm deeper than planned", "elsewhere than planned",
        "As planned", "hook holds nothing in the wound", "Both bites lie in one edge",
        "let go where there is no skin"}) {
    const size_t at = all.find(words, from);
    EXPECT_NE(at, std::string::npos) << "not said, or too early: " << words << "\nsaid:\n" << all;
    if (at != std::string::npos) from = at;
  }
  EXPECT_NE(all.find("Ctrl+Z takes it back"), std::string::npos);
  const PlanProgress& p = window.coach()->progress();
  EXPECT_EQ(p.act[0].state, ActProgress::done);
  EXPECT_EQ(p.act[1].state, ActProgress::done);
  EXPECT_EQ(p.next, 2u);
  EXPECT_FALSE(window.coach()->present().better.empty());
}

}  // namespace test_erring_hand
}  // namespace limberg
