// Questions that are answered by pointing or by a number, bites of a running stitch in words, and the saw against the
// plan while it is held.
#include <gtest/gtest.h>

#include <cmath>

#include "app/assembly/cases.h"
#include "app/program/places.h"
#include "app/teaching/bite_words.h"
#include "app/teaching/coach.h"
#include "sim/commands/script.h"
#include "tests/devices/flat_patient.h"

namespace limberg {
namespace test_answers {

LessonPlan shipped(const std::string& name) {
  const Lesson l = open_lesson(source_dir() + "/app/lessons/" + name + ".toml");
  std::vector<Command> script;
  for (const ScriptLine& k : load_script(source_dir() + "/recordings/" + name + ".jsonl").lines)
    script.push_back(k.command);
  return make_lesson_plan(&l, script);
}

void did(Coach& coach, const Command& c, double t_s) {
  Notice n;
  n.t_s = t_s, n.command = std::make_shared<const Command>(c);
  coach.hear(n);
}

TEST(Question, APlaceIsRightWithinItsRadiusAndIsShownAfterwards) {
  for (const double off_mm : {2.0, 7.5, 8.5, 30.0}) {
    Coach coach(shipped("rhomboid"));
    did(coach, coach.plan().acts[0].command, 1);
    ASSERT_NE(coach.says().question, nullptr);
    ASSERT_TRUE(coach.says().question->place);
    const ChartPoint place = *coach.says().question->place;
    const double within = coach.says().question->within;
    EXPECT_EQ(within, 8);
    coach.answer_number(7);  // another kind of answer: nothing happens
    coach.answer(1);
    ASSERT_NE(coach.says().question, nullptr);
    coach.answer_place(place + ChartPoint(0, off_mm));
    EXPECT_EQ(coach.says().question, nullptr);
    EXPECT_EQ(coach.says().answer.rfind(off_mm <= within ? "Right" : "Not quite", 0), 0u) << coach.says().answer;
    ASSERT_TRUE(coach.says().answer_place);
    EXPECT_EQ(*coach.says().answer_place, place);
    bool counted = false;
    for (const Attempt::Row& r : coach.present().rows)
      if (r.what == "Questions") counted = r.value == (off_mm <= within ? "1 of 1 right" : "0 of 1 right");
    EXPECT_TRUE(counted);
    did(coach, coach.plan().acts[1].command, 2);
    EXPECT_FALSE(coach.says().answer_place) << "the next step has another question";
  }
}

TEST(Question, ANumberIsRightWithinItsTolerance) {
  int asked = 0;
  for (const char* name : {"zplasty", "genioplasty"}) {
    const LessonPlan plan = shipped(name);
    for (const TeachingStep& s : plan.steps) {
      if (!s.words.question || !s.words.question->number) continue;
      const LessonQuestion& q = *s.words.question;
      ++asked;
      for (const double share : {-1.1, -0.9, 0.0, 0.9, 1.1}) {
        Coach coach(plan);
        for (size_t i = 0; i < s.first; ++i) did(coach, plan.acts[i].command, 1 + double(i));
        ASSERT_EQ(coach.says().question ? coach.says().question->ask : "", q.ask);
        coach.answer_place({0, 0});
        ASSERT_NE(coach.says().question, nullptr);
        coach.answer_number(*q.number + share * q.within);
        EXPECT_EQ(coach.says().answer.rfind(std::abs(share) < 1 ? "Right" : "Not quite", 0), 0u) << coach.says().answer;
      }
    }
  }
  EXPECT_EQ(asked, 2);
}

// Along the cut that the lesson plans the piece comes down by what the lesson's number says.
TEST(Question, TheNumbersOfBoneLessonsAreThoseOfTheirPlans) {
  const LessonPlan plan = shipped("genioplasty");
  const auto* cut = std::get_if<CutBone>(&std::get<HeadCommand>(plan.acts[0].command));
  const auto* move = std::get_if<MoveFragment>(&std::get<HeadCommand>(plan.acts[1].command));
  ASSERT_TRUE(cut && move);
  const double down = 6 * cut->normal.y() / cut->normal.z();
  EXPECT_NEAR(-move->by.translation_mm.z(), down, 0.01);
  for (const TeachingStep& s : plan.steps)
    if (s.words.question && s.words.question->number) EXPECT_NEAR(*s.words.question->number, down, 0.05);
}

/// A square of skin with a cut along x = 0.
Snapshot cut_skin() {
  auto t = test::flat_topology(60, 1);
  for (size_t k = 0; k < t->view.tri.size(); ++k) {
    uint8_t rim = 0;
    for (size_t c = 0; c < 3; ++c) {
      const double a = t->view.X_mm[size_t(t->view.tri[k][c])].x(),
                   b = t->view.X_mm[size_t(t->view.tri[k][(c + 1) % 3])].x();
      if (a == 0 && b == 0) rim |= uint8_t(1 << c);
    }
    t->view.rim.push_back(rim);
  }
  return test::snapshot_of(t);
}

TEST(Bites, AreToldByTheirDistanceFromTheEdgeAndFromOneAnother) {
  const Snapshot s = cut_skin();
  const SutureBite first{{-2, 0}, {2.2, 0}}, second{{-2, 4}, {2, 4}}, third{{-1.8, 8.2}, {2, 8}};
  const BiteWord one = bite_word(s, 1, first, nullptr, 0);
  EXPECT_TRUE(one.praise);
  EXPECT_EQ(one.words.rfind("Bite 1: 2.0 and 2.2 mm from the edges.", 0), 0u) << one.words;
  EXPECT_NE(one.words.find("Shift+0 ties"), std::string::npos);
  const BiteWord three = bite_word(s, 3, third, &second, bites_apart_mm(first, second));
  EXPECT_TRUE(three.praise) << three.words;
  EXPECT_NE(three.words.find("4.1 mm on"), std::string::npos) << three.words;
  EXPECT_NE(bite_word(s, 1, {{-0.5, 0}, {0.6, 0}}, nullptr, 0).words.find("cuts through"), std::string::npos);
  EXPECT_NE(bite_word(s, 1, {{-1.5, 0}, {4, 0}}, nullptr, 0).words.find("as much on both sides"), std::string::npos);
  const BiteWord far = bite_word(s, 3, {{-2, 12}, {2, 12}}, &second, 4);
  EXPECT_FALSE(far.praise);
  EXPECT_NE(far.words.find("even bites share the pull"), std::string::npos) << far.words;
  EXPECT_EQ(bite_word(test::snapshot_of(test::flat_topology(60, 1)), 1, first, nullptr, 0).words, "")
      << "there is no wound";
}

TEST(Bites, AlongAPlannedRowAreItsAttemptAndNoStray) {
  Coach coach(shipped("rhomboid"));
  const LessonPlan& plan = coach.plan();
  size_t row = 0;
  for (size_t i = 0; i < plan.acts.size(); ++i)
    if (std::holds_alternative<SutureRow>(plan.acts[i].command)) {
      row = i;
      break;
    } else {
      did(coach, plan.acts[i].command, 1 + double(i));
    }
  const auto& r = std::get<SutureRow>(plan.acts[row].command);
  const Snapshot s = cut_skin();
  for (int k = 0; k < 4; ++k) {
    const auto at = [&](const std::vector<ChartPoint>& p) { return ChartPoint(p[0] + (p[1] - p[0]) * (k / 3.0)); };
    did(coach, SutureBite{at(r.a), at(r.b)}, 60 + k);
    coach.look(s, {});
    EXPECT_TRUE(coach.progress().stray.empty()) << k;
    EXPECT_EQ(coach.says().word.rfind("Bite " + std::to_string(k + 1), 0), 0u) << coach.says().word;
  }
  EXPECT_EQ(coach.progress().act[row].state, ActProgress::done);
  Snapshot sewing = s;
  sewing.sewn.thread = 1;
  const auto not_tied = [&] {
    bool told = false;
    for (const std::string& b : coach.present().better) told |= b.find("not tied") != std::string::npos;
    return told;
  };
  EXPECT_FALSE(not_tied());
  coach.look(sewing, {});
  EXPECT_TRUE(not_tied());
  did(coach, SutureBite{{-40, 40}, {-36, 40}}, 70);
  EXPECT_EQ(coach.progress().stray.size(), 1u) << "far from any row it is one";
}

/// A square of bone at z = 0, and a plan that saws it by a plane.
struct Bone {
  Snapshot s;
  LessonPlan plan;
  explicit Bone(const CutBone& cut) {
    auto t = test::flat_topology(40, 1);
    for (size_t i = 0; i < t->view.tri.size(); ++i)
      t->organ.push_back(Organ::bone), t->object.push_back(0), t->view.kind[i] = FaceKind::free;
    s = test::snapshot_of(t);
    plan = make_lesson_plan(nullptr, std::vector<Command>{HeadCommand(cut)});
  }
  /// Half a second of a hand that holds the saw there.
  CoachSays held(Coach& coach, const Vec3& tip, const Vec3& shaft, bool pressed) {
    HandSeen hand;
    hand.tool.valid = 1, hand.tool.tool = int32_t(Tool::saw), hand.tool.pressed = pressed;
    for (int i = 0; i < 3; ++i) hand.tool.tip_mm[i] = tip[i], hand.tool.shaft[i] = shaft[i];
    for (int i = 0; i < 50; ++i) s.device_tick += 10, coach.look(s, hand);
    return coach.says();
  }
};

TEST(Saw, IsToldHowFarItIsFromThePlannedPlaneWhileItIsHeld) {
  CutBone cut;
  cut.point_mm = {0, 10, 0}, cut.normal = {0, 1, 0};
  Bone b(cut);
  Coach coach(b.plan);
  CoachSays says = b.held(coach, {5, 12.5, 1}, {0, 0, 1}, false);
  ASSERT_EQ(says.stroke.size(), 2u);
  EXPECT_EQ(says.stroke[0].words, "2.5 mm beside");
  EXPECT_LT(says.stroke[0].share, 1);
  EXPECT_EQ(says.stroke[1].words, "leans by 0°");
  says = b.held(coach, {5, 10.2, 1}, Vec3(0, std::sin(0.35), std::cos(0.35)), false);
  EXPECT_EQ(says.stroke[1].words, "leans by 20°");
  EXPECT_GT(says.stroke[1].share, 1);
  EXPECT_TRUE(coach.said().empty()) << "a saw in the air is not corrected";
  // Pressed and off: a word, once a stroke, that says which way.
  b.held(coach, {5, 17, 0}, {0, 0, 1}, true);
  ASSERT_EQ(coach.said().size(), 1u);
  EXPECT_EQ(coach.said()[0].word, "The saw is 7 mm before the line that is drawn: lead it back.");
  b.held(coach, {6, 18, 0}, {0, 0, 1}, true);
  EXPECT_EQ(coach.said().size(), 1u);
  b.held(coach, {6, 18, 0}, {0, 0, 1}, false);
  b.held(coach, {6, 3, 0}, {0, 0, 1}, true);
  ASSERT_EQ(coach.said().size(), 2u);
  EXPECT_NE(coach.said()[1].word.find("behind"), std::string::npos) << coach.said()[1].word;
  // Away from the bone, and away from the plan, nothing is said.
  EXPECT_TRUE(b.held(coach, {5, 12, 60}, {0, 0, 1}, false).stroke.empty());
  EXPECT_TRUE(b.held(coach, {5, -55, 0}, {0, 0, 1}, false).stroke.empty());
}

TEST(Saw, AContourIsFollowedAndAStrokeRemembersItsWorstPlace) {
  CutBone cut;
  for (int i = 0; i < 40; ++i)
    cut.contour_mm.emplace_back(20 * std::cos(2 * M_PI * i / 40), 20 * std::sin(2 * M_PI * i / 40), 0);
  Bone b(cut);
  Coach coach(b.plan);
  for (int i = 0; i < 20; ++i) {
    const double w = 2 * M_PI * i / 40, r = i == 10 ? 26 : 21;
    b.held(coach, {r * std::cos(w), r * std::sin(w), 0}, {0, 0, 1}, true);
  }
  const auto& rows = coach.says().stroke;
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[0].words, "1.0 mm beside");
  EXPECT_EQ(rows[1].name, "line");
  EXPECT_GT(rows[1].share, 1) << rows[1].words;
}

TEST(Saw, APlaneThroughPickedPlacesIsComparedBeforeItIsSawnAndAfter) {
  CutBone cut;
  cut.point_mm = {0, 10, 0}, cut.normal = {0, 1, 0};
  Bone b(cut);
  Coach coach(b.plan);
  auto t = std::make_shared<SurfaceTopology>(*b.s.topology);
  t->landmark = {"M1", "M2", "N", "M3"};
  b.s.topology = t;
  b.s.landmark_mm = {Vec3f(-20, 12, 0), Vec3f(20, 12, 0), Vec3f(0, 0, 0), Vec3f(0, 15.5f, 10)};
  coach.look(b.s, {});
  ASSERT_EQ(coach.says().stroke.size(), 2u);
  EXPECT_NE(coach.says().stroke[1].words.find("19"), std::string::npos) << coach.says().stroke[1].words;
  EXPECT_GT(coach.says().stroke[1].share, 1);
  CutBone leaning = cut;
  leaning.normal = Vec3(0, std::cos(0.3), std::sin(0.3));
  did(coach, HeadCommand(leaning), 9);
  EXPECT_NE(coach.says().word.find("leans by 17"), std::string::npos) << coach.says().word;
  CutBone beside = cut;
  beside.point_mm.y() += 6;
  did(coach, Undo{}, 10), did(coach, HeadCommand(beside), 11);
  EXPECT_NE(coach.says().word.find("6.0 mm beside"), std::string::npos) << coach.says().word;
}

TEST(Saw, ALimitOnBoneIsHeardOfWhereACutComesTooNear) {
  const LessonPlan plan = shipped("le_fort_1");
  ASSERT_FALSE(plan.limits.empty());
  ASSERT_FALSE(plan.limits[0].bone_line.empty());
  for (const double lower_mm : {0.0, 1.0, 4.0}) {
    Coach coach(plan);
    auto cut = std::get<CutBoneByBlade>(std::get<HeadCommand>(plan.acts[0].command));
    cut.corner_mm.z() -= lower_mm;
    did(coach, HeadCommand(cut), 1);
    EXPECT_EQ(coach.says().word.find("Too near") != std::string::npos, lower_mm > 3) << coach.says().word;
  }
}

// What came free is known to the patient alone, and comes with the notice.
TEST(Saw, WhatCameFreeIsHeldAgainstTheOnePieceThatIsPlanned) {
  CutBone cut;
  cut.point_mm = {0, 10, 0}, cut.normal = {0, 1, 0};
  Bone b(cut);
  const auto sawn = [&](int32_t freed) {
    Coach coach(b.plan);
    Notice n;
    n.t_s = 1, n.freed = freed, n.command = std::make_shared<const Command>(HeadCommand(cut));
    coach.hear(n);
    EXPECT_EQ(coach.said().size(), 1u);
    const bool off = !within(coach.progress().act[0].offs);
    EXPECT_EQ(off, freed > 1);
    EXPECT_EQ(coach.present().better.size(), off ? 1u : 0u);
    return coach.said().empty() ? "" : coach.said()[0].word;
  };
  EXPECT_EQ(sawn(1), "As planned.");
  EXPECT_EQ(sawn(-1), "As planned.") << "nobody counted";
  EXPECT_EQ(sawn(0).rfind("All along the line, but the bone still hangs together", 0), 0u);
  EXPECT_EQ(sawn(3).rfind("3 pieces came free, and one is planned", 0), 0u);
}

}  // namespace test_answers
}  // namespace limberg
