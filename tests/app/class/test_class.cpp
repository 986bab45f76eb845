// A class without a patient: what is found in a folder, how acts go along a plan, what is wrong, page and table.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <set>
#include <sstream>

#include "app/class/class_page.h"
#include "app/class/gather.h"
#include "app/class/path_drawing.h"
#include "app/program/places.h"
#include "app/program/temporary_folder.h"
#include "app/teaching/saw_watch.h"
#include "sim/base/error.h"
#include "sim/commands/script.h"
#include "tests/app/report/xml_check.h"
#include "tests/devices/flat_patient.h"

namespace limberg {
namespace test_class {

namespace fs = std::filesystem;

std::vector<Command> shipped_script() {
  std::vector<Command> all;
  for (const ScriptLine& l : load_script(source_dir() + "/recordings/rhomboid.jsonl").lines) all.push_back(l.command);
  return all;
}
const Lesson& lesson() {
  static const Lesson l = open_lesson(source_dir() + "/app/lessons/rhomboid.toml");
  return l;
}
LessonPlan plan() { return make_lesson_plan(&lesson(), shipped_script()); }

/// A session that did these acts, one each two seconds, and went on for three seconds.
ClassMember session(const std::vector<Command>& acts) {
  ClassMember m;
  m.name = "somebody";
  m.also.kind = "recording";
  double t = 0;
  for (const Command& c : acts) m.result.script.push_back(to_json_line(c)), m.also.act_s.push_back(t += 2);
  m.result.duration_s = t + 3;
  m.result.exercise["time_s"] = t + 3;
  return m;
}

double sum_of(const ClassWalk& w) {
  double s = w.elsewhere_s.value_or(0) + w.taken_back_s.value_or(0) + w.afterwards_s.value_or(0);
  for (const StepWalk& x : w.steps) s += x.time_s.value_or(0);
  return s;
}

template <class Kind>
size_t first_of(const std::vector<Command>& acts) {
  return size_t(
      std::find_if(acts.begin(), acts.end(), [](const Command& c) { return std::holds_alternative<Kind>(c); }) -
      acts.begin());
}

TEST(ClassWalk, TimesOfStepsAddUpToTheSession) {
  const std::vector<Command> acts = shipped_script();
  const ClassMember whole = session(acts);
  const ClassWalk w = walk_of(plan(), whole);
  ASSERT_GE(w.steps.size(), 5u);
  for (const StepWalk& s : w.steps) {
    EXPECT_EQ(s.done, s.planned) << s.name;
    EXPECT_TRUE(s.time_s) << s.name;
    EXPECT_LE(s.share, 1) << s.name << ": " << s.off;
  }
  EXPECT_NEAR(sum_of(w), *whole.result.duration_s, 1e-9);
  EXPECT_EQ(w.out_of_order, 0);
  EXPECT_EQ(w.elsewhere, 0);
  EXPECT_NEAR(*w.elsewhere_s, 0, 1e-9);

  // What is taken back has a time of its own, and the sum stays.
  std::vector<Command> again = acts;
  const size_t cut = first_of<Incise>(again);
  again.insert(again.begin() + long(cut) + 1, {Undo{}, again[cut]});
  const ClassMember undone = session(again);
  const ClassWalk u = walk_of(plan(), undone);
  EXPECT_NEAR(*u.taken_back_s, 2, 1e-9);
  EXPECT_NEAR(sum_of(u), *undone.result.duration_s, 1e-9);
  EXPECT_EQ(u.out_of_order, 0);
}

TEST(ClassWalk, OrderStraysAndWhatIsMissing) {
  std::vector<Command> acts = shipped_script();
  std::swap(acts[first_of<Incise>(acts)], acts[first_of<Excise>(acts)]);
  const ClassWalk swapped = walk_of(plan(), session(acts));
  EXPECT_EQ(swapped.out_of_order, 1);
  for (const StepWalk& s : swapped.steps) EXPECT_EQ(s.done, s.planned) << s.name;

  acts = shipped_script();
  acts.insert(acts.begin(), Incise{{{-60, 40}, {-50, 45}, {-40, 60}}, 4, 90});
  EXPECT_EQ(walk_of(plan(), session(acts)).elsewhere, 1);

  acts = shipped_script();
  acts.resize(first_of<SetHook>(acts));
  const ClassWalk aborted = walk_of(plan(), session(acts));
  EXPECT_EQ(aborted.steps[0].done, aborted.steps[0].planned);
  EXPECT_EQ(aborted.steps.back().done, 0);
  EXPECT_FALSE(aborted.steps.back().time_s);
  EXPECT_EQ(aborted.out_of_order, 0);
}

TEST(ClassWalk, ABoneThatIsSawnByLinesIsDoneWhenAllOfItsLineIs) {
  auto t = test::flat_topology(40, 1);
  for (size_t i = 0; i < t->view.tri.size(); ++i)
    t->organ.push_back(Organ::bone), t->object.push_back(0), t->view.kind[i] = FaceKind::free;
  CutBone plane;
  plane.point_mm = {0, 10, 0}, plane.normal = {0, 1, 0};
  LessonPlan plan = make_lesson_plan(nullptr, std::vector<Command>{HeadCommand(plane)});
  find_lines_on_bone(plan, *t);
  const double half_mm = t->view.X_mm.front().cwiseAbs().maxCoeff();
  const auto line = [&](double from, double to) {
    CutBone cut;
    for (double x = from; x <= to; x += 1) cut.contour_mm.emplace_back(x, 10.5, 0);
    return Command(HeadCommand(cut));
  };
  const Command left = line(-half_mm, -1), right = line(0, half_mm);
  const ClassWalk part = walk_of(plan, session({left}));
  EXPECT_EQ(part.steps[0].done, 0);
  ASSERT_TRUE(part.steps[0].sawn);
  EXPECT_NEAR(*part.steps[0].sawn, 0.55, 0.1);
  EXPECT_GT(part.steps[0].share, 1);
  EXPECT_NE(part.steps[0].off.find("% of the line is sawn"), std::string::npos) << part.steps[0].off;
  EXPECT_EQ(part.elsewhere, 0);
  bool told = false;
  for (const Finding& f : findings_of(session({left}), part)) told |= f.words.find("0 of 1 acts; ") == 0;
  EXPECT_TRUE(told);
  const ClassMember whole = session({left, right});
  const ClassWalk w = walk_of(plan, whole);
  EXPECT_EQ(w.steps[0].done, 1);
  EXPECT_FALSE(w.steps[0].sawn);
  EXPECT_LE(w.steps[0].share, 1);
  EXPECT_NEAR(*w.steps[0].time_s, 4, 1e-9) << "both lines are of the step";
  EXPECT_NEAR(sum_of(w), *whole.result.duration_s, 1e-9);
}

TEST(ClassWalk, HooksAreMeans) {
  std::vector<Command> acts = shipped_script();
  const auto moved = acts.begin() + long(first_of<MoveHook>(acts));
  const MoveHook away = std::get<MoveHook>(*moved);
  acts.insert(moved + 1, 12, away);  // more of them than any plan has
  const ClassMember m = session(acts);
  const ClassWalk w = walk_of(plan(), m);
  // What they took counts for what they helped to do.
  EXPECT_NEAR(*w.elsewhere_s, 0, 1e-9);
  EXPECT_NEAR(sum_of(w), *m.result.duration_s, 1e-9);
  EXPECT_EQ(w.out_of_order, 0);
  EXPECT_EQ(w.elsewhere, 0);
}

TEST(ClassWalk, WhatIsShownIsNobodysFault) {
  std::vector<Command> acts = shipped_script();
  const size_t cut = first_of<Incise>(acts);
  // The flap 5 mm too short, and shown by the program.
  Incise& i = std::get<Incise>(acts[cut]);
  i.path[1] = {13, -7.5};
  EXPECT_GT(walk_of(plan(), session(acts)).steps[1].share, 1);
  acts.insert(acts.begin() + long(cut) + 1, Shown{false});
  acts.insert(acts.begin() + long(cut), Shown{true});
  const ClassWalk w = walk_of(plan(), session(acts));
  EXPECT_EQ(w.shown, 1);
  EXPECT_EQ(w.steps[1].share, 0);
  for (const Finding& f : findings_of(session(acts), w))
    if (f.key.find(w.steps[1].name) != std::string::npos) {
      EXPECT_FALSE(f.wrong) << f.what;
    }
}

TEST(ClassFindings, CountsAndMedians) {
  const auto of = [](double corner, double undos, bool judged = true) {
    ClassMember m = session({});
    ResultTolerance t{"dog_ear_mm", "mm", 2.0, {}, false, "there is none"};
    if (judged) t.value = corner, t.met = corner <= 2, t.why.clear();
    m.result.lesson.tolerances = std::vector{t};
    m.result.exercise["undos"] = undos;
    m.result.residual = 1e-6;
    return findings_of(m, {});
  };
  const std::vector<std::vector<Finding>> students{of(1, 0), of(5, 9), of(3, 0), of(4, 0), of(0, 0, false)};
  const std::vector<Finding> expert = of(2.5, 0);
  const std::vector<ClassFinding> all = class_findings(students, expert);
  ASSERT_EQ(all.size(), 2u);  // nothing that nobody has wrong
  EXPECT_EQ(all[0].key, "tolerance/dog_ear_mm");
  EXPECT_EQ(all[0].wrong, 3);
  EXPECT_EQ(all[0].judged, 4);  // the fifth could not be judged by it
  EXPECT_DOUBLE_EQ(*all[0].median, 4);
  EXPECT_TRUE(all[0].expert_wrong);
  EXPECT_FALSE(all[0].advice.empty());
  EXPECT_EQ(all[1].wrong, 1);
  EXPECT_EQ(all[1].judged, 5);
  EXPECT_FALSE(all[1].expert_wrong);
  EXPECT_DOUBLE_EQ(median_of({3, NAN, 1}), 2);
  EXPECT_TRUE(std::isnan(median_of({})));
}

TEST(ClassMember, NamesHangOnTheContentAlone) {
  std::set<std::string> names;
  for (uint64_t k = 1; k <= 500; ++k) names.insert(pseudonym(k * 0x9e3779b97f4a7c15ull));
  EXPECT_EQ(names.size(), 500u);
  for (const std::string& n : names) {
    EXPECT_EQ(n.size(), 11u);
    EXPECT_EQ(n.find_first_not_of("abcdefghijklmnopqrstuvwxyz-"), std::string::npos) << n;
  }
  EXPECT_EQ(pseudonym(0), "babab-babab");
  EXPECT_EQ(pseudonym(0x7f00000100000000ull), "lusab-babad");  // Wilkerson's own example: 127.0.0.1
}

TEST(ClassMember, ListsThatDoNotFitAreCut) {
  const ClassMember m = read_member(R"({"command":"run","script":["{}","{}"],"class":{"kind":"recording","act_s":[1],
    "path":{"x_mm":[1,2,3],"y_mm":[1,2],"tool":[0,null,0,0]},"missed":{"why":["a"],"x_mm":[1,2],"y_mm":[3,4]},
    "stitches":{"x_mm":[1],"y_mm":[]}}})",
                                    "r");
  EXPECT_EQ(m.also.path.x_mm.size(), 2u);
  EXPECT_EQ(m.also.path.tool.size(), 2u);
  EXPECT_EQ(m.also.missed.x_mm.size(), 1u);
  EXPECT_TRUE(m.also.stitches.x_mm.empty());
  EXPECT_TRUE(m.also.act_s.empty());
  EXPECT_THROW(read_member("[]", "r"), InputError);
}

