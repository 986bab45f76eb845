// `limberg class`: many students' recordings beside an expert's, by a lesson: one page, one table.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <set>

#include "app/assembly/cases.h"
#include "app/assembly/patient_of_scene.h"
#include "app/class/class_page.h"
#include "app/class/gather.h"
#include "app/commands/class_measure.h"
#include "app/commands/numbers.h"
#include "app/commands/session_command.h"
#include "app/commands/this_call.h"
#include "app/program/interrupt.h"
#include "app/program/shipped.h"
#include "app/program/version.h"
#include "app/report/report_names.h"
#include "app/result/output.h"
#include "app/result/progress.h"
#include "app/result/schema.h"
#include "app/session/workers_pool.h"
#include "app/teaching/plan_ground.h"
#include "app/teaching/saw_watch.h"
#include "sim/base/error.h"
#include "sim/base/hash.h"
#include "sim/commands/script.h"
#include "sim/commands/texture_script.h"
#include "sim/patient/world.h"

namespace limberg {
namespace {

namespace fs = std::filesystem;

struct ClassOptions {
  std::string folder, lesson, expert, key;
  bool no_expert = false, names = false, anew = false;
  double cell_mm = 0;
  CommonOptions common;
};

constexpr const char* kKeyHeader = "name,file";
constexpr size_t kMostKept = size_t(256) << 20;

/// How far the whole of it has come.
class ClassProgress {
 public:
  explicit ClassProgress(size_t sessions) : total_(sessions), line_("class") {}
  void begin(size_t done, const std::string& name) { done_ = done, name_ = name; }
  void show(double part, double of, const char* unit) {
    line_.note(
        fmt::format("{} of {}: {}, {:.0f} of {:.0f} {}", done_ + 1, total_, name_, part, std::max(part, of), unit));
  }
  void clear() { line_.clear(); }

 private:
  size_t total_, done_ = 0;
  std::string name_;
  Progress line_;
};

/// What a class is held against.
struct Against {
  std::optional<Lesson> lesson;
  std::vector<Command> script;  // the lesson's
  std::string expert;           // file or folder; empty: none
};

/// The scene that most sessions are of.
std::string commonest_scene(const std::vector<FoundSession>& all) {
  std::map<std::string, int> count;
  for (const FoundSession& s : all)
    if (!s.scene.empty()) ++count[s.scene];
  std::string most;
  for (const auto& [scene, n] : count)
    if (most.empty() || n > count[most]) most = scene;
  return most;
}

Against held_against(const ClassOptions& o, const std::vector<FoundSession>& all) {
  Against a;
  const std::string scene = commonest_scene(all);
  if (!o.lesson.empty())
    a.lesson = open_lesson(o.lesson);
  else if (const std::string file = shipped_file("app/lessons/" + fs::path(scene).filename().string() + ".toml");
           !scene.empty() && scene.find('/') == std::string::npos && !file.empty())
    a.lesson = open_lesson(file);
  const std::string stem = a.lesson ? fs::path(a.lesson->file).stem().string() : "";
  const std::string script = stem.empty() ? "" : shipped_file("recordings/" + stem + ".jsonl");
  if (!script.empty()) {
    const Script s = load_script(script);
    a.script = acts_on(has_texture_places(s) ? open_scene(s.header.scene) : Scene(), s);
  }
  if (o.no_expert) return a;
  a.expert =
      o.expert.empty() ? stem.empty() ? "" : shipped_file("recordings/" + stem + ".lcm") : given_or_shipped(o.expert);
  if (a.expert.empty() && o.expert.empty()) a.expert = script;
  return a;
}

/// One name for a hash of all that a measurement hangs on.
std::string kept_name(const FoundSession& s, const Against& a, const ClassOptions& o) {
  Hash64 h;
  h.add(s.content), h.add(int(s.kind)), h.add(program_name()), h.add(o.cell_mm), h.add(int64_t(ClassExtra::kFormat));
  if (s.kind == FoundSession::script) {
    const std::string scene = s.scene.empty() && a.lesson ? a.lesson->scene : s.scene;
    if (!scene.empty()) h.add(open_scene(scene).hash);
  }
  if (a.lesson) {
    const Lesson& l = *a.lesson;
    h.add(read_whole_file(l.file, 1 << 20, "a lesson"));
  }
  return hex(h.value());
}

class Measuring {
 public:
  Measuring(const ClassOptions& o, const Against& a, size_t sessions)
      : o_(o), a_(a), kept_(o.common.out_dir + "/measured"), progress_(sessions) {
    prepare_folder(kept_);
  }

