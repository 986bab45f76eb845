// Lessons, orders of closure and the figures of a hand.
#include <gtest/gtest.h>

#include <filesystem>

#include "app/assembly/exercise.h"
#include "app/assembly/orders.h"
#include "app/program/places.h"
#include "app/scene/scene.h"
#include "sim/base/error.h"
#include "sim/commands/procedures/operation.h"
#include "tests/sim/commands/shipped_scripts.h"

namespace limberg {
namespace test_exercise {

const std::string kLesson = R"(lesson = "A Z"
goal = "Lengthen it."
scene = "zplasty"
hints = ["slowly"]
[procedure]
name = "z_plasty"
at_mm = [1, -2]
[procedure.values]
limb_mm = 18
[tolerance]
corner_mm = 2
gap_mm = 0.2
undos = 3
[landmarks]
lid = [0, 30]
)";

std::string changed(const std::string& from, const std::string& to) {
  std::string s = kLesson;
  const size_t at = s.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return s.replace(at, from.size(), to);
}

void expect_bad(const std::string& text, int line, const std::string& word) {
  try {
    parse_lesson(text, "l.toml");
    ADD_FAILURE() << "taken: " << word;
  } catch (const InputError& e) {
    const std::string what = e.what();
    const std::string place = line > 0 ? "l.toml:" + std::to_string(line) + ":" : "l.toml";
    EXPECT_NE(what.find(place), std::string::npos) << what;
    EXPECT_NE(what.find(word), std::string::npos) << what;
  }
}

TEST(Lesson, IsReadStrictly) {
  const Lesson l = parse_lesson(kLesson, "l.toml");
  EXPECT_EQ(l.plan->procedure, "z_plasty");
  ASSERT_EQ(l.plan->values.size(), 1u);
  EXPECT_EQ(l.plan->values[0].second, 18);
  EXPECT_EQ(l.plan->at, ChartPoint(1, -2));
  EXPECT_EQ(l.tolerances.size(), 3u);
  ASSERT_EQ(l.landmarks.size(), 1u);
  EXPECT_TRUE(looks_like_lesson(kLesson));
  EXPECT_EQ(made_for_another(l, l.scene, "anywhere.toml"), "");
  EXPECT_EQ(made_for_another(l, "of mine", "/home/me/" + l.scene + ".toml"), "");
  EXPECT_NE(made_for_another(l, "scalp", "app/scenes/scalp.toml").find("not for scalp"), std::string::npos);
  expect_bad(changed("goal = \"Lengthen it.\"\n", ""), 0, "goal");
  expect_bad(changed("z_plasty", "w_plasty"), 6, "w_plasty");
  expect_bad(changed("limb_mm = 18", "limb_mm = 1800"), 9, "limb_mm");
  expect_bad(changed("limb_mm = 18", "length = 18"), 9, "length");
  expect_bad(changed("gap_mm = 0.2", "gap_mm = \"small\""), 12, "gap_mm");
  expect_bad(changed("undos = 3", "grade = 3"), 13, "grade");
  expect_bad(changed("lid = [0, 30]", "lid = 30"), 15, "lid");
  expect_bad(changed("[tolerance]", "[tolerance"), 10, "TOML");
}

// An operation that is no figure of the repertoire: no corners to judge, all that is measured.
TEST(Lesson, MayHaveItsScriptForAPlan) {
  const std::string figure = "[procedure]\nname = \"z_plasty\"\nat_mm = [1, -2]\n[procedure.values]\nlimb_mm = 18\n";
  expect_bad(changed(figure, ""), 0, "by_script");
  const std::string alone = changed(figure, "by_script = true\n");
  expect_bad(alone, 7, "corner_mm");
  std::string s = alone;
  s.erase(s.find("corner_mm = 2\n"), 14);
  const Lesson l = parse_lesson(s, "l.toml");
  EXPECT_TRUE(l.by_script);
  EXPECT_FALSE(l.plan);
  EXPECT_EQ(l.tolerances.size(), 2u);
  expect_bad(changed("hints = [", "by_script = true\nhints = ["), 4, "stands beside [procedure]");
  expect_bad(changed("hints = [", "by_script = 1\nhints = ["), 4, "by_script");
}

TEST(Lesson, ShippedOnesFitTheirScenesAndTheirScripts) {
  for (const std::string name : {"rhomboid", "zplasty"}) {
    const Lesson l = open_lesson(source_dir() + "/app/lessons/" + name + ".toml");
    const Skin skin(build_body(load_scene(source_dir() + "/app/scenes/" + l.scene + ".toml")));
    const PlanOnSkin plan = plan_on(skin, *l.plan);
    std::vector<Command> script;
    for (const ScriptLine& s : test::shipped_script(name).lines) script.push_back(s.command);
    const auto e = design_error(plan, script);
    ASSERT_TRUE(e) << name;
    EXPECT_TRUE(e->missing.empty()) << name;
    EXPECT_LT(e->corner_max_mm, 0.01) << name;  // coordinates of scripts are rounded to 1/1000 mm
    EXPECT_LT(e->angle_max_deg, 0.05) << name;
    EXPECT_LT(e->limb_max_percent, 0.05) << name;
    // One corner of an incision moved by 3 mm.
    for (Command& c : script)
      if (auto* i = std::get_if<Incise>(&c)) {
        i->path[1] += Vec2(3, 0);
        break;
      }
    const auto off = design_error(plan, script);
    EXPECT_NEAR(off->corner_max_mm, 3, 0.02) << name;
    EXPECT_GT(off->angle_max_deg, 3) << name;
    EXPECT_GT(off->limb_max_percent, 3) << name;
  }
}

// Those on a face, in the scenes whose chart looks at it from the side as well: what the script cuts is what the lesson
// asks for. A corner that is moved by 3 mm is found.
TEST(Lesson, ThoseOnAFaceAskForWhatTheirScriptsCut) {
  for (const std::string name : {"nose-bilobed", "nose-nasolabial", "cheek-cervicofacial", "cheek-keystone",
                                 "forehead-o-to-z", "forehead-rotation"}) {
    SCOPED_TRACE(name);
    const Lesson l = open_lesson(source_dir() + "/app/lessons/" + name + ".toml");
    const Skin skin(build_body(load_scene(source_dir() + "/app/scenes/" + l.scene + ".toml")));
    const PlanOnSkin plan = plan_on(skin, *l.plan);
    std::vector<Command> script;
    for (const ScriptLine& s : test::shipped_script(name).lines) script.push_back(s.command);
    const auto e = design_error(plan, script);
    ASSERT_TRUE(e);
    EXPECT_TRUE(e->missing.empty());
    for (const Judgement& j : judge(l, lesson_values(Metrics{}, e))) {
      if (j.name != "corner_mm" && j.name != "angle_deg" && j.name != "limb_percent") continue;
      EXPECT_TRUE(j.met) << j.name << " " << j.value.value_or(-1);
    }
    for (Command& c : script)
      if (auto* i = std::get_if<Incise>(&c)) i->path.front() += Vec2(3, 0);
    EXPECT_GT(design_error(plan, script)->corner_max_mm, 1);
  }
}

TEST(Exercise, CutsAreComparedWithANamedPlanAlone) {
  const Lesson l = open_lesson(source_dir() + "/app/lessons/rhomboid.toml");
  const Skin skin(build_body(load_scene(source_dir() + "/app/scenes/" + l.scene + ".toml")));
  std::vector<Command> script;
  for (const ScriptLine& s : test::shipped_script("rhomboid").lines) script.push_back(s.command);
  const std::optional<PlanOnSkin> read_off = plan_of(skin, {}, script);
  ASSERT_TRUE(read_off) << "the rhombic flap that the cuts draw";
  EXPECT_FALSE(exercise(script, {}, read_off).design) << "the cuts would be compared with another flap elsewhere";
  const auto named = exercise(script, {}, plan_on(skin, *l.plan)).design;
  ASSERT_TRUE(named);
  EXPECT_EQ(named->corners, 7);
  EXPECT_TRUE(named->missing.empty());
}

TEST(Lesson, TellsWhatIsMet) {
  const Lesson l = parse_lesson(kLesson, "l.toml");
  const auto j = judge(l, {{{"corner_mm", 1.9}, {"gap_mm", 0.3}}, {{"undos", "nobody counted them"}}});
  ASSERT_EQ(j.size(), 3u);
  EXPECT_TRUE(j[0].met);
  EXPECT_FALSE(j[1].met);
  EXPECT_FALSE(j[2].met);
  EXPECT_FALSE(j[2].value);  // not measured is not met
  EXPECT_EQ(j[0].why, "");
  EXPECT_EQ(j[1].why, "");
  EXPECT_EQ(j[2].why, "nobody counted them");
  const auto broken = judge(l, {{{"corner_mm", std::nan("")}}, {}});
  for (const Judgement& b : broken) {
    EXPECT_FALSE(b.value) << b.name;
    EXPECT_NE(b.why, "") << b.name;  // whatever is not measured says why
  }
}

// What could not be measured says what was looked for, where, and what was found.
TEST(Lesson, SaysWhyAFigureIsNotMeasured) {
  const Lesson l = open_lesson(source_dir() + "/app/lessons/rhomboid.toml");
  const Skin skin(build_body(load_scene(source_dir() + "/app/scenes/" + l.scene + ".toml")));
  const PlanOnSkin plan = plan_on(skin, *l.plan);
  std::vector<Command> drawn;
  for (const ScriptLine& s : test::shipped_script("rhomboid").lines) drawn.push_back(s.command);
  const auto why = [&](const std::vector<Command>& script, const Metrics& m, const char* name) {
    const LessonValues v = lesson_values(m, design_error(plan, script));
    EXPECT_FALSE(v.value.contains(name)) << name;
    return v.why_not.contains(name) ? v.why_not.at(name) : std::string();
  };
  const auto holds = [](const std::string& text, const std::vector<std::string>& words) {
    for (const std::string& w : words) EXPECT_NE(text.find(w), std::string::npos) << w << " in: " << text;
  };
  // The flap cut elsewhere: moved by 31 mm, so that the end of its second side lies farthest from its place.
  std::vector<Command> elsewhere = drawn;
  for (Command& c : elsewhere)
    if (auto* i = std::get_if<Incise>(&c))
      for (ChartPoint& p : i->path) p += Vec2(31, 0);
  const auto e = design_error(plan, elsewhere);
  ASSERT_FALSE(e->missing.empty());
  const auto planned =
      std::find_if(drawn.begin(), drawn.end(), [](const Command& c) { return std::holds_alternative<Incise>(c); });
  for (const MissingCorner& c : e->missing) {
    EXPECT_FALSE(c.outline);
    const auto& path = std::get<Incise>(*planned).path;
    EXPECT_TRUE(std::any_of(path.begin(), path.end(), [&](const ChartPoint& p) {
      return (p - c.planned).norm() < 0.01;
    })) << c.planned.transpose();
    ASSERT_TRUE(c.nearest);
    for (const ChartPoint& p : path)
      EXPECT_GE((p + Vec2(31, 0) - c.planned).norm(), (*c.nearest - c.planned).norm() - 1e-9);  // none is nearer
  }
  for (const char* name : {"corner_mm", "angle_deg", "limb_percent"})
    holds(why(elsewhere, {}, name),
          {std::to_string(e->missing.size()) + " of the plan's " + std::to_string(e->corners) + " corners",
           "within 10 mm", "incision at (", "mm away"});
  // No flap at all; nothing at all.
  std::vector<Command> none = drawn;
  std::erase_if(none, [](const Command& c) { return std::holds_alternative<Incise>(c); });
  holds(why(none, {}, "corner_mm"), {"no incision was drawn"});
  holds(why({}, {}, "corner_mm"), {"nothing was excised or incised"});
  holds(why({}, {}, "gap_mm"), {"stitches", "none"});
  // A landmark whose skin is gone has not stayed where it was.
  Metrics m;
  m.landmarks.push_back({"lid", {3, 40}, LandmarkFigure{}});
  m.landmarks.push_back({"ala", {3, 4}, std::nullopt});
  holds(why({}, m, "landmark_mm"), {"skin of ala", "(3.0, 4.0) mm"});
  m.landmarks.pop_back();
  EXPECT_TRUE(lesson_values(m, {}).value.contains("landmark_mm"));
}

// Stitches are those that hold at the end: one that was refused, cut or undone is none.
TEST(Exercise, StitchesAreThoseThatAreThere) {
  Metrics m;
  m.sutures.resize(2);
  const std::vector<Command> script{Suture{{0, 1}, {0, -1}}, Undo{}, Suture{{3, 1}, {3, -1}}, Suture{{6, 1}, {6, -1}},
                                    Suture{{9, 1}, {9, -1}}};
  EXPECT_EQ(exercise(script, m, {}).stitches, 2);
  EXPECT_EQ(exercise({}, m, {}).stitches, 2);
}

// Who looks back in the history and comes forth again has taken nothing back.
TEST(Exercise, WhatIsDoneAgainWasNotTakenBack) {
  const Suture s{{0, 1}, {0, -1}};
  const Exercise looked = exercise(std::vector<Command>{s, Undo{}, Redo{}, s}, {}, {});
  EXPECT_EQ(looked.undos, 0);
  EXPECT_EQ(looked.redos, 1);
  EXPECT_EQ(exercise(std::vector<Command>{s, Undo{}, Redo{}, Undo{}}, {}, {}).undos, 1);
}

// What only a hand can miss is not held against a script that was carried out without one.
TEST(Lesson, AScriptIsNotJudgedByTheHandsTolerances) {
  Lesson l = parse_lesson(kLesson, "l.toml");
  l.tolerances = {{"time_s", 600}, {"movements", 100}, {"undos", 3}};
  Exercise e;
  Result r("operate", "s");
  const auto script = fill_exercise(r, e, lesson_values({}, {}), &l);
  ASSERT_EQ(script.size(), 1u);
  EXPECT_EQ(script[0].name, "undos");
  EXPECT_TRUE(script[0].met);
  e.hand.emplace();
  e.hand->movements = 120;
  const auto hand = fill_exercise(r, e, lesson_values({}, {}), &l);
  ASSERT_EQ(hand.size(), 3u);
  EXPECT_FALSE(hand[0].met);  // a session without its time
  EXPECT_FALSE(hand[1].met);
}

Script five() {
  std::string text = "{\"limberg_script\":1,\"scene\":\"s\"}\n";
  for (int i = 1; i <= 5; ++i)
    text += "{\"action\":\"suture\",\"a\":[" + std::to_string(i) +
            ",0],\"b\":[0,0]}\n{\"action\":\"wait\",\"seconds\":0}\n";
  return parse_script(text, "five");
}

std::vector<int> order_of(const Script& s) {
  std::vector<int> out;
  for (const ScriptLine& l : s.lines)
    if (const auto* k = std::get_if<Suture>(&l.command)) out.push_back(int(k->a.x()));
  return out;
}

TEST(Orders, MoveStitchesAmongTheirLines) {
  EXPECT_EQ(order_of(reordered(five(), "as-written")), (std::vector<int>{1, 2, 3, 4, 5}));
  EXPECT_EQ(order_of(reordered(five(), "reversed")), (std::vector<int>{5, 4, 3, 2, 1}));
  EXPECT_EQ(order_of(reordered(five(), "alternating")), (std::vector<int>{1, 5, 2, 4, 3}));
  EXPECT_EQ(order_of(reordered(five(), "3-1-2-5-4")), (std::vector<int>{3, 1, 2, 5, 4}));
  for (const char* bad : {"backwards", "1-2-3", "1-1-2-3-4", "1-2-3-4-6", "", "1-2-3-4-5-"})
    EXPECT_THROW(reordered(five(), bad), InputError) << bad;
  Script s = five();
  s.lines.push_back({99, Undo{}});
  EXPECT_THROW(reordered(s, "reversed"), InputError);
}

TEST(HandMotion, CountsPathMovementsAndGaps) {
  HandMotion h;
  ToolState tool;
  const double dt = 1.0 / 62;
  double t = 0, x = 0;
  const auto go = [&](double seconds, double speed, bool valid = true) {
    for (const double end = t + seconds; t < end - 1e-9; t += dt) {
      x += speed * dt;
      tool.tip_mm[0] = x, tool.valid = valid, tool.pressed = speed > 50;
      h.add(t, tool);
    }
  };
  go(0.5, 0, false);  // before the tracker sees anything there is no gap
  EXPECT_EQ(h.figures().gaps, 0);
  go(1, 0);
  go(1, 100);
  go(1, 0);
  go(0.3, 20);  // slow: no movement
  go(0.5, 0);
  go(0.5, 0, false);
  go(1, 60);
  const HandFigures& f = h.figures();
  EXPECT_EQ(f.movements, 2);
  EXPECT_EQ(f.gaps, 1);
  EXPECT_NEAR(f.lost_s, 0.5, 2 * dt);
  EXPECT_NEAR(f.path_mm, 100 + 6 + 60, 5);
  EXPECT_NEAR(f.pressed_s, 2, 4 * dt);
}

}  // namespace test_exercise
}  // namespace limberg
