// From 800 x 600 to 3840 x 2160, with large letters and small: no panel leaves the window and none lies over another.
// With LIMBERG_PICTURES=DIR in the environment the screens are drawn into files.
#include <gtest/gtest.h>
#include <imgui_internal.h>

#include <cstdlib>
#include <set>

#include "app/assembly/patient_of_scene.h"
#include "app/pictures/pictures.h"
#include "app/program/places.h"
#include "app/program/temporary_folder.h"
#include "app/session/workers_pool.h"
#include "app/words/chosen_words.h"
#include "sim/commands/script.h"
#include "sim/patient/world.h"
#include "tests/app/window/drawn_window.h"

namespace limberg {
namespace test_layouts {

constexpr std::pair<int, int> kSizes[] = {{800, 600}, {1280, 720}, {1920, 1080}, {3840, 2160}};
/// They lie over the others, and go when they are closed.
const std::set<std::string> kOver{"Keys and mouse", "How it went", "tour"};

struct Lessons : ::testing::Test {
  static void SetUpTestSuite() {
    const Lesson lesson = open_lesson(source_dir() + "/app/lessons/rhomboid.toml");
    scene = new Scene(load_scene(source_dir() + "/app/scenes/rhomboid.toml"));
    scene->cell_mm = 8;
    std::vector<Command> script;
    for (const ScriptLine& l : load_script(source_dir() + "/recordings/rhomboid.jsonl").lines)
      script.push_back(l.command);
    plan = new LessonPlan(make_lesson_plan(&lesson, script));
    patient = new Snapshot;
    WorkersPool workers(1);
    const auto world = make_world(*scene, workers);
    world->apply(script.front());
    world->fill(*patient);
    for (int i = 1; i <= 9; ++i) patient->sutures.push_back({i, Vec3f(float(i), 5, 0), Vec3f(float(i), 7, 0), 0.4f});
    patient->hooks.push_back({1, Vec3f(14, -10, 0), Vec3f(20, -10, 12), Vec3f(1, 0, 0)});
    patient->hooks.push_back({2, Vec3f(10, -10, 0), Vec3f(16, -14, 12), Vec3f(1, 0, 0)});
  }
  static void TearDownTestSuite() { delete scene, delete plan, delete patient; }
  void SetUp() override {
    try {
      make_osmesa_context();
    } catch (const RenderUnavailable&) {
      GTEST_SKIP() << "no OSMesa here";
    }
  }
  static Scene* scene;
  static LessonPlan* plan;
  static Snapshot* patient;
};
Scene* Lessons::scene = nullptr;
LessonPlan* Lessons::plan = nullptr;
Snapshot* Lessons::patient = nullptr;

struct Window : testing::DrawnWindow {
  LaneGauges gauges;
  explicit Window(const std::string& memory = "", const LessonPlan* in_language = nullptr)
      : DrawnWindow(*Lessons::patient) {
    const LessonPlan& taught = in_language ? *in_language : *Lessons::plan;
    WindowSettings set;
    set.facts.scene = Lessons::scene->name, set.facts.device = "mouse", set.facts.goal = taught.goal;
    set.facts.w = taught.w;
    set.camera = scene_camera(*Lessons::scene), set.lesson = taught, set.memory_file = memory;
    open(set, &gauges);
  }
  void says(const std::string& why) {
    Notice n;
    n.kind = Notice::refused, n.t_s = 3;
    Notice::put(n.action, "incise"), Notice::put(n.text, why);
    frames->notice(n);
  }
  void did(const Command& c, const std::string& words) {
    Notice n;
    n.t_s = 12, n.command = std::make_shared<const Command>(c);
    Notice::put(n.text, words);
    frames->notice(n);
    settle();
  }
  void sized(int w, int h) {
    screen.width = w, screen.height = h;
    settle();
  }
  /// Without looking at what comes of it yet.
  void key_alone(int32_t code, uint32_t mods) {
    testing::press_key(router, code, mods);
    router.pump(0), frames->wants_frame();
  }
  void shoot(const std::string& name) {
    if (const char* dir = std::getenv("LIMBERG_PICTURES")) write_png(fmt(dir, name), frames->picture());
  }
  std::string fmt(const std::string& dir, const std::string& name) const {
    return dir + "/" + std::to_string(screen.width) + "-" + name + ".png";
  }
  /// A panel whose title is in a language has its name behind it.
  static std::string name_of(const ImGuiWindow* w) {
    const std::string name = w->Name;
    const size_t own = name.find("###");
    return own == name.npos ? name : name.substr(own + 3);
  }
  /// What is wrong with the panels of the last frame; empty: nothing.
  std::string wrong() const {
    std::string all;
    const ImVec2 whole = ImGui::GetIO().DisplaySize;
    std::vector<const ImGuiWindow*> seen;
    for (const ImGuiWindow* w : ImGui::GetCurrentContext()->Windows)
      if (w->WasActive && !w->Hidden && !(w->Flags & (ImGuiWindowFlags_ChildWindow | ImGuiWindowFlags_Tooltip)) &&
          std::string(w->Name).find("Debug") == std::string::npos)
        seen.push_back(w);
    for (size_t i = 0; i < seen.size(); ++i) {
      const ImRect a = seen[i]->Rect();
      if (a.Min.x < -0.5f || a.Min.y < -0.5f || a.Max.x > whole.x + 0.5f || a.Max.y > whole.y + 0.5f)
        all += name_of(seen[i]) + " leaves the window\n";
      for (size_t k = i + 1; k < seen.size(); ++k) {
        ImRect b = seen[k]->Rect();
        b.Expand(-0.5f);
        const bool over = (seen[i]->Flags | seen[k]->Flags) & ImGuiWindowFlags_Popup;  // an open menu
        if (!over && !kOver.count(name_of(seen[i])) && !kOver.count(name_of(seen[k])) && a.Overlaps(b))
          all += std::string(seen[i]->Name) + " and " + seen[k]->Name + " overlap\n";
      }
    }
    return seen.size() < 4 ? "panels are missing" : all;
  }
};

TEST_F(Lessons, NoPanelLeavesTheWindowOrLiesOverAnother) {
  Window w;
  w.says("depth 10 mm is deeper than the scene allows; expected at most 9 mm, or a patient with thicker skin");
  w.key('V');  // colours and their legend
  w.did(Incise{{{-14, 0}, {14, 0}}, 4, 90}, "incise 28 mm, 4 mm deep");
  for (const auto& [width, height] : kSizes) {
    SCOPED_TRACE(std::to_string(width) + " x " + std::to_string(height));
    w.sized(width, height);
    EXPECT_EQ(w.wrong(), "");
    w.shoot("plain");
    for (int k = 0; k < 4; ++k) w.key_alone('=', WindowEvent::control);
    w.settle();
    EXPECT_EQ(w.wrong(), "") << "with letters twice as large";
    w.key('U');
    EXPECT_EQ(w.wrong(), "") << "with the history of acts";
    w.shoot("large");
    w.key_alone('U', 0);
    for (int k = 0; k < 4; ++k) w.key_alone('-', WindowEvent::control);
  }
}

TEST_F(Lessons, EveryScreenIsInsideAtEverySize) {
  Window w;
  w.did(Incise{{{-14, 0}, {14, 0}}, 4, 90}, "incise 28 mm, 4 mm deep");
  w.did(Mark{{{-20, -12}, {15, -14}}, false}, "pen: a line of 35.1 mm");
  for (const auto& [width, height] : kSizes) {
    w.sized(width, height);
    for (const auto& [name, key] : {std::pair("help", int(WindowEvent::f1)), {"summary", int('J')}}) {
      w.key(key);
      EXPECT_EQ(w.wrong(), "") << name << " at " << width;
      w.shoot(name);
      w.key(WindowEvent::escape);
    }
  }
  w.sized(1280, 720);
  for (const char* name : {"light", "contrast"}) {
    w.key('K', WindowEvent::control), w.settle();
    w.shoot(name);
  }
}

/// Panels on both sides whose words are cut off: of those that wrap ImGui's content is no wider than the panel.
std::string cut_off() {
  std::string all;
  for (const ImGuiWindow* w : ImGui::GetCurrentContext()->Windows) {
    const std::string name = w->Name;
    if (!w->WasActive || w->Hidden || (name != "tools" && name != "patient" && name != "lanes")) continue;
    const float room = w->InnerRect.GetWidth() - 2 * w->WindowPadding.x;
    if (w->ContentSize.x > room + w->WindowPadding.x)
      all += name + " is " + std::to_string(int(room)) + " wide, and its words " +
             std::to_string(int(w->ContentSize.x)) + "\n";
  }
  return all;
}

// A language whose words are longer than English ones.
TEST_F(Lessons, InGermanEveryScreenIsInsideToo) {
  const Words de = chosen_words({"de", ""});
  const Lesson lesson = open_lesson(source_dir() + "/app/lessons/rhomboid.toml");
  std::vector<Command> script;
  for (const ScriptLine& l : load_script(source_dir() + "/recordings/rhomboid.jsonl").lines)
    script.push_back(l.command);
  const LessonPlan german = make_lesson_plan(&lesson, script, de);
  ASSERT_EQ(german.steps[0].name, "Defekt");
  EXPECT_EQ(german.steps[0].words.stage, "defect") << "recordings have the script's names";
  const TemporaryFolder folder;
  Window w(folder.path().string() + "/window.toml", &german);
  for (const auto& [width, height] : {std::pair(800, 600), {1280, 720}})
    for (int card = 0; card < DeskTour::kCards / 2; ++card) {
      w.sized(width, height);
      EXPECT_EQ(w.wrong(), "") << card << " at " << width;
      if (card == 0) w.shoot("de-tour");
      w.key(WindowEvent::enter), w.settle();
    }
  w.says("depth 10 mm is deeper than the scene allows; expected at most 9 mm");
  w.key('V');
  w.did(Incise{{{-14, 0}, {14, 0}}, 4, 90}, "incise 28 mm, 4 mm deep");
  EXPECT_NE(w.frames->coach()->says().word.find("Strg+Z nimmt es zurück."), std::string::npos)
      << w.frames->coach()->says().word;
  for (const auto& [width, height] : {std::pair(800, 600), {1280, 720}, {1920, 1080}}) {
    w.sized(width, height);
    EXPECT_EQ(w.wrong(), "") << width;
    EXPECT_EQ(cut_off(), "") << width;
    w.shoot("de-plain");
    for (const auto& [name, key] : {std::pair("de-help", int(WindowEvent::f1)), {"de-summary", int('J')}}) {
      w.key(key);
      EXPECT_EQ(w.wrong(), "") << name << " at " << width;
      w.shoot(name);
      w.key(WindowEvent::escape);
    }
    w.key('U');
    EXPECT_EQ(w.wrong(), "") << "with the history of acts";
    w.shoot("de-history");
    w.key_alone('U', 0);
  }
}

/// Words that run out of the panel that they stand in, of all panels that do not scroll sideways.
std::string words_cut() {
  std::string all;
  for (const ImGuiWindow* w : ImGui::GetCurrentContext()->Windows) {
    if (!w->WasActive || w->Hidden || (w->Flags & ImGuiWindowFlags_Tooltip)) continue;
    const std::string name = w->Name;
    if (name.find("Debug") != name.npos || name.find("acts") != name.npos) continue;
    const float room = w->InnerRect.GetWidth() - 2 * w->WindowPadding.x;
    if (w->ContentSize.x > room + w->WindowPadding.x + 1)
      all += name + " is " + std::to_string(int(room)) + " wide, and its words " +
             std::to_string(int(w->ContentSize.x)) + "\n";
  }
  return all;
}

struct Screens : Lessons, ::testing::WithParamInterface<std::tuple<std::pair<int, int>, const char*>> {};

TEST_P(Screens, MenusSettingsCardsAndTheEndOfTheHelpAreInside) {
  const auto& [size, language] = GetParam();
  const Words words = chosen_words({language, ""});
  const Lesson lesson = open_lesson(source_dir() + "/app/lessons/rhomboid.toml");
  std::vector<Command> script;
  for (const ScriptLine& l : load_script(source_dir() + "/recordings/rhomboid.jsonl").lines)
    script.push_back(l.command);
  const LessonPlan taught = make_lesson_plan(&lesson, script, words);
  Window w("", &taught);
  w.sized(size.first, size.second);
  const std::string in = std::string(language) + "-";
  const auto look = [&](const std::string& name) {
    w.settle();
    EXPECT_EQ(w.wrong(), "") << name;
    EXPECT_EQ(words_cut(), "") << name;
    w.shoot(in + name);
  };
  const auto click = [&](float x, float y) {
    WindowEvent e;
    e.x = x, e.y = y, e.kind = WindowEvent::pointer;
    w.router.take(e), w.settle();
    e.kind = WindowEvent::button, e.code = 0, e.down = 1, w.router.take(e), w.settle();
    e.down = 0, w.router.take(e), w.settle();
  };
  // The menus, one after the other.
  const auto menu = []() -> const ImGuiWindow* {
    for (const ImGuiWindow* k : ImGui::GetCurrentContext()->Windows)
      if (k->WasActive && !k->Hidden && (k->Flags & ImGuiWindowFlags_Popup)) return k;
    return nullptr;
  };
  std::set<int> menus;
  const float scale = float(size.first) / ImGui::GetIO().DisplaySize.x;
  click(14 * scale, 8 * scale);
  for (float x = 14; x < 420; x += 12) {
    WindowEvent e;
    e.x = x * scale, e.y = 8 * scale, e.kind = WindowEvent::pointer;
    w.router.take(e), w.settle();
    if (const ImGuiWindow* m = menu(); m && menus.insert(int(m->Pos.x)).second)
      look("menu-" + std::to_string(menus.size()));
  }
  EXPECT_EQ(menus.size(), 5u);
  w.key(WindowEvent::escape), w.key(WindowEvent::escape);
  click(0.5f * float(size.first), 0.6f * float(size.second));
  // What is chosen for the view and for the tools.
  ImGuiWindow* tools = ImGui::FindWindowByName("tools");
  ASSERT_NE(tools, nullptr);
  tools->StateStorage.SetInt(tools->GetID(words("View")), 1);
  for (const char key : {'2', '7', '4'}) w.key(key), look(std::string("settings-") + key);
  tools->StateStorage.SetInt(tools->GetID(words("View")), 0);
  w.key('1');
  // Every question of the lesson, and what is said when it was answered.
  const Coach* coach = w.frames->coach();
  int asked = 0;
  for (const PlannedAct& a : taught.acts) {
    if (coach->says().question) look("question-" + std::to_string(++asked));
    w.did(a.command, "done");
  }
  EXPECT_GE(asked, 1);
  w.key('U'), look("history"), w.key_alone('U', 0);
  w.key(WindowEvent::f1), w.settle();
  for (ImGuiWindow* k : ImGui::GetCurrentContext()->Windows)
    if (std::string(k->Name).find("Keys and mouse") != std::string::npos && k->ScrollMax.y > 0)
      ImGui::SetScrollY(k, k->ScrollMax.y);
  look("help-end");
}

INSTANTIATE_TEST_SUITE_P(InBothLanguages, Screens,
                         ::testing::Combine(::testing::Values(std::pair(800, 600), std::pair(1280, 720),
                                                              std::pair(3840, 2160)),
                                            ::testing::Values("en", "de")));

TEST_F(Lessons, TheFontHasEverySignOfTheGermanTable) {
  Window w;
  const ImFont* font = ImGui::GetFont();
  std::set<unsigned> lacks;
  for (const PoEntry& e : read_po(source_dir() + "/app/words/de.po").entries)
    for (const std::string& form : e.forms)
      for (const char* at = form.c_str(); *at;) {
        unsigned sign = 0;
        at += ImTextCharFromUtf8(&sign, at, nullptr);
        if (sign >= 32 && !font->FindGlyphNoFallback(ImWchar(sign))) lacks.insert(sign);
      }
  EXPECT_TRUE(font->FindGlyphNoFallback(0x202f)) << "the thin space before units";
  std::string all;
  for (const unsigned sign : lacks) all += std::to_string(sign) + " ";
  EXPECT_EQ(all, "");
}

TEST_F(Lessons, TheTourIsShownOnceAndWhatWasChosenIsRemembered) {
  const TemporaryFolder folder;
  const std::string file = folder.path().string() + "/limberg/window.toml";
  {
    Window w(file);
    EXPECT_FALSE(w.wrong().size()) << w.wrong();
    w.shoot("tour");
    w.feed.seen.update();
    EXPECT_TRUE(w.feed.seen.reading().tour);
    EXPECT_FALSE(w.feed.seen.reading().typing) << "what a card asks for is done by the keys of the session";
    for (int card = 1; card <= DeskTour::kCards; ++card) {
      EXPECT_EQ(w.wrong(), "") << card;
      const bool small = card % 2 == 1;
      w.sized(small ? 800 : 1280, small ? 600 : 720);
      EXPECT_EQ(w.wrong(), "") << card;
      w.key(WindowEvent::enter), w.settle();
    }
    w.feed.seen.update();
    EXPECT_FALSE(w.feed.seen.reading().tour);
    w.key('=', WindowEvent::control), w.key('K', WindowEvent::control);
  }
  const DeskMemory kept = read_desk_memory(file);
  EXPECT_TRUE(kept.toured);
  EXPECT_EQ(kept.letters_percent, 125);
  EXPECT_EQ(kept.colours, DeskColours::light);
  Window again(file);
  again.feed.seen.update();
  EXPECT_FALSE(again.feed.seen.reading().tour) << "the tour is not shown twice";
}

TEST_F(Lessons, TheToolThatIsSeenIsTheToolInUse) {
  Window w;
  w.key('S'), w.key('S');  // one quality, whatever the machine's speed
  ToolState hand;
  hand.valid = 1, hand.tip_mm[0] = -2, hand.tip_mm[1] = -22, hand.tip_mm[2] = 2;
  hand.shaft[0] = 0.45, hand.shaft[1] = -0.5, hand.shaft[2] = 0.74;
  const auto seen_with = [&](Tool tool, int bites) {
    hand.tool = int32_t(tool), hand.bites = bites;
    hand.bite_mm[0][0] = -12, hand.bite_mm[0][1] = -16, hand.bite_mm[0][2] = 0;
    w.feed.showing = true;  // a hand that is not the mouse's
    for (int i = 0; i < 3; ++i) w.frames->wants_frame(), w.frames->frame(w.s, hand);
    w.shoot("tool-" + std::to_string(int(tool)) + (bites > 0 ? "-thread" : ""));
    return w.frames->picture();
  };
  const auto apart = [](const Image& a, const Image& b) {  // of the patient alone
    int n = 0;
    for (int y = 120; y < 560; ++y)
      for (int x = 180; x < 1000; ++x) n += !(a.at(x, y) == b.at(x, y));
    return n;
  };
  std::vector<Image> seen;
  for (const Tool tool : {Tool::scalpel, Tool::undermine, Tool::hook, Tool::suture, Tool::scissors, Tool::marker,
                          Tool::swab, Tool::none}) {
    seen.push_back(seen_with(tool, 0));
    for (size_t k = 0; k + 1 < seen.size(); ++k) EXPECT_GT(apart(seen[k], seen.back()), 300) << int(tool) << " " << k;
  }
  EXPECT_GT(apart(seen[3], seen_with(Tool::suture_corner, 1)), 60) << "the thread of a stitch that is begun";
}

TEST_F(Lessons, KeysAloneLeadTheToolAndPressIt) {
  Window w;
  WindowEvent e;
  e.x = 600, e.y = 300;
  w.router.take(e), w.settle();
  for (HandInput i; w.feed.input.pop(i);) {
  }
  w.key('2');
  for (int i = 0; i < 5; ++i) w.key(WindowEvent::arrow_right);
  w.key(WindowEvent::enter);
  for (int i = 0; i < 10; ++i) w.key(WindowEvent::arrow_down, WindowEvent::shift);
  w.key(WindowEvent::enter);
  int presses = 0, releases = 0;
  Vec3f pressed_at = Vec3f::Zero(), released_at = Vec3f::Zero();
  bool down = false;
  for (HandInput i; w.feed.input.pop(i);)
    if (const auto* p = std::get_if<PointerReading>(&i)) {
      if (p->pressed && !down) ++presses, pressed_at = p->towards;
      if (!p->pressed && down) ++releases, released_at = p->towards;
      down = p->pressed;
    }
  EXPECT_EQ(presses, 1);
  EXPECT_EQ(releases, 1);
  w.feed.seen.update();
  const View& v = w.feed.seen.reading().view;
  EXPECT_LT((pressed_at - v.ray_through(640, 300, 1280, 720)).norm(), 1e-5f);
  EXPECT_LT((released_at - v.ray_through(640, 310, 1280, 720)).norm(), 1e-5f);
}

TEST_F(Lessons, TheSliderOfActsAsksForUndoAndRedo) {
  Window w;
  for (int i = 0; i < 4; ++i) w.did(Excise{{{0, 0}, {9, 0}, {0, 9}}, 4}, "excise");
  w.key('U');
  const auto controls = [&] {
    int undo = 0, redo = 0;
    for (HandInput i; w.feed.input.pop(i);)
      if (const auto* c = std::get_if<ControlSample>(&i))
        undo += c->kind == ControlSample::undo, redo += c->kind == ControlSample::redo;
    return std::pair(undo, redo);
  };
  controls();
  // The picture of the first act, from the left: that before any is the one before it.
  const DeskLayout l = desk_layout(1280, 720, true);
  WindowEvent e;
  e.x = l.history.x0 + 9 + DeskHistory::kPictureWidth + 6 + 40, e.y = l.history.y0 + 60;
  const auto click = [&] {
    e.kind = WindowEvent::pointer, w.router.take(e), w.settle();
    e.kind = WindowEvent::button, e.code = 0, e.down = 1, w.router.take(e), w.settle();
    e.down = 0, w.router.take(e), w.settle();
  };
  click();
  EXPECT_EQ(controls(), std::pair(3, 0));
  Notice back;
  back.kind = Notice::undone;
  for (int i = 0; i < 3; ++i) w.frames->notice(back);
  e.x += 2 * (DeskHistory::kPictureWidth + 6);
  click();
  EXPECT_EQ(controls(), std::pair(0, 2));
}

}  // namespace test_layouts
}  // namespace limberg
