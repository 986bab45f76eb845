// The words of a lesson, [[step]] and [[limit]]: what is taken, what is refused with file and line, and that no shipped
// lesson warns of the operation that it teaches.
#include <gtest/gtest.h>

#include <algorithm>

#include "app/assembly/cases.h"
#include "app/teaching/coach.h"
#include "sim/base/error.h"
#include "sim/commands/script.h"

namespace limberg {
namespace test_lesson_steps {

const std::string kHead = R"(lesson = "A Z"
goal = "Lengthen it."
scene = "zplasty"
[procedure]
name = "z_plasty"
[tolerance]
gap_mm = 0.2
)";  // 7 lines

const std::string kStep = R"([[step]]
stage = "flaps cut"
say = "Cut the Z."
why = "It lengthens."
hint = "In one stroke."
[step.question]
ask = "How much?"
answers = ["Three quarters", "Nothing"]
right = 1
because = "Of 60 degrees."
)";

const std::string kLimit = R"([[limit]]
name = "Nerve"
line = [[0, 0], [10, 5]]
deepest_mm = 6
)";

std::string with(std::string s, const std::string& from, const std::string& to) {
  const size_t at = s.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return s.replace(at, from.size(), to);
}

/// A lesson with these lines after its head is refused at that line, by words that name what is wrong.
void expect_bad(const std::string& lines, int line, const std::string& word) {
  try {
    parse_lesson(kHead + lines, "l.toml");
    ADD_FAILURE() << "taken: " << word;
  } catch (const InputError& e) {
    const std::string what = e.what();
    EXPECT_NE(what.find("l.toml:" + std::to_string(line) + ":"), std::string::npos) << what;
    EXPECT_NE(what.find(word), std::string::npos) << what;
    EXPECT_NE(what.find("expected"), std::string::npos) << what;
  }
}

TEST(LessonSteps, AreReadWhole) {
  const LessonWords w = parse_lesson(kHead + kStep + kLimit, "l.toml").words;
  ASSERT_EQ(w.steps.size(), 1u);
  EXPECT_EQ(w.steps[0].stage, "flaps cut");
  EXPECT_EQ(w.steps[0].hint, "In one stroke.");
  ASSERT_TRUE(w.steps[0].question);
  EXPECT_EQ(w.steps[0].question->answers.size(), 2u);
  EXPECT_EQ(w.steps[0].question->right, 1);
  ASSERT_EQ(w.limits.size(), 1u);
  EXPECT_EQ(w.limits[0].line, (std::vector<ChartPoint>{{0, 0}, {10, 5}}));
  EXPECT_EQ(w.limits[0].deepest_mm, 6.0);
  // Either alone is a limit; hint and question may be left out.
  EXPECT_FALSE(parse_lesson(kHead + with(kLimit, "deepest_mm = 6\n", ""), "l.toml").words.limits[0].deepest_mm);
  EXPECT_TRUE(
      parse_lesson(kHead + with(kLimit, "line = [[0, 0], [10, 5]]\n", ""), "l.toml").words.limits[0].line.empty());
  const LessonWords bare = parse_lesson(kHead + kStep.substr(0, kStep.find("hint")), "l.toml").words;
  EXPECT_EQ(bare.steps[0].hint, "");
  EXPECT_FALSE(bare.steps[0].question);
}

TEST(LessonSteps, BadStepsAreRefusedWithTheirLine) {
  expect_bad("step = 3\n", 8, "step");  // within [tolerance]: unknown there
  expect_bad("[step]\nstage = \"a\"\n", 8, "no list of tables; expected [[step]]");
  for (const char* key : {"stage", "say", "why"}) {
    std::string lines;
    for (const char* k : {"stage", "say", "why"})
      if (std::string(k) != key) lines += std::string(k) + " = \"words\"\n";
    expect_bad("[[step]]\n" + lines, 8, std::string(key) + " is missing");
  }
  expect_bad(with(kStep, "why = \"It lengthens.\"", "why = 3"), 11, "why");
  expect_bad(with(kStep, "hint", "hnit"), 12, "hnit");
  expect_bad(with(kStep, "It lengthens.", std::string(401, 'x')), 11, "why");
  expect_bad(kStep + kStep, 19, "\"flaps cut\" has words already");
  std::string many;
  for (int i = 0; i < 51; ++i) many += "[[step]]\nstage = \"" + std::to_string(i) + "\"\nsay = \"a\"\nwhy = \"b\"\n";
  expect_bad(many, 8, "51 of step; expected at most 50");
}