  /// Nothing: interrupted. InputError: it cannot be used.
  std::optional<ClassMember> one(const FoundSession& s, size_t number) {
    progress_.begin(number, pseudonym(s.content));
    if (s.kind == FoundSession::result) return of_folder(s);
    const std::string file = kept_ + "/" + kept_name(s, a_, o_);
    std::error_code ec;
    if (!o_.anew && fs::exists(file + ".json", ec)) try {
        ClassMember m = read_member(read_whole_file(file + ".json", kMostKept, "a measured session"), file + ".json");
        m.picture = picture_at(file + ".png");
        return m;
      } catch (const InputError&) {  // damaged: measured anew
      }
    ClassMeasure how;
    how.lesson = a_.lesson ? &*a_.lesson : nullptr;
    how.cell_mm = o_.cell_mm;
    how.scene = a_.lesson ? a_.lesson->scene : "";
    how.workers = o_.common.worker_count();
    how.picture = file + ".png";
    how.progress = [this](double done, double total, const char* unit) { progress_.show(done, total, unit); };
    const std::optional<std::string> text = measured(s, how);
    progress_.clear();
    if (!text) return std::nullopt;
    write_whole_file(file + ".json", *text);
    ClassMember m = read_member(*text, file + ".json");
    m.picture = picture_at(file + ".png");
    return m;
  }
  void clear() { progress_.clear(); }

