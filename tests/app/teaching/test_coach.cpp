// A coach without a patient: what it says of acts against the plan of the shipped lessons.
#include <gtest/gtest.h>

#include <cmath>

#include "app/assembly/cases.h"
#include "app/assembly/exercise.h"
#include "app/program/places.h"
#include "app/teaching/coach.h"
#include "app/teaching/why_missed.h"
#include "sim/commands/kinds.h"
#include "sim/commands/script.h"
#include "sim/commands/strokes.h"

namespace limberg {
namespace test_coach {

std::vector<Command> commands_of(const std::string& file) {
  std::vector<Command> all;
  for (const ScriptLine& l : load_script(file).lines) all.push_back(l.command);
  return all;
}

LessonPlan shipped(const std::string& name) {
  const Lesson l = open_lesson(source_dir() + "/app/lessons/" + name + ".toml");
  return make_lesson_plan(&l, commands_of(source_dir() + "/recordings/" + name + ".jsonl"));
}

/// Tells a coach what the patient did, one act a second.
struct Session {
  Coach coach;
  double t_s = 0;
  explicit Session(const std::string& name, LessonMode mode = LessonMode::guided) : coach(shipped(name), mode) {}
  void notice(int32_t kind, const Command& c, const std::string& text = "") {
    Notice n;
    n.kind = kind, n.t_s = t_s += 1, n.command = std::make_shared<const Command>(c);
    Notice::put(n.text, text);
    coach.hear(n);
  }
  std::string act(const Command& c) {
    const size_t before = coach.said().size();
    notice(std::holds_alternative<Undo>(c)   ? Notice::undone
           : std::holds_alternative<Redo>(c) ? Notice::redone
                                             : Notice::done,
           c);
    std::string words;
    for (size_t i = before; i < coach.said().size(); ++i) words += coach.said()[i].word;
    return words;
  }
  void wait(double seconds) {
    t_s += seconds;
    Snapshot s;
    s.device_tick = int64_t(t_s * 1000);
    coach.look(s, {});
  }
  const Command& planned(size_t i) { return coach.plan().acts[i].command; }
};

::testing::AssertionResult says(const std::string& words, const std::string& part) {
  if (words.find(part) != std::string::npos) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << "\"" << part << "\" was expected in: " << words;
}
#define EXPECT_SAYS(words, part) EXPECT_TRUE(says(words, part))

TEST(LessonPlan, HasStepsOfTheScriptsStagesAndLettersOfItsCorners) {
  const LessonPlan p = shipped("rhomboid");
  ASSERT_EQ(p.steps.size(), 7u);
  EXPECT_EQ(p.steps[1].words.stage, "flap cut");
  EXPECT_EQ(p.steps[0].acts, 1u);
  ASSERT_EQ(p.letters.size(), 6u);
  EXPECT_EQ(p.letters[3].letter, 'D');  // the defect's corner from which the flap goes on
  EXPECT_NEAR(p.letters[3].at.norm(), 0, 1e-9);
  EXPECT_SAYS(p.acts[1].words, "D, E, F");
  EXPECT_SAYS(p.acts[1].words, "40 mm");
  EXPECT_EQ(near_letter(p.letters, {0.5, 0.5}), "D");
  EXPECT_EQ(near_letter(p.letters, {8.6, -5}), "the line DE");
  EXPECT_EQ(near_letter(p.letters, {300, 0}), "");
}

TEST(LessonPlan, EveryShippedLessonSaysWhyAtEachOfItsSteps) {
  for (const Case& c : shipped_cases()) {
    const LessonPlan p = make_lesson_plan(&c.lesson, commands_of(c.script));
    EXPECT_FALSE(p.steps.empty()) << c.name;
    for (const TeachingStep& s : p.steps) {
      EXPECT_FALSE(s.words.why.empty()) << c.name << ": " << s.words.stage;
      EXPECT_FALSE(s.words.say.empty()) << c.name << ": " << s.words.stage;
    }
    for (const LessonStep& s : c.lesson.words.steps)
      EXPECT_TRUE(std::any_of(p.steps.begin(), p.steps.end(), [&](const auto& t) { return t.words.stage == s.stage; }))
          << c.name << " has words for \"" << s.stage << "\", which its script does not reach";
    EXPECT_TRUE(std::any_of(p.steps.begin(), p.steps.end(), [](const auto& t) { return t.words.question.has_value(); }))
        << c.name;
  }
}

// The script itself is the plan done well: nothing is off, nothing stray, nothing left.
TEST(Coach, FindsNothingToMendWhereTheScriptIsDone) {
  for (const Case& c : shipped_cases()) {
    Coach coach(make_lesson_plan(&c.lesson, commands_of(c.script)));
    double t_s = 0;
    for (const Command& k : commands_of(c.script)) {
      Notice n;
      n.t_s = t_s += 1, n.command = std::make_shared<const Command>(k);
      coach.hear(n);
    }
    EXPECT_TRUE(coach.says().finished) << c.name << ", open: " << coach.progress().next;
    EXPECT_TRUE(coach.progress().stray.empty()) << c.name;
    for (const ActProgress& a : coach.progress().act) {
      EXPECT_EQ(a.state, ActProgress::done) << c.name;
      EXPECT_TRUE(within(a.offs)) << c.name << ": " << (a.offs.empty() ? "" : a.offs[0].words);
    }
    for (const StepSeen& s : coach.says().steps) EXPECT_EQ(s.state, StepSeen::done) << c.name << ": " << s.name;
    for (const std::string& b : coach.present().better)
      EXPECT_EQ(b.find("\""), std::string::npos) << c.name << ": " << b;
  }
}

TEST(Coach, SaysWhatIsOffAndHowMuch) {
  Session s("rhomboid");
  s.act(s.planned(0));
  EXPECT_SAYS(s.act(Incise{{{0, 0}, {15, -8.66}}, 4, 90, false}), "23 mm too short");
  s.act(Undo{});
  EXPECT_EQ(s.coach.progress().next, 1u);
  // As long as planned, and turned at E by 90 degrees instead of 60.
  const Vec2 e(17.321, -10), along = e.normalized(), across(along.y(), -along.x());
  const std::string turned = s.act(Incise{{{0, 0}, e, e + 20 * across}, 4, 90, false});
  EXPECT_SAYS(turned, "angle at E is 90");
  EXPECT_SAYS(turned, "planned 60");
  s.act(Undo{});
  auto deep = std::get<Incise>(s.planned(1));
  deep.depth_mm = 7;
  EXPECT_SAYS(s.act(deep), "3.0 mm deeper than planned (4 mm)");
  s.act(Undo{});
  auto leaning = std::get<Incise>(s.planned(1));
  leaning.angle_deg = 60;
  EXPECT_SAYS(s.act(leaning), "leans 30");
  s.act(Undo{});
  auto aside = std::get<Incise>(s.planned(1));
  for (ChartPoint& p : aside.path) p += ChartPoint(3, 3);
  EXPECT_SAYS(s.act(aside), "mm off at ");
  s.act(Undo{});
  EXPECT_SAYS(s.act(Incise{{{-60, 40}, {-40, 40}}, 4, 90, false}), "elsewhere than planned");
  EXPECT_EQ(s.coach.progress().stray.size(), 1u);
  s.act(Undo{});
  auto back = std::get<Incise>(s.planned(1));  // drawn the other way: as good
  std::reverse(back.path.begin(), back.path.end());
  EXPECT_SAYS(s.act(back), "As planned");
}

// A cut that opens while it is drawn is one act, looked at when it ends.
TEST(Coach, PiecesOfAStrokeAreOneCut) {
  Session s("rhomboid");
  s.act(s.planned(0));
  const auto& path = std::get<Incise>(s.planned(1)).path;
  EXPECT_EQ(s.act(InciseMore{1, {path[0], 0.5 * (path[0] + path[1])}, 4, 90, false}), "");
  EXPECT_EQ(s.coach.progress().next, 1u);
  EXPECT_EQ(s.act(InciseMore{1, {path[1]}, 4, 90, false}), "");
  EXPECT_SAYS(s.act(InciseMore{1, {path[2]}, 4, 90, true}), "As planned");
  EXPECT_EQ(s.coach.progress().next, 2u);
}

TEST(Coach, WarnsOfAWrongOrderWithTheReason) {
  Session s("rhomboid");
  const std::string words = s.act(s.planned(1));
  EXPECT_SAYS(words, "Out of order: \"defect\" comes before \"flap cut\", for this reason: ");
  EXPECT_EQ(s.coach.progress().next, 0u);
  EXPECT_SAYS(s.act(Suture{{5, 5}, {5, 7}}), "elsewhere than planned");
}

TEST(Coach, AStrokeIsComparedWhileItIsDrawn) {
  const LessonPlan p = shipped("rhomboid");
  LiveStroke stroke;
  for (int i = 0; i <= 10; ++i) stroke.path.push_back(ChartPoint(17.321, -10) * (0.1 * i));
  stroke.depth_mm = 6, stroke.angle_deg = 90;
  const std::vector<size_t> open{0, 1, 2};
  const PlannedAct* a = meant(p, open, Incise{}, stroke);
  ASSERT_EQ(a, &p.acts[1]);
  const std::vector<LiveRow> rows = live_rows(p, *a, stroke);
  ASSERT_EQ(rows.size(), 5u);
  EXPECT_EQ(rows[0].words, "20 of 40 mm");
  EXPECT_LE(rows[0].share, 1);
  EXPECT_NEAR(rows[1].share, 0, 0.01);  // on the line
  EXPECT_NEAR(rows[2].share, 0, 0.01);  // along it
  EXPECT_NEAR(rows[3].share, 2, 1e-9);  // 6 mm deep instead of 4, 1 mm may be off
  // Turned by 40 degrees about D: told as a direction, and soon as off the line.
  LiveStroke off;
  const Eigen::Rotation2Dd turn(40 * M_PI / 180);
  for (const ChartPoint& q : stroke.path) off.path.push_back(turn * q);
  const std::vector<LiveRow> bad = live_rows(p, p.acts[1], off);
  EXPECT_EQ(bad[2].words, "40° off");
  EXPECT_GT(bad[1].share, 1);
}

TEST(Coach, HintsComeWhenTheHandIsStillAndGoWhenItActs) {
  Session s("rhomboid");
  s.coach.answer(1);  // the question before the first step, if there is one
  s.act(s.planned(0));
  s.coach.answer_place({0, 0});
  s.wait(5);
  EXPECT_EQ(s.coach.says().hint, "");
  s.wait(12);
  const std::string first = s.coach.says().hint;
  EXPECT_NE(first, "");
  s.wait(15);
  EXPECT_GT(s.coach.says().hint.size(), first.size());
  EXPECT_SAYS(s.coach.says().hint, "D, E, F");
  s.wait(15);
  EXPECT_SAYS(s.coach.says().hint, "N shows it");
  s.act(s.planned(1));
  s.coach.answer(1);
  s.wait(1);
  EXPECT_EQ(s.coach.says().hint, "");
}

TEST(Coach, AnExaminationSaysNothingOfThePlanAndShowsNothing) {
  Session s("rhomboid", LessonMode::examination);
  EXPECT_EQ(s.coach.says().say, "");
  EXPECT_NE(s.coach.says().goal, "");
  EXPECT_EQ(s.act(Incise{{{0, 0}, {10, 0}}, 9, 90, false}), "");
  EXPECT_TRUE(s.coach.showing(false).acts.empty());
  s.wait(100);
  EXPECT_EQ(s.coach.says().hint, "");
  s.coach.set_mode(LessonMode::guided);
  EXPECT_EQ(s.coach.mode(), LessonMode::examination);
  MissedPress m;
  m.tool = int32_t(Tool::scalpel);
  s.coach.missed(m, Snapshot{});
  EXPECT_SAYS(s.coach.says().word, "beside the patient");  // why a press did nothing is said all the same
}

// Which of two hooks goes first is of no weight; a hook before a cut is.
TEST(Coach, HooksGoInAnyOrderAmongThemselves) {
  Session s("zplasty");
  size_t i = 0;
  for (; !is_of_hooks(s.planned(i)); ++i) s.act(s.planned(i));
  size_t last = i;
  while (is_of_hooks(s.planned(last + 1))) ++last;
  ASSERT_GT(s.coach.plan().acts[last].step, s.coach.plan().acts[i].step);
  EXPECT_EQ(s.act(s.planned(i)).find("Out of order"), std::string::npos);
  EXPECT_EQ(s.act(s.planned(last)).find("Out of order"), std::string::npos);
  Session early("zplasty");
  const std::string told = early.act(s.planned(last));
  EXPECT_SAYS(told, "Out of order");
  EXPECT_SAYS(told, "Take its handle and carry it back");  // undo goes past hooks
}

// Who looks back in the history and comes forth again has taken nothing back.
TEST(Coach, WhatIsDoneAgainWasNotTakenBack) {
  const auto taken_back = [](const Session& s) -> std::string {
    for (const auto& r : s.coach.present().rows)
      if (r.what == words_of_tolerance("undos")) return r.value.substr(0, r.value.find(','));
    return "";
  };
  Session s("rhomboid");
  s.act(s.planned(0)), s.act(s.planned(1));
  s.act(Undo{}), s.act(Undo{});
  EXPECT_EQ(taken_back(s), "2");
  s.act(Redo{}), s.act(Redo{});
  EXPECT_EQ(taken_back(s), "0");
  s.act(Undo{});
  EXPECT_EQ(taken_back(s), "1");
}

TEST(Coach, WhatIsShownIsMarkedAndNotJudged) {
  Session s("rhomboid");
  s.act(Shown{true});
  EXPECT_EQ(s.act(s.planned(0)), "");
  s.act(Shown{false});
  EXPECT_EQ(s.coach.says().steps[0].state, StepSeen::shown);
  EXPECT_EQ(s.coach.says().step, 1u);
  const Attempt a = s.coach.present();
  EXPECT_EQ(a.rows[0].value, "was shown");
  EXPECT_FALSE(a.rows[0].judged);
  EXPECT_TRUE(a.cuts.empty());
}

TEST(Coach, ShowsFromWhatWasDoneOrFromThePlan) {
  Session s("rhomboid");
  s.act(s.planned(0));
  // The learner's defect stands: it is not excised again.
  EXPECT_TRUE(std::holds_alternative<Incise>(s.coach.showing(false).acts.at(0)));
  EXPECT_EQ(s.coach.showing(true).undos, 0);
  s.act(Incise{{{-60, 40}, {-40, 40}}, 4, 90, false});  // stray
  s.act(SetHook{7, {14.3, -10}});
  EXPECT_EQ(s.coach.showing(false).undos, 0);
  const Showing clean = s.coach.showing(true);
  EXPECT_EQ(clean.undos, 1);  // the hook is no entry of the history: it goes with the cut
  EXPECT_TRUE(std::holds_alternative<Incise>(clean.acts.at(0)));
}

TEST(Coach, WhatIsShownLiesAsTheLearnersCutsDo) {
  Session s("rhomboid");
  const Eigen::Rotation2Dd turn(8 * M_PI / 180);
  const auto lay = [&](const ChartPoint& p) { return ChartPoint(turn * p + Vec2(1.5, -1)); };
  auto excise = std::get<Excise>(s.planned(0));
  for (ChartPoint& p : excise.outline) p = lay(p);
  s.act(excise);
  const Command shown = s.coach.showing(false).acts.at(0);
  const auto& path = std::get<Incise>(shown).path;
  const auto& plan = std::get<Incise>(s.planned(1)).path;
  for (size_t i = 0; i < path.size(); ++i) EXPECT_LT((path[i] - lay(plan[i])).norm(), 0.05) << i;
}

TEST(Coach, HooksAreCarriedByTheNumbersThatTheyHave) {
  Session s("rhomboid");
  for (size_t i = 0; i < 3; ++i) s.act(s.planned(i));
  s.act(SetHook{5, {14, -10}});
  ASSERT_EQ(s.coach.progress().next, 4u);
  EXPECT_EQ(std::get<SetHook>(s.coach.showing(false).acts[0]).id, 2);
  s.act(s.planned(4));
  EXPECT_EQ(std::get<MoveHook>(s.coach.showing(false).acts[0]).id, 5);
}

TEST(Coach, ARowMayBeSewnStitchByStitch) {
  Session s("rhomboid");
  size_t row = 0;
  while (!std::holds_alternative<SutureRow>(s.planned(row))) s.act(s.planned(row)), ++row;
  ASSERT_EQ(s.coach.progress().next, row);
  const auto& r = std::get<SutureRow>(s.planned(row));
  for (int i = 0; i < 4; ++i) {
    const double t = i / 3.0;
    s.act(Suture{r.a[0] + t * (r.a[1] - r.a[0]), r.b[0] + t * (r.b[1] - r.b[0])});
  }
  EXPECT_EQ(s.coach.progress().next, row + 1);
}

TEST(Coach, ASecondTryStandsBesideTheFirst) {
  Session s("rhomboid");
  s.act(s.planned(0));
  s.act(Incise{{{0, 0}, {15, -8.66}}, 4, 90, false});
  const Attempt first = s.coach.present();
  EXPECT_GT(first.rows[1].share, 1);
  ASSERT_FALSE(first.better.empty());
  EXPECT_SAYS(first.better[0], "too short");
  EXPECT_LE(first.better.size(), 3u);
  EXPECT_EQ(s.coach.try_again(), 2);
  for (const Command& c : {Command(Shown{true}), Command(Undo{}), Command(Undo{}), Command(Shown{false})}) s.act(c);
  EXPECT_TRUE(s.coach.standing().empty());
  s.act(s.planned(0)), s.act(s.planned(1));
  ASSERT_EQ(s.coach.earlier().size(), 1u);
  EXPECT_EQ(s.coach.earlier()[0].rows[1].value, first.rows[1].value);
  EXPECT_EQ(s.coach.earlier()[0].cuts.size(), 2u);
  EXPECT_EQ(s.coach.present().rows[1].value, "as planned");
  for (const Attempt::Row& r : s.coach.present().rows)
    if (r.what == words_of_tolerance("undos")) {
      EXPECT_EQ(r.share, 0) << "what was taken back for the new try";
    }
}

TEST(Coach, QuestionsAreAskedOnceAndAnsweredWithTheReason) {
  Session s("zplasty");
  while (!s.coach.says().question && s.coach.progress().next + 1 < s.coach.plan().acts.size())
    s.act(s.planned(s.coach.progress().next));
  ASSERT_NE(s.coach.says().question, nullptr);
  const LessonQuestion q = *s.coach.says().question;
  s.coach.answer(0), s.coach.answer(9);
  EXPECT_NE(s.coach.says().question, nullptr);
  s.coach.answer(q.right == 1 ? 2 : 1);
  EXPECT_EQ(s.coach.says().question, nullptr);
  EXPECT_SAYS(s.coach.says().answer, "Not quite: " + q.answers[size_t(q.right - 1)]);
  EXPECT_SAYS(s.coach.says().answer, q.because);
}

TEST(Coach, KeepsItsSafeLimits) {
  LessonPlan p = shipped("rhomboid");
  p.limits = {{"The fascia", {}, 5.0}, {"Nerve", {{-30, -5}, {40, -5}}, {}}};
  Coach coach(p);
  const auto words = [&](const Command& c) {
    Notice n;
    n.t_s = 1, n.command = std::make_shared<const Command>(c);
    coach.hear(n);
    return coach.said().empty() ? std::string() : coach.said().back().word;
  };
  EXPECT_SAYS(words(Excise{{{0, 20}, {-17.3, 10}, {-17.3, -2}, {0, 0}}, 6}),
              "Too deep: 6.0 mm. The fascia begins at 5.0 mm");
  EXPECT_SAYS(words(Incise{{{0, 0}, {0, -20}}, 4, 90, false}), "crosses a safe limit: Nerve");
}

// What hangs on acts that were shown is not met, whatever its value; what was drawn by the learner counts.
TEST(Shown, IsWithheldFromTheJudge) {
  const std::vector<Command> script{Shown{true}, Excise{{{0, 0}, {9, 0}, {9, 9}}, 4}, Shown{false},
                                    Incise{{{0, 0}, {20, 0}}, 4, 90, false}, Suture{{1, 1}, {1, -1}}};
  std::vector<Judgement> j{{"corner_mm", "mm", 2, 0.5, "", true},
                           {"gap_mm", "mm", 0.2, 0.1, "", true},
                           {"time_s", "s", 600, 30, "", true},
                           {"undos", "", 3, 0, "", true}};
  withhold_shown(j, script);
  EXPECT_FALSE(j[0].met);
  EXPECT_SAYS(j[0].why, "1 of 2 cuts were shown");
  EXPECT_FALSE(j[1].met);
  EXPECT_SAYS(j[1].why, "1 of 3 acts were shown");
  EXPECT_FALSE(j[2].met);
  EXPECT_TRUE(j[3].met);
  // Taken back and done by the learner: judged.
  std::vector<Command> own = script;
  own.insert(own.begin() + 3, Undo{});
  own.push_back(Excise{{{0, 0}, {9, 0}, {9, 9}}, 4});
  std::vector<Judgement> k{{"corner_mm", "mm", 2, 0.5, "", true}};
  withhold_shown(k, own);
  EXPECT_TRUE(k[0].met);
  EXPECT_EQ(standing_acts(script).size(), 3u);
  EXPECT_EQ(own_acts(script).size(), 2u);
}

TEST(DoBetter, NamesTheWorstThreeWithWhatToDo) {
  const std::vector<Judgement> j{{"corner_mm", "mm", 2, 3, "", false},
                                 {"closure_N", "N", 15, 90, "", false},
                                 {"gap_mm", "mm", 0.2, 0.3, "", false},
                                 {"undos", "", 3, 9, "", false},
                                 {"time_s", "s", 600, 10, "", true}};
  const std::vector<std::string> better = to_do_better(j);
  ASSERT_EQ(better.size(), 3u);
  EXPECT_SAYS(better[0], "Pull of the closure: 90 N where 15 is the most");
  EXPECT_SAYS(better[1], "Acts taken back");
  EXPECT_TRUE(to_do_better(std::span(j).subspan(4)).empty());
}

TEST(Coach, NamesTheToolOfTheNextAct) {
  Session s("rhomboid");
  EXPECT_EQ(s.coach.says().tool, Tool::excise);
  s.act(s.planned(0));
  EXPECT_EQ(s.coach.says().tool, Tool::scalpel);
  s.act(s.planned(1));
  EXPECT_EQ(s.coach.says().tool, Tool::undermine);
  Session exam("rhomboid", LessonMode::examination);
  EXPECT_FALSE(exam.coach.says().tool);
  EXPECT_EQ(Session("genioplasty").coach.says().tool, std::nullopt) << "a plane is sawn by the panel";
}

TEST(Coach, AWordEndsWhenTheProgramShows) {
  Session s("rhomboid");
  s.act(s.planned(1));
  EXPECT_FALSE(s.coach.says().word.empty());
  s.notice(Notice::done, Shown{true});
  EXPECT_EQ(s.coach.says().word, "");
}

// A flap that was cut too short, and cut again as planned without taking anything back.
TEST(Coach, ASecondCutMayMendTheFirst) {
  Session s("rhomboid");
  s.act(s.planned(0));
  EXPECT_SAYS(s.act(Incise{{{0, 0}, {14, -8.1}}, 4, 90, false}), "too short");
  EXPECT_SAYS(s.act(Incise{{{0, 0}, {17.3, -10}, {9, -25.5}}, 4, 90, false}), "not in the plan");
  EXPECT_SAYS(s.act(s.planned(1)), "As planned");
  EXPECT_EQ(s.coach.says().steps[1].state, StepSeen::done);
  EXPECT_EQ(s.coach.progress().stray.size(), 2u) << "the others are of no plan";
}

// A line that stops short is gone on with, from either of its ends, in either direction.
TEST(Coach, ALineMayBeCutInSeveralStrokes) {
  const ChartPoint d(0, 0), e(17.321, -10), f(0, -20);
  for (const bool from_the_end : {false, true}) {
    Session s("rhomboid");
    s.act(s.planned(0));
    const std::vector<std::vector<ChartPoint>> strokes =
        from_the_end ? std::vector<std::vector<ChartPoint>>{{e, f}, {e + ChartPoint(.5, .5), 0.5 * e}, {d, 0.5 * e}}
                     : std::vector<std::vector<ChartPoint>>{{d, 0.5 * e}, {0.5 * e, e}, {f, e}};
    EXPECT_SAYS(s.act(Incise{strokes[0], 4, 90, false}), "too short");
    const std::string second = s.act(Incise{strokes[1], 4, 90, false});
    EXPECT_SAYS(second, "too short");
    EXPECT_SAYS(second, "Go on from where it ends");
    EXPECT_EQ(s.coach.says().steps[1].state, StepSeen::off);
    EXPECT_SAYS(s.act(Incise{strokes[2], 4, 90, false}), "As planned");
    EXPECT_EQ(s.coach.says().steps[1].state, StepSeen::done);
    EXPECT_TRUE(s.coach.progress().stray.empty());
    ASSERT_EQ(s.coach.present().cuts.size(), 2u);
    EXPECT_NEAR(path_length(s.coach.present().cuts[1].path), 40, 1.5);
    s.act(Undo{});
    EXPECT_EQ(s.coach.says().steps[1].state, StepSeen::off);
    EXPECT_EQ(s.coach.showing(true).undos, 2) << "both strokes of what is too short";
    EXPECT_SAYS(s.act(Incise{{{-60, 40}, {-40, 40}}, 4, 90, false}), "not in the plan");
  }
}

TEST(LessonPlan, ARowAlongOneLineIsSaidSo) {
  const LessonPlan p = shipped("rhomboid");
  size_t rows = 0;
  for (const PlannedAct& a : p.acts)
    if (std::holds_alternative<SutureRow>(a.command) && rows++ == 0)
      EXPECT_EQ(a.words, "Row of stitches every 4 mm: one edge along the line DE, the other along the line EF");
  EXPECT_GT(rows, 0u);
}

}  // namespace test_coach
}  // namespace limberg
