#include "app/class/class_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/class/path_drawing.h"
#include "app/program/version.h"
#include "app/report/elements.h"
#include "app/report/html.h"
#include "app/report/page.h"
#include "app/report/parts.h"
#include "app/report/svg_chart.h"

namespace limberg {
namespace {

using namespace html;

constexpr int kPicture_px = 480;
constexpr size_t kMostCharted = 60;

/// 4:12 of 252 s.
std::string clock_of(const Maybe& s) {
  if (!s || !std::isfinite(*s)) return "–";
  if (*s < 60) return number(*s, 2) + "\u202fs";
  const auto whole = int64_t(std::min(std::round(*s), 1e9));
  return fmt::format("{}:{:02}", whole / 60, whole % 60);
}

std::string metres(const Maybe& mm) {
  return !mm ? "–" : *mm < 1000 ? quantity(std::round(*mm), "mm") : quantity(*mm / 1000, "m");
}

struct Class {
  const ClassPage& page;
  const ClassRow* expert = nullptr;
  std::vector<const ClassRow*> students;
  std::vector<ClassFinding> wrong;
  DrawnFrame frame;

  explicit Class(const ClassPage& p) : page(p) {
    std::vector<std::vector<Finding>> all;
    std::vector<const ClassMember*> drawn;
    for (const ClassRow& r : p.rows) {
      drawn.push_back(&r.member);
      if (r.expert) {
        expert = &r;
        continue;
      }
      students.push_back(&r), all.push_back(r.findings);
    }
    wrong = class_findings(all, expert ? std::span<const Finding>(expert->findings) : std::span<const Finding>());
    frame = frame_of(p.plan, drawn);
  }
  /// Of all students; not a number where none has it.
  template <class Of>
  Maybe median(const Of& of) const {
    std::vector<double> v;
    for (const ClassRow* s : students)
      if (const Maybe x = of(*s)) v.push_back(*x);
    const double m = median_of(v);
    return std::isfinite(m) ? Maybe(m) : Maybe();
  }
};

Markup opening(const ClassPage& p, size_t students) {
  const std::string of =
      p.lesson ? p.lesson->title : "No lesson: nothing is judged but what is judged of every session";
  return paragraph(bold(of) + soft(fmt::format("   {} student{}", students, students == 1 ? "" : "s"))) +
         (p.lesson ? paragraph(p.lesson->goal) : Markup());
}

std::string in_words(const ClassFinding& f) {
  std::string s = fmt::format("{} of {}: {}", f.wrong, f.judged, f.what);
  if (f.median && f.limit && f.key.starts_with("tolerance/"))
    s += fmt::format(" (median of these {}, at most {})", quantity(f.median, f.unit, 2), quantity(f.limit, f.unit));
  return s;
}

Markup summary(const Class& c) {
  Markup m;
  if (c.page.to_come > 0)
    m += notice(fmt::format("Interrupted: {} more to be measured. The same call goes on from here.", c.page.to_come));
  if (c.page.left_out > 0)
    m += notice(fmt::format("{} in the folder could not be used; the call says which and why.", c.page.left_out));
  if (c.students.empty()) return m + verdict(Light::warn, "No student was measured.");
  Markup says;
  if (c.wrong.empty()) {
    says = "Nobody has anything wrong that was looked at.";
  } else {
    says = bold("What the class gets wrong most. ") + in_words(c.wrong.front()) + ".";
    for (size_t i = 1; i < std::min<size_t>(3, c.wrong.size()); ++i) says += " " + Markup(in_words(c.wrong[i]) + ".");
  }
  m += verdict(c.wrong.empty() ? Light::good : c.wrong.front().share() >= 0.5 ? Light::warn : Light::none, says);
  const auto beside = [&](const Maybe& of_expert, const std::string& words) {
    return c.expert && of_expert ? "expert " + words : std::string();
  };
  const auto time = [](const ClassRow& r) { return exercise_of(r.member.result, "time_s"); };
  const auto path = [](const ClassRow& r) { return exercise_of(r.member.result, "path_mm"); };
  const auto peak = [](const ClassRow& r) { return forces_of(r.member).peak_N; };
  const auto of_expert = [&](const auto& of) { return c.expert ? of(*c.expert) : Maybe(); };
  std::vector<Card> all;
  all.push_back({std::to_string(c.students.size()), "students", "", Light::none});
  if (const Maybe t = c.median(time))
    all.push_back({clock_of(t), "median time", beside(of_expert(time), clock_of(of_expert(time)))});
  if (const Maybe w = c.median(path))
    all.push_back({metres(w), "median way of the hand", beside(of_expert(path), metres(of_expert(path)))});
  if (const Maybe f = c.median(peak))
    all.push_back({quantity(f, "N"), "median of the largest force of a stitch",
                   beside(of_expert(peak), quantity(of_expert(peak), "N"))});
  return m + cards(all);
}

Markup what_goes_wrong(const Class& c) {
  if (c.wrong.empty()) return {};
  std::vector<Row> rows;
  for (const ClassFinding& f : c.wrong) {
    const Light light = f.share() >= 0.5 ? Light::bad : f.share() >= 0.25 ? Light::warn : Light::none;
    Row r{f.what, fmt::format("{} of {}", f.wrong, f.judged), meter(f.share(), light)};
    const bool has_figure = f.key.starts_with("tolerance/") || f.key == "count/force";
    r.push_back(has_figure && f.median ? quantity(f.median, f.unit, 2) : std::string());
    r.push_back(has_figure && f.limit ? quantity(f.limit, f.unit) : std::string());
    r.push_back(!c.expert        ? Cell("")
                : f.expert_wrong ? Cell("too", Light::warn)
                : f.expert       ? Cell(has_figure ? quantity(f.expert, f.unit, 2) : std::string("no"))
                                 : Cell("–"));
    r.push_back(f.advice);
    rows.push_back(std::move(r));
  }
  return section("What the class gets wrong",
                 note("How many of those who could be judged have it wrong, the median of these, what may be, and the "
                      "expert. Where the expert has it wrong too, look at the lesson before the students.") +
                     table_of_words({"", "students", "", "median", "at most", "expert", "what helps"}, rows));
}

/// One cell of the table at a glance: a dot, and the figure.
Cell judged_cell(const ClassRow& r, const std::string& key, bool of_figure) {
  for (const Finding& f : r.findings) {
    if (f.key != key) continue;
    if (!f.judged) return soft_cell(explained("–", f.words));
    const Light light = f.wrong ? Light::bad : Light::good;
    const std::string text = of_figure                        ? quantity(f.value, "", 2)
                             : key.starts_with("count/ended") ? std::string(f.wrong ? "cut short" : "whole")
                             : key.starts_with("count/rest")  ? std::string(f.wrong ? "no" : "yes")
                             : f.value                        ? number(*f.value)
                                                              : std::string("–");
    return Cell(dot(light) + explained(text, f.words), f.wrong ? Light::bad : Light::none);
  }
  return soft_cell("–");
}

Markup at_a_glance(const Class& c) {
  if (c.page.rows.empty()) return {};
  struct Column {
    std::string key;
    Markup head;
    bool of_figure;
  };
  std::vector<Column> columns;
  for (const ClassRow& r : c.page.rows)
    for (const Finding& f : r.findings) {
      if (f.key.starts_with("off/") || f.key.starts_with("not done/")) continue;
      if (std::any_of(columns.begin(), columns.end(), [&](const Column& x) { return x.key == f.key; })) continue;
      const bool figure = f.key.starts_with("tolerance/");
      const std::string limit = figure && f.limit ? fmt::format("≤ {}", quantity(f.limit, f.unit)) : std::string();
      Markup head = f.key == "count/force"    ? Markup("Largest force of a stitch, N")
                    : f.key == "count/missed" ? Markup("Presses that came to nothing")
                    : f.key == "count/undos"  ? Markup("Acts taken back")
                    : f.key == "count/rest"   ? Markup("At rest")
                    : f.key == "count/ended"  ? Markup("Recording")
                                              : Markup(f.what);
      if (!limit.empty()) head += line_break() + soft(limit);
      columns.push_back({f.key, std::move(head), figure || f.key == "count/force"});
    }
  const auto table_of = [&](bool of_lesson) {
    Row head{""};
    if (of_lesson)
      for (const char* first : {"Time", "Steps done"}) head.push_back(first);
    const auto here = [&](const Column& k) { return k.key.starts_with("tolerance/") == of_lesson; };
    for (const Column& k : columns)
      if (here(k)) head.push_back(k.head);
    std::vector<Row> rows;
    for (const ClassRow& r : c.page.rows) {
      Row row{r.expert ? Cell(bold("Expert")) : Cell(r.member.name)};
      int done = 0;
      for (const StepWalk& s : r.walk.steps) done += s.done == s.planned;
      if (of_lesson) {
        row.push_back(clock_of(exercise_of(r.member.result, "time_s")));
        row.push_back(r.walk.steps.empty() ? Cell("–") : Cell(fmt::format("{} of {}", done, r.walk.steps.size())));
      }
      for (const Column& k : columns)
        if (here(k)) row.push_back(judged_cell(r, k.key, k.of_figure));
      rows.push_back(std::move(row));
    }
    return head.size() > 1 ? table(head, rows) : Markup();
  };
  return section("At a glance",
                 note("Each thing for itself: a green dot is within what may be, a red one is not, a dash could not be "
                      "judged (what the program has shown is not). There is no sum: a lesson's things do not weigh the "
                      "same, and students are in the order of their names.") +
                     titled(c.page.lesson ? "What the lesson asks" : "How long it took", table_of(true)) +
                     titled("What went wrong on the way", table_of(false)));
}

Markup times(const Class& c) {
  std::vector<StepTimes> bars;
  std::vector<Row> rows;
  Row head{"", "Total"};
  if (c.page.rows.empty()) return {};
  for (const StepWalk& s : c.page.rows.front().walk.steps) head.push_back(s.name);
  head.push_back("Elsewhere"), head.push_back("Taken back"), head.push_back("After the last act");
  head.push_back("Way of the hand"), head.push_back("Movements");
  bool any = false;
  for (const ClassRow& r : c.page.rows) {
    const std::string name = r.expert ? "Expert" : r.member.name;
    Row row{r.expert ? Cell(bold(name)) : Cell(name)};
    row.push_back(clock_of(exercise_of(r.member.result, "time_s")));
    StepTimes bar{name, {}};
    for (const StepWalk& s : r.walk.steps) {
      row.push_back(s.time_s ? Cell(clock_of(s.time_s)) : soft_cell(s.done == 0 ? "not done" : "–"));
      if (s.time_s) bar.parts.emplace_back(s.name, *s.time_s);
    }
    for (const auto& [name_of, v] : {std::pair<const char*, Maybe>{"Elsewhere", r.walk.elsewhere_s},
                                     {"Taken back", r.walk.taken_back_s},
                                     {"After the last act", r.walk.afterwards_s}}) {
      row.push_back(clock_of(v));
      if (v) bar.parts.emplace_back(name_of, *v);
    }
    row.push_back(metres(exercise_of(r.member.result, "path_mm")));
    row.push_back(quantity(exercise_of(r.member.result, "movements"), ""));
    any |= exercise_of(r.member.result, "time_s").has_value();
    if (!bar.parts.empty() && bars.size() < kMostCharted) bars.push_back(std::move(bar));
    rows.push_back(std::move(row));
  }
  if (!any) return {};
  Markup m = note(
      "The time before an act counts for its step, in whatever order they came; minutes:seconds. Slower is not worse "
      "by "
      "itself.");
  if (!bars.empty()) m += chart(step_times_svg(bars, "Time of each step, a bar for each student"));
  return section("Times", m + table(head, rows));
}

std::string place_of(const ClassPage& p, const ClassForces& f) {
  if (!f.x_mm || !f.y_mm) return "–";
  const std::string near = near_letter(p.plan.letters, {*f.x_mm, *f.y_mm});
  return fmt::format("{}({:.0f}, {:.0f}) mm", near.empty() ? "" : near + ", ", std::round(*f.x_mm) + 0.0,
                     std::round(*f.y_mm) + 0.0);
}

Markup forces(const Class& c) {
  std::vector<Row> rows;
  bool any = false;
  for (const ClassRow& r : c.page.rows) {
    const ClassForces f = forces_of(r.member);
    any |= f.peak_N.has_value();
    Row row{r.expert ? Cell(bold("Expert")) : Cell(r.member.name)};
    row.push_back(Cell(quantity(f.peak_N, "N"), f.peak_N ? light_of_force(*f.peak_N) : Light::none));
    row.push_back(place_of(c.page, f));
    row.push_back(quantity(f.mean_N, "N")), row.push_back(quantity(f.closure_N, "N"));
    row.push_back(quantity(exercise_of(r.member.result, "peaks_over_2_5_N"), ""));
    row.push_back(quantity(exercise_of(r.member.result, "stitches"), ""));
    row.push_back(quantity(r.member.result.metric("hook_force_N"), "N"));
    rows.push_back(std::move(row));
  }
  if (!any) return {};
  return section("Forces", note("Of the stitches, in states at rest. Below 2.5 N skin keeps its blood (Larrabee, "
                                "Holloway and Sutton 1984); forces are right in kind and order, not to the gram.") +
                               table({"", "largest ever", "where", "mean at the end", "all together", "over 2.5 N",
                                      "stitches", "hooks still held"},
                                     rows));
}

Markup words_of(const ClassRow& r) {
  std::vector<Markup> off;
  for (const Finding& f : r.findings) {
    if (!f.wrong) continue;
    off.push_back(bold(f.what) + (f.words.empty() ? Markup() : Markup(": " + f.words)));
  }
  std::vector<std::pair<std::string, int>> missed;
  for (const std::string& why : r.member.also.missed.why) {
    const auto at = std::find_if(missed.begin(), missed.end(), [&](const auto& x) { return x.first == why; });
    if (at == missed.end())
      missed.emplace_back(why, 1);
    else
      ++at->second;
  }
  Markup m;
  if (!missed.empty()) {
    std::string s;
    for (const auto& [why, n] : missed) s += (s.empty() ? "" : "; ") + fmt::format("{} × {}", n, why);
    off.push_back(soft("Presses: " + s));
  }
  if (off.empty()) return paragraph("Nothing that was looked at is wrong.");
  return list(off);
}

Markup one(const Class& c, const ClassRow& r) {
  const std::string name = r.expert ? "Expert" : r.member.name;
  const bool has_path = !r.member.also.path.empty() || !r.member.result.script.empty();
  Markup pictures;
  if (has_path)
    pictures += figure(
        svg_data_url(path_svg(c.frame, c.page.plan, r.member, r.expert || !c.expert ? nullptr : &c.expert->member,
                              "Way of the tool of " + name)),
        "Way of the tool of " + name,
        r.member.also.path.empty() ? "Cuts of the script; no hand was recorded" : "Way of the tool");
  const std::string picture = r.member.picture.empty() ? "" : png_data_url(r.member.picture, kPicture_px);
  pictures += figure(picture, "The result of " + name, picture.empty() ? "No picture" : "At the end");
  const std::string kind = r.member.also.kind;
  Markup figures;
  std::vector<std::string> said;
  if (const Maybe t = exercise_of(r.member.result, "time_s")) {
    std::string s = clock_of(t);
    if (const Maybe e = c.expert && !r.expert ? exercise_of(c.expert->member.result, "time_s") : Maybe(); e && *e > 0)
      s += fmt::format(" ({} × the expert's)", number(*t / *e, 2));
    said.push_back(s);
  }
  if (const Maybe w = exercise_of(r.member.result, "path_mm")) said.push_back(metres(w) + " of the hand");
  if (const Maybe p = forces_of(r.member).peak_N)
    said.push_back(quantity(p, "N") + " at the hardest stitch, " + place_of(c.page, forces_of(r.member)));
  if (kind == "script") said.push_back("a script, carried out without a hand");
  if (kind == "result") said.push_back("from its session's folder: no way of the hand");
  if (!r.member.also.damage.empty()) said.push_back("the recording is damaged: " + r.member.also.damage);
  return titled(name, (said.empty() ? Markup() : soft_paragraph(joined(said, "; "))) + pairs(pictures) + words_of(r));
}

Markup each(const Class& c) {
  Markup m;
  for (const ClassRow& r : c.page.rows) m += one(c, r);
  return m.empty() ? m : section("Each one", note(path_legend()) + m);
}

Markup tables_beside(const std::vector<ClassColumn>& columns) {
  std::vector<Row> rows;
  for (const ClassColumn& k : columns) rows.push_back({code(k.name), k.unit, k.meaning});
  return section(
      "Columns of class.csv",
      note("One row a student, for your own statistics; empty: not measured. The same list is columns.csv.") +
          table_of_words({"", "unit", ""}, rows));
}

}  // namespace

std::string class_html(const ClassPage& p) {
  const Class c(p);
  Markup all = what_goes_wrong(c);
  all += at_a_glance(c);
  all += times(c);
  all += forces(c);
  all += each(c);
  all += tables_beside(class_columns(p.rows));
  Markup footer = program_name();
  if (p.pseudonyms) footer += ". Names are made from the content of the recordings; nobody's own is on this page.";
  if (!p.reproduce.empty()) footer += Markup(". ") + code(p.reproduce);
  const std::string title = p.lesson ? "Class: " + p.lesson->title : "Class";
  return text_of({title, "A class", opening(p, c.students.size()), summary(c), all, footer, {}});
}

}  // namespace limberg