ClassRow row(ClassMember m, const std::string& name, bool expert) {
  m.name = name;
  ClassRow r;
  r.member = std::move(m), r.expert = expert;
  r.walk = walk_of(plan(), r.member);
  r.findings = findings_of(r.member, r.walk);
  return r;
}

std::vector<std::vector<std::string>> cells_of(const std::string& csv) {
  std::vector<std::vector<std::string>> rows{{""}};
  bool quoted = false;
  for (size_t i = 0; i < csv.size(); ++i) {
    if (quoted && csv.compare(i, 2, "\"\"") == 0)
      rows.back().back() += csv[i++];
    else if (csv[i] == '"')
      quoted = !quoted;
    else if (csv[i] == ',' && !quoted)
      rows.back().emplace_back();
    else if (csv[i] == '\n' && !quoted)
      rows.push_back({""});
    else
      rows.back().back() += csv[i];
  }
  rows.pop_back();
  return rows;
}

TEST(ClassTable, OneRowAStudentAndEveryColumnSaysWhatItIs) {
  std::vector<Command> short_one = shipped_script();
  short_one.resize(4);
  const std::vector<ClassRow> rows{row(session(shipped_script()), "expert", true),
                                   row(session(short_one), "a \"b\", c", false), row(session({}), "=1+1", false)};
  const std::vector<ClassColumn> columns = class_columns(rows);
  const auto cells = cells_of(csv_of(columns)), meanings = cells_of(csv_of_meanings(columns));
  ASSERT_EQ(cells.size(), 4u);
  for (const auto& r : cells) EXPECT_EQ(r.size(), columns.size());
  EXPECT_EQ(cells[2][0], "a \"b\", c");
  EXPECT_EQ(cells[3][0], "'=1+1");  // no formula for a spreadsheet
  EXPECT_EQ(cells[1][1], "1");
  EXPECT_EQ(cells[2][1], "0");
  ASSERT_EQ(meanings.size(), columns.size() + 1);
  std::set<std::string> names;
  for (size_t i = 0; i < columns.size(); ++i) {
    EXPECT_EQ(meanings[i + 1][0], cells[0][i]);
    EXPECT_FALSE(meanings[i + 1][2].empty()) << cells[0][i];
    EXPECT_TRUE(names.insert(cells[0][i]).second) << cells[0][i] << " twice";
    for (const char* unit : {"_s", "_mm", "_N"})
      if (cells[0][i].ends_with(unit)) {
        EXPECT_EQ(meanings[i + 1][1], unit + 1) << cells[0][i];
      }
  }
}