 private:
  static std::string picture_at(const std::string& file) {
    std::error_code ec;
    return fs::exists(file, ec) ? file : std::string();
  }
  ClassMember of_folder(const FoundSession& s) const {
    const std::string file = s.path + "/" + report_names::result;
    ClassMember m = read_member(read_whole_file(file, kMostKept, "a result"), file);
    if (a_.lesson) judge_by(m, *a_.lesson);
    m.picture = picture_at(s.path + "/" + report_names::overview);
    return m;
  }
  const ClassOptions& o_;
  const Against& a_;
  std::string kept_;
  ClassProgress progress_;
};

/// Why a session is not one of this class; empty: it is.
std::string of_another(const FoundSession& s, const Against& a, const std::string& commonest) {
  if (s.scene.empty()) return "";
  const std::string wanted = a.lesson ? fs::path(a.lesson->scene).stem().string() : commonest;
  if (fs::path(s.scene).stem().string() == wanted || (a.lesson && s.scene == a.lesson->scene)) return "";
  return "is of the scene " + s.scene + ", the class of " + wanted;
}

/// Where the plan's cuts of bone run, on the head as it was before: lines that were sawn by hand are held against that.
/// And which of its acts in space a hand says on the chart.
void know_patient(LessonPlan& plan, const std::string& scene_name, int workers) {
  const bool in_space = std::any_of(plan.acts.begin(), plan.acts.end(),
                                    [](const PlannedAct& a) { return std::holds_alternative<InSpace>(a.command); });
  if ((!plan.bone && !in_space) || scene_name.empty()) return;
  Scene scene = open_scene(scene_name);
  if (scene.head) scene.head->face = false, scene.head->tissues.clear(), scene.head->face_landmarks.clear();
  WorkersPool pool(workers);
  Snapshot before;
  make_world(scene, pool)->fill(before);
  if (before.topology && plan.bone) find_lines_on_bone(plan, *before.topology);
  say_on_chart(plan, before);
}

ClassRow row_of(ClassMember member, const LessonPlan& plan, bool expert) {
  ClassRow r;
  r.member = std::move(member), r.expert = expert;
  r.walk = walk_of(plan, r.member);
  r.findings = findings_of(r.member, r.walk);
  return r;
}

/// students: as on the page, without the ways of their tools.
struct ResultStudent {
  std::string name;
  MaybeFlag expert;
  std::string kind;
  Maybe time_s, path_mm, force_peak_N, closure_force_N, residual;
  MaybeCount out_of_order, elsewhere;
  MaybeList<ResultTolerance> tolerances;
  MaybeList<std::string> wrong;
};
void fields(ResultStudent& x, auto&& f) {
  f("name", x.name), f("expert", x.expert), f("kind", x.kind), f("time_s", x.time_s), f("path_mm", x.path_mm);
  f("force_peak_N", x.force_peak_N), f("closure_force_N", x.closure_force_N), f("residual", x.residual);
  f("out_of_order", x.out_of_order), f("elsewhere", x.elsewhere), f("tolerances", x.tolerances), f("wrong", x.wrong);
}
/// wrong: of the class, what most have wrong first.
struct ResultClassFinding {
  std::string what, unit;
  int64_t wrong, judged;
  Maybe median, limit, expert;
  MaybeFlag expert_wrong;
};
void fields(ResultClassFinding& x, auto&& f) {
  f("what", x.what), f("unit", x.unit), f("wrong", x.wrong), f("judged", x.judged), f("median", x.median);
  f("limit", x.limit), f("expert", x.expert), f("expert_wrong", x.expert_wrong);
}
struct ResultClass {
  MaybeText lesson;
  MaybeFlag interrupted;
  int64_t left_out, passed_over, to_come;
  std::vector<ResultStudent> students;
  std::vector<ResultClassFinding> wrong;
  std::string reproduce;
};
void fields(ResultClass& x, auto&& f) {
  f("lesson", x.lesson), f("interrupted", x.interrupted), f("left_out", x.left_out), f("passed_over", x.passed_over);
  f("to_come", x.to_come), f("students", x.students), f("wrong", x.wrong), f("reproduce", x.reproduce);
}

Result result_of(const ClassPage& page, const std::string& scene, bool ok) {
  Result r("class", scene);
  ResultClass c{page.lesson ? MaybeText(page.lesson->title) : MaybeText(),
                page.to_come > 0,
                page.left_out,
                page.passed_over,
                page.to_come,
                {},
                {},
                page.reproduce};
  std::vector<std::vector<Finding>> all;
  std::vector<Finding> expert;
  for (const ClassRow& row : page.rows) {
    const ReportData& d = row.member.result;
    const auto of = [&](const char* name) {
      const auto at = d.exercise.find(name);
      return at == d.exercise.end() ? Maybe() : Maybe(at->second);
    };
    const ClassForces f = forces_of(row.member);
    ResultStudent s{row.member.name,
                    row.expert,
                    row.member.also.kind,
                    of("time_s"),
                    of("path_mm"),
                    f.peak_N,
                    f.closure_N,
                    d.residual,
                    {},
                    {},
                    d.lesson.tolerances,
                    std::vector<std::string>()};
    if (!row.walk.steps.empty()) s.out_of_order = row.walk.out_of_order, s.elsewhere = row.walk.elsewhere;
    for (const Finding& x : row.findings)
      if (x.wrong) s.wrong->push_back(x.what + (x.words.empty() ? "" : ": " + x.words));
    c.students.push_back(std::move(s));
    if (row.expert)
      expert = row.findings;
    else
      all.push_back(row.findings);
  }
  for (const ClassFinding& f : class_findings(all, expert))
    c.wrong.push_back({f.what, f.unit, f.wrong, f.judged, f.median, f.limit, f.expert, f.expert_wrong});
  write_fields(r, "", c);
  r.set_ok(ok);
  return r;
}

void tell_left_out(const std::vector<LeftOut>& all) {
  constexpr size_t kNamed = 20;
  size_t passed = 0;
  std::string names;
  for (const LeftOut& l : all) {
    if (l.broken) {
      say(l.path + ": left out: " + l.reason);
      continue;
    }
    if (++passed <= kNamed) names += (names.empty() ? "" : ", ") + fs::path(l.path).filename().string();
  }
  if (passed > 0)
    say(fmt::format("passed over, being neither recording, script nor result: {}{}", names,
                    passed > kNamed ? fmt::format(" and {} more", passed - kNamed) : ""));
}

int run_class(const ClassOptions& o) {
  catch_interrupts();
  o.common.prepare();
  if (o.common.out_dir.empty())
    throw InputError("", 0, "class: expected --out DIR, a folder for the page and the table");
  if (!o.key.empty()) check_writable(o.key), check_replaces(o.key, kKeyHeader, "a key of names");
  GatheredSessions found;
  {
    Progress progress("class");
    found = gather(o.folder, o.common.out_dir, [&](size_t n) {
      progress.note(fmt::format("looking, {} found", n));
      return !interrupted();
    });
  }
  if (found.sessions.empty() && !interrupted()) {
    tell_left_out(found.left_out);
    throw InputError(o.folder, 0,
                     "holds no session that can be used; expected recordings (.lcm), scripts (.jsonl) or "
                     "folders with a result.json");
  }
  const Against against = held_against(o, found.sessions);
  if (!against.lesson)
    say("no lesson is shipped under the name of these sessions' scene: nothing is judged by one; --lesson NAME does");

  // The expert, and those who are held against it.
  std::optional<FoundSession> expert;
  if (!against.expert.empty()) expert = session_at(against.expert);
  std::map<std::string, std::string> key;  // pseudonym to file
  std::set<uint64_t> seen;
  std::vector<FoundSession> students;
  const std::string commonest = commonest_scene(found.sessions);
  for (const FoundSession& s : found.sessions) {
    const auto leave_out = [&](const std::string& why) { found.left_out.push_back({s.path, why, true}); };
    if (expert && s.content == expert->content)
      say(s.path + ": is the expert's own, and no student's");
    else if (!seen.insert(s.content).second)
      leave_out("is the same as another one here, byte for byte");
    else if (const std::string why = of_another(s, against, commonest); !why.empty())
      leave_out(why);
    else
      students.push_back(s);
  }
  std::sort(students.begin(), students.end(),
            [](const auto& a, const auto& b) { return pseudonym(a.content) < pseudonym(b.content); });

  ClassPage page;
  page.lesson = against.lesson ? &*against.lesson : nullptr;
  page.pseudonyms = !o.names;
  page.reproduce = this_call();
  page.w = o.common.words();
  page.plan = make_lesson_plan(page.lesson, against.script);
  const std::string scene = against.lesson ? against.lesson->scene : commonest;
  know_patient(page.plan, scene, o.common.worker_count());
  Measuring measuring(o, against, students.size() + (expert ? 1 : 0));
  size_t number = 0, measured_ones = 0;
  if (expert) {
    std::optional<ClassMember> m = measuring.one(*expert, number++);
    if (m) {
      if (page.plan.acts.empty()) {
        page.plan = make_lesson_plan(page.lesson, acts_of(*m).command);
        know_patient(page.plan, scene, o.common.worker_count());
      }
      m->name = "expert";
      page.rows.push_back(row_of(std::move(*m), page.plan, true));
    }
  }
  for (const FoundSession& s : students) {
    if (interrupted()) break;
    try {
      std::optional<ClassMember> m = measuring.one(s, number++);
      if (!m) break;
      key[pseudonym(s.content)] = s.path;
      std::error_code ec;
      m->name = o.names ? fs::relative(s.path, o.folder, ec).string() : pseudonym(s.content);
      page.rows.push_back(row_of(std::move(*m), page.plan, false));
      ++measured_ones;
    } catch (const InputError& e) {
      measuring.clear();
      std::string why = e.what();
      if (why.starts_with(s.path + ": ")) why.erase(0, s.path.size() + 2);
      found.left_out.push_back({s.path, why, true}), ++measured_ones;
    } catch (const SessionFailure& e) {
      measuring.clear();
      found.left_out.push_back({s.path, std::string("cannot be done again: ") + e.what(), true}), ++measured_ones;
    }
  }
  measuring.clear();
  tell_left_out(found.left_out);
  page.to_come = int(students.size() - measured_ones);
  for (const LeftOut& l : found.left_out) (l.broken ? page.left_out : page.passed_over) += 1;
  const bool any = std::any_of(page.rows.begin(), page.rows.end(), [](const ClassRow& r) { return !r.expert; });

  // What it leaves.
  const std::string dir = o.common.out_dir;
  const std::vector<ClassColumn> columns = class_columns(page.rows);
  write_whole_file(dir + "/class.csv", csv_of(columns));
  write_whole_file(dir + "/columns.csv", csv_of_meanings(columns));
  const bool whole = any && page.to_come == 0 && page.left_out == 0;
  const Result r = result_of(page, against.lesson ? against.lesson->scene : commonest, whole);
  r.write(dir + "/result.json");
  if (!o.common.json_file.empty()) r.write(o.common.json_file);
  write_whole_file(dir + "/class.html", class_html(page));
  if (!o.key.empty()) {
    std::string text = std::string(kKeyHeader) + "\n";
    for (const auto& [name, file] : key) text += csv_field(name) + "," + csv_field(file) + "\n";
    write_whole_file(o.key, text);
    std::printf("key         %s, who is who: keep it apart\n", o.key.c_str());
  }
  std::vector<std::vector<Finding>> all;
  for (const ClassRow& row : page.rows)
    if (!row.expert) all.push_back(row.findings);
  std::printf("class       %zu of %zu measured%s\n", all.size(), students.size(), expert ? ", and the expert" : "");
  int told = 0;
  for (const ClassFinding& f : class_findings(all, {}))
    if (told++ < 3) std::printf("wrong       %d of %d: %s\n", f.wrong, f.judged, f.what.c_str());
  std::printf("page        %s/class.html\ntable       %s/class.csv\n", dir.c_str(), dir.c_str());
  if (page.to_come > 0 || interrupted())
    say(fmt::format("interrupted with {} to come; the same call goes on from there", page.to_come));
  return whole && !interrupted() ? kDone : kGoalMissed;
}

}  // namespace

void add_class(CLI::App& app, Chosen& chosen) {
  auto o = std::make_shared<ClassOptions>();
  CLI::App* c =
      app.add_subcommand("class", "Many students' recordings beside an expert's, by a lesson: page and table");
  c->add_option("FOLDER", o->folder, "Recordings (.lcm), scripts (.jsonl), folders of sessions (result.json)")
      ->required();
  c->add_option("--lesson", o->lesson,
                "Judge by this lesson: its file, or the name of a shipped one (default: that of the sessions' scene)")
      ->type_name("LESSON");
  CLI::Option* expert = c->add_option("--expert", o->expert,
                                      "The expert's recording, script or folder (default: the one shipped with the "
                                      "lesson)")
                            ->type_name("FILE|DIR");
  c->add_flag("--no-expert", o->no_expert, "Beside nobody")->excludes(expert);
  c->add_option(
       "--cell-mm", o->cell_mm,
       "Everything on cells of this size: larger ones are quicker, and sessions then no longer come out to the "
       "bit as they were")
      ->type_name("H")
      ->check(number_from(0.5, 50.0));
  c->add_flag("--names", o->names, "The files' names instead of pseudonyms");
  c->add_option("--key", o->key, "Write which pseudonym is which file into this table; keep it apart from the page")
      ->type_name("FILE");
  c->add_flag("--anew", o->anew, "Measure again what was measured already");
  o->common.add_out(*c), o->common.add_words(*c), o->common.add_json(*c), o->common.add_workers(*c);
  c->footer(
      "Exit status 3: something in the folder could not be used, or the call was interrupted; the same call goes on.\n"
      "Example: limberg class my-class --lesson rhomboid --out out/class");
  c->callback([o, &chosen] { chosen = [o] { return run_class(*o); }; });
}

}  // namespace limberg
