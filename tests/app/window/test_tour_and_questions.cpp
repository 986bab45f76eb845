// The tour goes on by itself when the learner did what it asks, and a question is answered by pointing or by a number;
// each with the keys alone. With LIMBERG_PICTURES=DIR in the environment the screens are drawn into files.
#include <gtest/gtest.h>
#include <imgui_internal.h>

#include <cstdlib>

#include "app/assembly/patient_of_scene.h"
#include "app/pictures/pictures.h"
#include "app/program/places.h"
#include "app/program/temporary_folder.h"
#include "app/session/workers_pool.h"
#include "devices/skin_chart.h"
#include "sim/commands/script.h"
#include "sim/patient/world.h"
#include "tests/app/window/drawn_window.h"

namespace limberg {
namespace test_tour_and_questions {

struct Asked : ::testing::Test {
  void SetUp() override {
    try {
      make_osmesa_context();
    } catch (const RenderUnavailable&) {
      GTEST_SKIP() << "no OSMesa here";
    }
    if (patient) return;
    scene = new Scene(load_scene(source_dir() + "/app/scenes/rhomboid.toml"));
    scene->cell_mm = 8;
    WorkersPool workers(1);
    const auto world = make_world(*scene, workers);
    world->apply(planned("rhomboid").acts[0].command);
    patient = new Snapshot;
    world->fill(*patient);
  }
  static void TearDownTestSuite() { delete scene, delete patient, scene = nullptr, patient = nullptr; }
  static LessonPlan planned(const std::string& name) {
    const Lesson lesson = open_lesson(source_dir() + "/app/lessons/" + name + ".toml");
    std::vector<Command> script;
    for (const ScriptLine& l : load_script(source_dir() + "/recordings/" + name + ".jsonl").lines)
      script.push_back(l.command);
    return make_lesson_plan(&lesson, script);
  }
  static Scene* scene;
  static Snapshot* patient;
};
Scene* Asked::scene = nullptr;
Snapshot* Asked::patient = nullptr;

struct Window : testing::DrawnWindow {
  LaneGauges gauges;
  explicit Window(const LessonPlan& plan, const std::string& memory = "") : DrawnWindow(*Asked::patient) {
    WindowSettings set;
    set.facts.scene = Asked::scene->name, set.facts.device = "mouse", set.facts.goal = plan.goal;
    set.camera = scene_camera(*Asked::scene), set.lesson = plan, set.memory_file = memory;
    open(set, &gauges);
  }
  void told(int32_t kind, const Command& c) {
    Notice n;
    n.kind = kind, n.t_s = 1, n.command = std::make_shared<const Command>(c);
    frames->notice(n);
    settle();
  }
  void frames_of_a_second() {
    for (int i = 0; i < 12; ++i) settle();
  }
  void pointer(float x, float y) {
    WindowEvent e;
    e.x = x, e.y = y;
    router.take(e), settle();
  }
  void button(int code, bool down) {
    WindowEvent e;
    e.kind = WindowEvent::button, e.code = code, e.down = down;
    router.take(e), settle();
  }
  void text(char c) {
    WindowEvent e;
    e.kind = WindowEvent::text, e.code = c;
    router.take(e), settle();
  }
  /// Which card of the tour is shown: its title, as the last frame has it; 0: none.
  bool tour() {
    feed.seen.update();
    return feed.seen.reading().tour;
  }
  void shoot(const std::string& name) {
    const char* dir = std::getenv("LIMBERG_PICTURES");
    if (!dir) return;
    for (const auto& [w, h] : {std::pair{800, 600}, {1280, 720}, {3840, 2160}}) {
      screen.width = w, screen.height = h, settle();
      write_png(std::string(dir) + "/" + std::to_string(w) + "-" + name + ".png", frames->picture());
    }
    screen.width = 1280, screen.height = 720, settle();
  }
};

TEST_F(Asked, TheTourGoesOnWhenWhatItAsksForWasDone) {
  const TemporaryFolder folder;
  Window w(planned("rhomboid"), folder.path().string() + "/window.toml");
  const auto card = [&] { return w.frames->tour_card(); };
  ASSERT_EQ(card(), 1);
  w.shoot("tour-asks");
  w.frames_of_a_second();
  EXPECT_EQ(card(), 1) << "nothing was done yet";
  w.pointer(300, 500), w.button(1, true), w.pointer(360, 480);  // beside the card
  EXPECT_EQ(card(), 1) << "the view is being turned";
  w.button(1, false), w.settle();
  w.shoot("tour-done");
  w.frames_of_a_second();
  ASSERT_EQ(card(), 2);
  w.key('2');  // by the key that the card names
  w.frames_of_a_second();
  ASSERT_EQ(card(), 3);
  w.told(Notice::done, planned("rhomboid").acts[0].command);
  w.frames_of_a_second();
  ASSERT_EQ(card(), 4);
  w.told(Notice::undone, Undo{});
  w.frames_of_a_second();
  ASSERT_EQ(card(), 5);
  w.frames_of_a_second();
  EXPECT_EQ(card(), 5) << "this card asks for nothing";
  w.key(WindowEvent::enter), w.settle();
  ASSERT_EQ(card(), 6);
  w.key(WindowEvent::f1);
  w.frames_of_a_second();
  EXPECT_EQ(card(), 0);
  EXPECT_FALSE(w.tour());
}

TEST_F(Asked, TheTourIsReadByKeysAlone) {
  const TemporaryFolder folder;
  Window w(planned("rhomboid"), folder.path().string() + "/window.toml");
  for (int k = 1; k <= DeskTour::kCards; ++k) {
    ASSERT_EQ(w.frames->tour_card(), k);
    w.key(WindowEvent::enter), w.settle();
  }
  EXPECT_EQ(w.frames->tour_card(), 0);
  Window skipped(planned("rhomboid"), folder.path().string() + "/other.toml");
  skipped.key(WindowEvent::escape), skipped.settle();
  EXPECT_EQ(skipped.frames->tour_card(), 0);
  // What it asks for by keys: the view is turned, a tool chosen.
  Window keys(planned("rhomboid"), folder.path().string() + "/third.toml");
  for (int i = 0; i < 6; ++i) keys.key(WindowEvent::arrow_left, WindowEvent::control);
  keys.frames_of_a_second();
  EXPECT_EQ(keys.frames->tour_card(), 2);
}

TEST_F(Asked, APlaceIsPointedAtByKeyAndByClick) {
  const LessonPlan plan = planned("rhomboid");
  for (const bool click : {false, true})
    for (const double off_mm : {0.0, 25.0}) {
      Window w(plan);
      w.told(Notice::done, plan.acts[0].command);
      const LessonQuestion* q = w.frames->coach()->says().question;
      ASSERT_TRUE(q && q->place);
      if (!click && off_mm == 0) w.shoot("question-place");
      SkinChart chart;
      chart.build(*w.s.topology);
      const SkinTouch at = chart.at(w.s, *q->place + ChartPoint(off_mm, 0), 1);
      ASSERT_GE(at.triangle, 0);
      w.feed.seen.update();
      const Vec3f px = w.feed.seen.reading().view.to_pixel(at.x_mm.cast<float>(), 1280, 720);
      w.pointer(px.x(), px.y());
      if (click)
        w.button(0, true), w.button(0, false), w.settle();
      else
        w.key('K');
      EXPECT_EQ(w.frames->coach()->says().question, nullptr) << "it was not answered";
      const std::string answer = w.frames->coach()->says().answer;
      EXPECT_EQ(answer.rfind(off_mm == 0 ? "Right" : "Not quite", 0), 0u) << answer;
      if (!click) w.shoot(off_mm == 0 ? "question-right" : "question-wrong");
    }
  // A drag turns the view and answers nothing.
  Window w(plan);
  w.told(Notice::done, plan.acts[0].command);
  w.pointer(640, 400), w.button(0, true), w.pointer(680, 400), w.button(0, false), w.settle();
  EXPECT_NE(w.frames->coach()->says().question, nullptr);
}

TEST_F(Asked, ANumberIsTypedInByKeysAlone) {
  const LessonPlan plan = planned("zplasty");
  Window w(plan);
  const LessonQuestion* q = nullptr;
  for (size_t i = 0; i < plan.acts.size() && !(q && q->number); ++i) {
    w.told(Notice::done, plan.acts[i].command);
    q = w.frames->coach()->says().question;
  }
  ASSERT_TRUE(q && q->number);
  w.shoot("question-number");
  // The field in the panel of the next step.
  ImGui::SetCurrentContext(ImGui::GetCurrentContext());
  const ImGuiWindow* panel = ImGui::FindWindowByName("next step");
  ASSERT_NE(panel, nullptr);
  w.pointer(panel->Pos.x + 40, panel->Pos.y + panel->Size.y * 0.5f);
  // Wherever it lies in the panel: each line of it is tried.
  for (float y = panel->Pos.y + 12; y < panel->Pos.y + panel->Size.y && w.frames->coach()->says().question; y += 8) {
    w.pointer(panel->Pos.x + 40, y), w.button(0, true), w.button(0, false), w.settle();
    w.feed.seen.update();
    if (!w.feed.seen.reading().typing) continue;
    w.key('A', WindowEvent::control), w.key(WindowEvent::backspace);
    for (const char c : std::string("73")) w.text(c);
    w.key(WindowEvent::enter), w.settle();
  }
  EXPECT_EQ(w.frames->coach()->says().question, nullptr);
  EXPECT_EQ(w.frames->coach()->says().answer.rfind("Right", 0), 0u) << w.frames->coach()->says().answer;
}

}  // namespace test_tour_and_questions
}  // namespace limberg