TEST(ClassPage, IsWellFormedAndNamesNobody) {
  ClassPage p;
  p.lesson = &lesson(), p.plan = plan();
  ClassMember odd = session(shipped_script());
  odd.result.script.push_back("<b>&");
  odd.also.missed = {{"why <\"&'>"}, {3}, {4}};
  odd.also.path = {{0, 1, NAN, 40, 41}, {0, 1, NAN, 40, 41}, {0, 1, NAN, 1, 1}};
  p.rows = {row(session(shipped_script()), "expert", true), row(odd, "babab-babad", false),
            row(session({}), "a<b", false)};
  const std::string page = class_html(p);
  EXPECT_EQ(test::xml_fault(page), "");
  EXPECT_NE(page.find("babab-babad"), std::string::npos);
  EXPECT_EQ(page.find("<script"), std::string::npos);
  for (const char* fetch : {"http://", "https://", "src=\"/", "url("})
    for (size_t at = page.find(fetch); at != std::string::npos; at = page.find(fetch, at + 1))
      EXPECT_TRUE(page.compare(at, 21, "http://www.w3.org/200") == 0 ||
                  page.compare(at, 21, "http://www.w3.org/199") == 0)
          << page.substr(at, 60);
  // Nobody is graded: the word is nowhere but where the page says so.
  for (const char* word : {"grade", "rank", "points of", "best student", "worst student"})
    EXPECT_EQ(page.find(word), std::string::npos) << word;
}