TEST(LessonSteps, BadQuestionsAreRefusedWithTheirLine) {
  expect_bad(with(kStep, "ask = \"How much?\"\n", ""), 13, "ask is missing");
  expect_bad(with(kStep, "because = \"Of 60 degrees.\"\n", ""), 13, "because is missing");
  expect_bad(with(kStep, "right = 1\n", ""), 13, "right is missing");
  expect_bad(with(kStep, "right = 1", "right = 0"), 16, "right");
  expect_bad(with(kStep, "right = 1", "right = 3"), 16, "right");
  const std::string answers = "[\"Three quarters\", \"Nothing\"]";
  expect_bad(with(kStep, answers, "\"Three quarters\""), 15, "no list of answers");
  expect_bad(with(kStep, answers, "[\"one alone\"]"), 15, "expected two to five texts");
  expect_bad(with(kStep, answers, "[\"a\", \"b\", \"c\", \"d\", \"e\", \"f\"]"), 15, "expected two to five texts");
  expect_bad(with(kStep, answers, "[\"a\", 2]"), 15, "holds what is no text");
  expect_bad(with(kStep, answers, "[\"a\", \"\"]"), 15, "holds what is no text");
}

TEST(LessonSteps, BadLimitsAreRefusedWithTheirLine) {
  const std::string line = "[[0, 0], [10, 5]]";
  expect_bad(with(kLimit, "name = \"Nerve\"\n", ""), 8, "name is missing");
  expect_bad(with(kLimit, "Nerve", std::string(81, 'n')), 9, "name");
  expect_bad("[[limit]]\nname = \"Nerve\"\n", 9, "has neither line nor deepest_mm");
  expect_bad("[limit]\nname = \"Nerve\"\n", 8, "no list of tables; expected [[limit]]");
  expect_bad(with(kLimit, line, "3"), 10, "no line; expected two to 200 points");
  expect_bad(with(kLimit, line, "[[0, 0]]"), 10, "no line; expected two to 200 points");
  expect_bad(with(kLimit, line, "[[0, 0], [1, 2, 3]]"), 10, "no line; expected two to 200 points");
  expect_bad(with(kLimit, line, "[[0, 0], [1, \"b\"]]"), 10, "no line; expected two to 200 points");
  expect_bad(with(kLimit, line, "[[0, 0], [1, inf]]"), 10, "no line; expected two to 200 points");
  std::string long_line = "[";
  for (int i = 0; i < 201; ++i) long_line += "[" + std::to_string(i) + ", 0],";
  expect_bad(with(kLimit, line, long_line + "]"), 10, "no line; expected two to 200 points");
  expect_bad(with(kLimit, "deepest_mm = 6", "deepest_mm = 0"), 11, "deepest_mm");
  expect_bad(with(kLimit, "deepest_mm = 6", "deepest_mm = -1"), 11, "deepest_mm");
  expect_bad(with(kLimit, "deepest_mm = 6", "deepest_mm = 201"), 11, "deepest_mm");
  expect_bad(with(kLimit, "deepest_mm = 6", "deepest_mm = \"six\""), 11, "deepest_mm");
  expect_bad(with(kLimit, "deepest_mm", "shallowest_mm"), 11, "shallowest_mm");
}

const std::string kPlace = R"([[step]]
stage = "flaps cut"
say = "Cut the Z."
why = "It lengthens."
[step.question]
ask = "Where?"
place = [17.5, -8]
within = 8
because = "There."
)";

const std::string kNumber = R"([[step]]
stage = "flaps cut"
say = "Cut the Z."
why = "It lengthens."
[step.question]
ask = "How much?"
number = 73
unit = "%"
within = 7
because = "So."
)";

const std::string kOnBone = R"([[limit]]
name = "Roots"
bone_line = [[0, 70, -40], [10, 65, -40]]
nearest_mm = 5
)";

TEST(LessonSteps, QuestionsOfAPlaceAndOfANumberAreReadAndRefusedWithTheirLine) {
  const LessonWords place = parse_lesson(kHead + kPlace, "l.toml").words;
  ASSERT_TRUE(place.steps[0].question && place.steps[0].question->place);
  EXPECT_EQ(*place.steps[0].question->place, ChartPoint(17.5, -8));
  EXPECT_EQ(place.steps[0].question->within, 8);
  EXPECT_TRUE(place.steps[0].question->answers.empty());
  const LessonWords number = parse_lesson(kHead + kNumber, "l.toml").words;
  ASSERT_TRUE(number.steps[0].question && number.steps[0].question->number);
  EXPECT_EQ(*number.steps[0].question->number, 73);
  EXPECT_EQ(number.steps[0].question->unit, "%");
  expect_bad(with(kPlace, "within = 8\n", ""), 12, "within is missing");
  expect_bad(with(kPlace, "within = 8", "within = 0"), 15, "within");
  expect_bad(with(kPlace, "within = 8", "within = 8\nnumber = 3"), 16, "number beside another way to answer");
  expect_bad(with(kPlace, "within = 8", "within = 8\nanswers = [\"a\", \"b\"]"), 16, "answers beside another way");
  expect_bad(with(kPlace, "within = 8", "within = 8\nunit = \"mm\""), 16, "unit beside another way");
  for (const char* bad : {"[1]", "[1, 2, 3]", "[1, \"b\"]", "[1, nan]", "5"})
    expect_bad(with(kPlace, "[17.5, -8]", bad), 14, "no place; expected [x, y]");
  expect_bad(with(kNumber, "73", "\"many\""), 14, "number");
  expect_bad(with(kNumber, "unit = \"%\"", "unit = 3"), 15, "unit");
  expect_bad(with(kNumber, "within = 7", "within = 7\nright = 1"), 17, "right beside another way");
}

