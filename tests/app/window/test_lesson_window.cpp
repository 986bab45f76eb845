// The window of shipped lessons, on skin, on a face and on bone: the plan is drawn on the patient, the panels ask and
// answer, a try is summed up. With LIMBERG_PICTURES=DIR in the environment the windows are drawn into files at three
// sizes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>

#include "app/assembly/cases.h"
#include "app/assembly/patient_of_scene.h"
#include "app/pictures/pictures.h"
#include "app/program/places.h"
#include "app/session/workers_pool.h"
#include "sim/commands/script.h"
#include "sim/patient/world.h"
#include "tests/app/window/drawn_window.h"

namespace limberg {
namespace test_lesson_window {

struct Window : testing::DrawnWindow {
  double t_s = 0;

  Window(const Scene& scene, const LessonPlan& plan, Snapshot patient, LessonMode mode = LessonMode::guided)
      : DrawnWindow(std::move(patient)) {
    WindowSettings set;
    set.facts.scene = scene.name, set.facts.device = "mouse", set.facts.goal = plan.goal;
    set.facts.head = scene.head.has_value(), set.facts.skin = scene.flesh;
    set.camera = scene_camera(scene), set.lesson = plan, set.mode = mode;
    open(set, nullptr);
  }
  void click(float x, float y) {
    WindowEvent e;
    e.x = x, e.y = y;
    router.take(e), settle();
    e.kind = WindowEvent::button, e.down = 1;
    router.take(e), settle();
    e.down = 0;
    router.take(e), settle();
  }
  void done(const Command& c) {
    Notice n;
    n.t_s = t_s += 1, n.command = std::make_shared<const Command>(c);
    frames->notice(n);
  }
  /// At three sizes, where pictures are wanted.
  void shoot(const std::string& name) {
    const char* dir = std::getenv("LIMBERG_PICTURES");
    if (!dir) return;
    for (const auto& [w, h] : {std::pair{800, 600}, {1280, 720}, {1920, 1080}}) {
      screen.width = w, screen.height = h, settle();
      write_png(std::string(dir) + "/" + std::to_string(w) + "-" + name + ".png", frames->picture());
    }
    screen.width = 1280, screen.height = 720, settle();
  }
};

struct Shipped : testing::ShippedLesson {
  Snapshot patient;
  explicit Shipped(const std::string& name) : ShippedLesson(name) {
    WorkersPool workers(2);
    make_world(scene, workers)->fill(patient);
  }
};

int different(const Image& a, const Image& b, int x0, int y0, int x1, int y1) {
  int n = 0;
  for (int y = y0; y < y1; ++y)
    for (int x = x0; x < x1; ++x) {
      const Rgb8 p = a.at(x, y), q = b.at(x, y);
      n += std::max({std::abs(p.r - q.r), std::abs(p.g - q.g), std::abs(p.b - q.b)}) > 24;
    }
  return n;
}

class LessonWindow : public ::testing::Test {
 protected:
  void SetUp() override {
    try {
      make_osmesa_context();
    } catch (const RenderUnavailable&) {
      GTEST_SKIP() << "no OSMesa here";
    }
  }
};

TEST_F(LessonWindow, DrawsThePlanOnThePatientInAGuidedLessonAlone) {
  for (const char* name : {"rhomboid", "zplasty", "craniofacial"}) {
    const Shipped of(name);
    Window guided(of.scene, of.plan, of.patient), exam(of.scene, of.plan, of.patient, LessonMode::examination);
    for (Window* w : {&guided, &exam}) {
      if (of.scene.flesh && w == &guided) w->key('L');  // tension lines off again, as in the other
      w->key('S'), w->key('S');                         // one quality, whatever the machine's speed
      if (of.plan.bone) w->key('F');                    // the face clear
    }
    const Image with = guided.frames->picture(), without = exam.frames->picture();
    EXPECT_GT(different(with, without, 180, 110, 1000, 620), 300) << name << ": the drawing";
    EXPECT_GT(different(with, without, 180, 0, 1000, 60), 2000) << name << ": the next step in words";
    guided.shoot(std::string(name) + "-begins"), exam.shoot(std::string(name) + "-exam");
  }
}

TEST_F(LessonWindow, DrawsThePlanOnAFace) {
  const Shipped of("cheek-rhomboid");
  Window w(of.scene, of.plan, of.patient), free(of.scene, of.plan, of.patient, LessonMode::free_hand);
  w.key('L');
  EXPECT_GT(different(w.frames->picture(), free.frames->picture(), 180, 110, 1000, 620), 300);
  // The scene's own camera looks at the other cheek: that of a lesson looks at its plan.
  w.feed.seen.update();
  const View view = w.feed.seen.reading().view;
  const LetteredPoint& d = of.plan.letters[0];
  SkinChart chart;
  chart.build(*of.patient.topology);
  const SkinTouch at = chart.at(of.patient, d.at, 2);
  ASSERT_GE(at.triangle, 0);
  EXPECT_GT((view.eye_mm.cast<double>() - at.x_mm).normalized().dot(at.normal), 0.6);
  w.shoot("cheek-rhomboid-begins");
}

// The scene's eye is at the other cheek, or at this one: the lesson looks at its plan by the same light.
TEST_F(LessonWindow, TheLampStandsOverThePlanWhereverTheSceneLooksFrom) {
  const Shipped of("cheek-rhomboid");
  Scene other = of.scene;
  other.camera.from.x() *= -1;
  Window one(of.scene, of.plan, of.patient), two(other, of.plan, of.patient);
  one.key('S'), two.key('S');  // one quality, whatever the machine's speed
  EXPECT_LT(different(one.frames->picture(), two.frames->picture(), 180, 110, 1000, 620), 300);
}

TEST_F(LessonWindow, AsksAnswersShowsAndSumsUp) {
  const Shipped of("rhomboid");
  Window w(of.scene, of.plan, of.patient);
  w.key('S'), w.key('S');  // one quality, whatever the machine's speed
  w.done(w.frames->coach()->plan().acts[0].command);
  w.settle();
  const LessonQuestion* question = w.frames->coach()->says().question;
  ASSERT_TRUE(question && question->place);
  SkinChart chart;
  chart.build(*w.s.topology);
  const SkinTouch at = chart.at(w.s, *question->place, 1);
  ASSERT_GE(at.triangle, 0);
  w.feed.seen.update();
  const Vec3f px = w.feed.seen.reading().view.to_pixel(at.x_mm.cast<float>(), 1280, 720);
  w.click(px.x(), px.y());  // where the skin will stand up
  EXPECT_EQ(w.frames->coach()->says().question, nullptr);
  EXPECT_EQ(w.frames->coach()->says().answer.substr(0, 5), "Right");
  w.shoot("rhomboid-answered");
  // The stage that was reached goes into the session as one.
  bool staged = false, shown = false;
  const auto drain = [&] {
    for (HandInput i; w.feed.input.pop(i);) {
      if (const auto* c = std::get_if<ControlSample>(&i))
        staged |= c->kind == ControlSample::stage && c->text.str() == "defect";
      if (const auto* c = std::get_if<CommandSample>(&i)) shown |= std::holds_alternative<Shown>(*c->command);
    }
  };
  drain();
  EXPECT_TRUE(staged);
  w.router.look_with([&](bool) { return &w.s; });
  w.key('N');
  w.router.pump(1);
  drain();
  EXPECT_TRUE(w.feed.showing);
  EXPECT_TRUE(shown);
  w.feed.showing = false;

  w.done(Incise{{{0, 0}, {15, -8.66}}, 6, 90, false});
  w.settle();
  const Image before = w.frames->picture();
  w.key('J');
  EXPECT_GT(different(before, w.frames->picture(), 450, 250, 830, 450), 5000);
  w.shoot("rhomboid-summary");
  w.key('J');
  EXPECT_LT(different(before, w.frames->picture(), 450, 250, 830, 450), 100);
  for (int i = 0; i < 2; ++i) w.done(Undo{});
  for (const PlannedAct& a : w.frames->coach()->plan().acts)
    if (a.step < 5) w.done(a.command);
  w.settle();
  w.shoot("rhomboid-later");
}

// Wherever one comes near from, the eye stays outside of the tissue.
TEST_F(LessonWindow, TheEyeStaysOutOfTheTissue) {
  const Shipped of("rhomboid");
  Window w(of.scene, of.plan, of.patient);
  WindowEvent e;
  e.x = 590, e.y = 330;
  w.router.take(e);
  e.kind = WindowEvent::wheel, e.x = 0, e.y = 3;
  for (int i = 0; i < 40; ++i) w.router.take(e), w.settle();
  w.feed.seen.update();
  EXPECT_GT(w.feed.seen.reading().view.eye_mm.z(), 5);
  EXPECT_LT(w.feed.seen.reading().view.eye_mm.z(), 60) << "it came near";
}

}  // namespace test_lesson_window
}  // namespace limberg