TEST(ClassPage, AWayWithAGapIsNotDrawnAcrossIt) {
  ClassMember m = session({});
  m.also.path = {{-20, -19, NAN, 20, 21}, {0, 0, NAN, 0, 0}, {0, 0, NAN, 0, 0}};
  const LessonPlan none;
  const DrawnFrame f = frame_of(none, {&m});
  EXPECT_LT(f.x0_mm, -20);
  EXPECT_GT(f.x1_mm, 21);
  const std::string svg = path_svg(f, none, m, nullptr, "t");
  EXPECT_EQ(test::xml_fault(svg), "");
  size_t lines = 0;
  for (size_t at = svg.find("<polyline"); at != std::string::npos; at = svg.find("<polyline", at + 1)) ++lines;
  EXPECT_EQ(lines, 2u);
  // A tool that is pressed begins where it was put down: the line before reaches there.
  m.also.path = {{0, 10, 20}, {0, 0, 0}, {0, 1, 1}};
  const std::string joined = path_svg(f, none, m, nullptr, "t");
  const auto points = [&](size_t from) {
    const size_t a = joined.find("points=\"", from) + 8;
    return joined.substr(a, joined.find('"', a) - a);
  };
  const std::string first = points(0), second = points(joined.find("points=\"") + 8);
  EXPECT_EQ(first.substr(first.find(' ') + 1), second.substr(0, second.find(' ')));
}

TEST(ClassFolder, FindsSessionsAndNamesTheRest) {
  const TemporaryFolder folder;
  const auto put = [&](const std::string& name, const std::string& text) {
    fs::create_directories((folder.path() / name).parent_path());
    std::ofstream(folder.path() / name, std::ios::binary) << text;
  };
  const std::string script = "{\"limberg_script\":1,\"scene\":\"rhomboid\"}\n{\"action\":\"stage\",\"name\":\"a\"}\n";
  put("one.jsonl", script);
  put("two/result.json", R"({"command":"run","scene":"rhomboid"})");
  put("two/session.jsonl", script);        // the session's own
  put("two/stages/00.png", "no picture");  // nor is this looked at
  put("three/result.json", R"({"command":"study"})");
  put("four.jsonl", "{broken");
  put("five.lcm", "noise");
  put("notes.txt", "hello");
  put("out/result.json", R"({"command":"run"})");
  const GatheredSessions g =
      gather(folder.path().string(), (folder.path() / "out").string(), [](size_t) { return true; });
  ASSERT_EQ(g.sessions.size(), 2u);
  EXPECT_EQ(g.sessions[0].kind, FoundSession::script);
  EXPECT_EQ(g.sessions[1].kind, FoundSession::result);
  EXPECT_EQ(g.sessions[1].scene, "rhomboid");
  std::map<std::string, bool> left;
  for (const LeftOut& l : g.left_out) {
    left[fs::path(l.path).filename().string()] = l.broken;
    EXPECT_FALSE(l.reason.empty());
  }
  EXPECT_EQ(left, (std::map<std::string, bool>{
                      {"three", true}, {"four.jsonl", true}, {"five.lcm", true}, {"notes.txt", false}}));
  EXPECT_THROW(gather((folder.path() / "notes.txt").string(), "", [](size_t) { return true; }), InputError);
  EXPECT_TRUE(gather(folder.path().string(), "", [](size_t) { return false; }).sessions.empty());
}

}  // namespace test_class
}  // namespace limberg