TEST(LessonSteps, LimitsOnBoneAreReadAndRefusedWithTheirLine) {
  const LessonWords w = parse_lesson(kHead + kOnBone, "l.toml").words;
  ASSERT_EQ(w.limits.size(), 1u);
  EXPECT_EQ(w.limits[0].bone_line, (std::vector<Vec3>{{0, 70, -40}, {10, 65, -40}}));
  EXPECT_EQ(w.limits[0].nearest_mm, 5);
  expect_bad(with(kOnBone, "nearest_mm = 5\n", ""), 8, "nearest_mm is missing");
  expect_bad(with(kOnBone, "nearest_mm = 5", "nearest_mm = 0"), 11, "nearest_mm");
  expect_bad(with(kOnBone, "nearest_mm = 5", "nearest_mm = 5\ndeepest_mm = 4"), 10, "beside a limit of skin");
  for (const char* bad : {"[[0, 70, -40]]", "[[0, 70], [1, 2]]", "[[0, 70, -40], [1, 2, inf]]", "7"})
    expect_bad(with(kOnBone, "[[0, 70, -40], [10, 65, -40]]", bad), 10,
               "no line; expected two to 200 points [x, y, z]");
}

/// What a coach says of limits while this script is carried out as it is written.
std::string warnings(const Lesson& lesson, const std::vector<Command>& script) {
  Coach coach(make_lesson_plan(&lesson, script));
  std::string words;
  for (const Command& c : script) {
    Notice n;
    n.t_s += 1, n.command = std::make_shared<const Command>(c);
    const size_t before = coach.said().size();
    coach.hear(n);
    for (size_t i = before; i < coach.said().size(); ++i)
      if (const std::string& w = coach.said()[i].word; w.find("Too deep") != std::string::npos ||
                                                       w.find("Too near") != std::string::npos ||
                                                       w.find("safe limit") != std::string::npos)
        words += w + "\n";
  }
  return words;
}

// A lesson keeps its own limits, its steps lead to stages of its script, and a limit laid over its cuts is heard of.
TEST(LessonSteps, NoShippedOneWarnsOfWhatItTeaches) {
  int with_line = 0;
  for (const Case& c : shipped_cases()) {
    SCOPED_TRACE(c.name);
    std::vector<Command> script;
    std::vector<std::string> stages;
    for (const ScriptLine& l : load_script(c.script).lines) {
      script.push_back(l.command);
      if (const auto* s = std::get_if<Stage>(&l.command)) stages.push_back(s->name);
    }
    for (const LessonStep& s : c.lesson.words.steps)
      EXPECT_NE(std::find(stages.begin(), stages.end(), s.stage), stages.end()) << s.stage;
    if (!c.lesson.bone) {  // a bone's last stage may only let time pass
      EXPECT_EQ(c.lesson.words.steps.size(), make_lesson_plan(&c.lesson, script).steps.size())
          << "a stage that acts lead to has no words";
    }
    EXPECT_EQ(warnings(c.lesson, script), "");
    const auto line = std::find_if(c.lesson.words.limits.begin(), c.lesson.words.limits.end(),
                                   [](const SafeLimit& l) { return !l.line.empty(); });
    if (line == c.lesson.words.limits.end()) continue;
    ++with_line;
    const auto cut =
        std::find_if(script.begin(), script.end(), [](const Command& k) { return std::holds_alternative<Incise>(k); });
    if (cut == script.end()) continue;
    const std::vector<ChartPoint>& path = std::get<Incise>(*cut).path;
    const ChartPoint across(path[0].y() - path[1].y(), path[1].x() - path[0].x()), mid = 0.5 * (path[0] + path[1]);
    Lesson over = c.lesson;
    over.words.limits = {{line->name, {mid - across, mid + across}, {}, {}}};
    EXPECT_NE(warnings(over, script).find("crosses a safe limit: " + line->name), std::string::npos);
  }
  EXPECT_GE(with_line, 5);
}

}  // namespace test_lesson_steps
}  // namespace limberg
