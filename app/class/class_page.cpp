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
  const Words& w = p.w;
  const std::string of =
      p.lesson ? w(p.lesson->title) : w("No lesson: nothing is judged but what is judged of every session");
  return paragraph(bold(of) + soft("   " + w.counted(int64_t(students), "{} student", "{} students", students))) +
         (p.lesson ? paragraph(w(p.lesson->goal)) : Markup());
}

std::string in_words(const ClassFinding& f, const Words& w) {
  std::string s = w("{} of {}: {}", f.wrong, f.judged, w.said(f.what));
  if (f.median && f.limit && f.key.starts_with("tolerance/"))
    s += " " + w("(median of these {}, at most {})", quantity(f.median, f.unit, 2), quantity(f.limit, f.unit));
  return s;
}

Markup summary(const Class& c) {
  const Words& w = c.page.w;
  Markup m;
  if (c.page.to_come > 0)
    m += notice(w("Interrupted: {} more to be measured. The same call goes on from here.", c.page.to_come));
  if (c.page.left_out > 0)
    m += notice(w("{} in the folder could not be used; the call says which and why.", c.page.left_out));
  if (c.students.empty()) return m + verdict(Light::warn, w("No student was measured."));
  Markup says;
  if (c.wrong.empty()) {
    says = w("Nobody has anything wrong that was looked at.");
  } else {
    says = bold(w("What the class gets wrong most.")) + (" " + in_words(c.wrong.front(), w) + ".");
    for (size_t i = 1; i < std::min<size_t>(3, c.wrong.size()); ++i)
      says += " " + Markup(in_words(c.wrong[i], w) + ".");
  }
  m += verdict(c.wrong.empty() ? Light::good : c.wrong.front().share() >= 0.5 ? Light::warn : Light::none, says);
  const auto beside = [&](const Maybe& of_expert, const std::string& words) {
    return c.expert && of_expert ? w("expert {}", words) : std::string();
  };
  const auto time = [](const ClassRow& r) { return exercise_of(r.member.result, "time_s"); };
  const auto path = [](const ClassRow& r) { return exercise_of(r.member.result, "path_mm"); };
  const auto peak = [](const ClassRow& r) { return forces_of(r.member).peak_N; };
  const auto of_expert = [&](const auto& of) { return c.expert ? of(*c.expert) : Maybe(); };
  std::vector<Card> all;
  all.push_back({std::to_string(c.students.size()), w("students"), "", Light::none});
  if (const Maybe t = c.median(time))
    all.push_back({clock_of(t), w("median time"), beside(of_expert(time), clock_of(of_expert(time)))});
  if (const Maybe way = c.median(path))
    all.push_back({metres(way), w("median way of the hand"), beside(of_expert(path), metres(of_expert(path)))});
  if (const Maybe f = c.median(peak))
    all.push_back({quantity(f, "N"), w("median of the largest force of a stitch"),
                   beside(of_expert(peak), quantity(of_expert(peak), "N"))});
  return m + cards(all);
}

Markup what_goes_wrong(const Class& c) {
  const Words& w = c.page.w;
  if (c.wrong.empty()) return {};
  std::vector<Row> rows;
  for (const ClassFinding& f : c.wrong) {
    const Light light = f.share() >= 0.5 ? Light::bad : f.share() >= 0.25 ? Light::warn : Light::none;
    Row r{w.said(f.what), w("{} of {}", f.wrong, f.judged), meter(f.share(), light)};
    const bool has_figure = f.key.starts_with("tolerance/") || f.key == "count/force";
    r.push_back(has_figure && f.median ? quantity(f.median, f.unit, 2) : std::string());
    r.push_back(has_figure && f.limit ? quantity(f.limit, f.unit) : std::string());
    r.push_back(!c.expert        ? Cell("")
                : f.expert_wrong ? Cell(w("too"), Light::warn)
                : f.expert       ? Cell(has_figure ? quantity(f.expert, f.unit, 2) : std::string(w("no")))
                                 : Cell("–"));
    r.push_back(w.said(f.advice));
    rows.push_back(std::move(r));
  }
  return section(
      w("What the class gets wrong"),
      note(w("How many of those who could be judged have it wrong, the median of these, what may be, and the "
             "expert. Where the expert has it wrong too, look at the lesson before the students.")) +
          table_of_words({"", w("students"), "", w("median"), w("at most"), w("expert"), w("what helps")}, rows));
}

/// One cell of the table at a glance: a dot, and the figure.
Cell judged_cell(const ClassRow& r, const std::string& key, bool of_figure, const Words& w) {
  for (const Finding& f : r.findings) {
    if (f.key != key) continue;
    if (!f.judged) return soft_cell(explained("–", w.said(f.words)));
    const Light light = f.wrong ? Light::bad : Light::good;
    const std::string text = of_figure ? quantity(f.value, "", 2)
                             : key.starts_with("count/ended")
                                 ? std::string(w(f.wrong ? english("cut short") : english("whole")))
                             : key.starts_with("count/rest") ? std::string(w(f.wrong ? english("no") : english("yes")))
                             : f.value                       ? number(*f.value)
                                                             : std::string("–");
    return Cell(dot(light) + explained(text, w.said(f.words)), f.wrong ? Light::bad : Light::none);
  }
  return soft_cell("–");
}

Markup at_a_glance(const Class& c) {
  if (c.page.rows.empty()) return {};
  const Words& w = c.page.w;
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
      Markup head = f.key == "count/force"    ? Markup(w("Largest force of a stitch, N"))
                    : f.key == "count/missed" ? Markup(w("Presses that came to nothing"))
                    : f.key == "count/undos"  ? Markup(w("Acts taken back"))
                    : f.key == "count/rest"   ? Markup(w("At rest"))
                    : f.key == "count/ended"  ? Markup(w("Recording"))
                                              : Markup(w.said(f.what));
      if (!limit.empty()) head += line_break() + soft(limit);
      columns.push_back({f.key, std::move(head), figure || f.key == "count/force"});
    }
  const auto table_of = [&](bool of_lesson) {
    Row head{""};
    if (of_lesson)
      for (const char* first : {english("Time"), english("Steps done")}) head.push_back(w(first));
    const auto here = [&](const Column& k) { return k.key.starts_with("tolerance/") == of_lesson; };
    for (const Column& k : columns)
      if (here(k)) head.push_back(k.head);
    std::vector<Row> rows;
    for (const ClassRow& r : c.page.rows) {
      Row row{r.expert ? Cell(bold(w("Expert"))) : Cell(r.member.name)};
      int done = 0;
      for (const StepWalk& s : r.walk.steps) done += s.done == s.planned;
      if (of_lesson) {
        row.push_back(clock_of(exercise_of(r.member.result, "time_s")));
        row.push_back(r.walk.steps.empty() ? Cell("–") : Cell(w("{} of {}", done, r.walk.steps.size())));
      }
      for (const Column& k : columns)
        if (here(k)) row.push_back(judged_cell(r, k.key, k.of_figure, w));
      rows.push_back(std::move(row));
    }
    return head.size() > 1 ? table(head, rows) : Markup();
  };
  return section(
      w("At a glance"),
      note(w("Each thing for itself: a green dot is within what may be, a red one is not, a dash could not be "
             "judged (what the program has shown is not). There is no sum: a lesson's things do not weigh the "
             "same, and students are in the order of their names.")) +
          titled(w(c.page.lesson ? english("What the lesson asks") : english("How long it took")), table_of(true)) +
          titled(w("What went wrong on the way"), table_of(false)));
}

Markup times(const Class& c) {
  std::vector<StepTimes> bars;
  std::vector<Row> rows;
  const Words& w = c.page.w;
  Row head{"", w("Total")};
  if (c.page.rows.empty()) return {};
  for (const StepWalk& s : c.page.rows.front().walk.steps) head.push_back(w(s.name));
  head.push_back(w("Elsewhere")), head.push_back(w("Taken back")), head.push_back(w("After the last act"));
  head.push_back(w("Way of the hand")), head.push_back(w("Movements"));
  bool any = false;
  for (const ClassRow& r : c.page.rows) {
    const std::string name = r.expert ? w("Expert") : r.member.name;
    Row row{r.expert ? Cell(bold(name)) : Cell(name)};
    row.push_back(clock_of(exercise_of(r.member.result, "time_s")));
    StepTimes bar{name, {}};
    for (const StepWalk& s : r.walk.steps) {
      row.push_back(s.time_s ? Cell(clock_of(s.time_s)) : soft_cell(s.done == 0 ? w("not done") : "–"));
      if (s.time_s) bar.parts.emplace_back(w(s.name), *s.time_s);
    }
    for (const auto& [name_of, v] : {std::pair<const char*, Maybe>{w("Elsewhere"), r.walk.elsewhere_s},
                                     {w("Taken back"), r.walk.taken_back_s},
                                     {w("After the last act"), r.walk.afterwards_s}}) {
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
      w("The time before an act counts for its step, in whatever order they came; minutes:seconds. Slower is not worse "
        "by itself."));
  if (!bars.empty()) m += chart(step_times_svg(bars, w("Time of each step, a bar for each student")));
  return section(w("Times"), m + table(head, rows));
}

std::string place_of(const ClassPage& p, const ClassForces& f) {
  if (!f.x_mm || !f.y_mm) return "–";
  const std::string near = near_letter(p.plan.letters, {*f.x_mm, *f.y_mm}, p.w);
  return (near.empty() ? "" : near + ", ") +
         p.w("({:.0f}, {:.0f}) mm", std::round(*f.x_mm) + 0.0, std::round(*f.y_mm) + 0.0);
}

Markup forces(const Class& c) {
  const Words& w = c.page.w;
  std::vector<Row> rows;
  bool any = false;
  for (const ClassRow& r : c.page.rows) {
    const ClassForces f = forces_of(r.member);
    any |= f.peak_N.has_value();
    Row row{r.expert ? Cell(bold(w("Expert"))) : Cell(r.member.name)};
    row.push_back(Cell(quantity(f.peak_N, "N"), f.peak_N ? light_of_force(*f.peak_N) : Light::none));
    row.push_back(place_of(c.page, f));
    row.push_back(quantity(f.mean_N, "N")), row.push_back(quantity(f.closure_N, "N"));
    row.push_back(quantity(exercise_of(r.member.result, "peaks_over_2_5_N"), ""));
    row.push_back(quantity(exercise_of(r.member.result, "stitches"), ""));
    row.push_back(quantity(r.member.result.metric("hook_force_N"), "N"));
    rows.push_back(std::move(row));
  }
  if (!any) return {};
  return section(
      w("Forces"),
      note(w(
          "Of the stitches, in states at rest. Below 2.5 N skin keeps its blood (Larrabee, Holloway and Sutton 1984); "
          "forces are right in kind and order, not to the gram.")) +
          table({"", w("largest ever"), w("where"), w("mean at the end"), w("all together"), w("over 2.5 N"),
                 w("stitches"), w("hooks still held")},
                rows));
}

Markup words_of(const ClassRow& r, const Words& w) {
  std::vector<Markup> off;
  for (const Finding& f : r.findings) {
    if (!f.wrong) continue;
    off.push_back(bold(w.said(f.what)) + (f.words.empty() ? Markup() : Markup(": " + w.said(f.words))));
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
    for (const auto& [why, n] : missed) s += (s.empty() ? "" : "; ") + fmt::format("{} × {}", n, w.said(why));
    off.push_back(soft(w("Presses: {}", s)));
  }
  if (off.empty()) return paragraph(w("Nothing that was looked at is wrong."));
  return list(off);
}

Markup one(const Class& c, const ClassRow& r) {
  const Words& w = c.page.w;
  const std::string name = r.expert ? w("Expert") : r.member.name;
  const bool has_path = !r.member.also.path.empty() || !r.member.result.script.empty();
  Markup pictures;
  if (has_path)
    pictures += figure(
        svg_data_url(path_svg(c.frame, c.page.plan, r.member, r.expert || !c.expert ? nullptr : &c.expert->member,
                              w("Way of the tool of {}", name))),
        w("Way of the tool of {}", name),
        r.member.also.path.empty() ? w("Cuts of the script; no hand was recorded") : w("Way of the tool"));
  const std::string picture = r.member.picture.empty() ? "" : picture_data_url(r.member.picture, kPicture_px);
  pictures += figure(picture, w("The result of {}", name), picture.empty() ? w("No picture") : w("At the end"));
  const std::string kind = r.member.also.kind;
  Markup figures;
  std::vector<std::string> said;
  if (const Maybe t = exercise_of(r.member.result, "time_s")) {
    std::string s = clock_of(t);
    if (const Maybe e = c.expert && !r.expert ? exercise_of(c.expert->member.result, "time_s") : Maybe(); e && *e > 0)
      s += " " + w("({} × the expert's)", number(*t / *e, 2));
    said.push_back(s);
  }
  if (const Maybe way = exercise_of(r.member.result, "path_mm")) said.push_back(w("{} of the hand", metres(way)));
  if (const Maybe p = forces_of(r.member).peak_N)
    said.push_back(w("{} at the hardest stitch, {}", quantity(p, "N"), place_of(c.page, forces_of(r.member))));
  if (kind == "script") said.push_back(w("a script, carried out without a hand"));
  if (kind == "result") said.push_back(w("from its session's folder: no way of the hand"));
  if (!r.member.also.damage.empty()) said.push_back(w("the recording is damaged: {}", r.member.also.damage));
  return titled(name,
                (said.empty() ? Markup() : soft_paragraph(joined(said, "; "))) + pairs(pictures) + words_of(r, w));
}

Markup each(const Class& c) {
  Markup m;
  for (const ClassRow& r : c.page.rows) m += one(c, r);
  return m.empty() ? m : section(c.page.w("Each one"), note(c.page.w(path_legend())) + m);
}

Markup tables_beside(const std::vector<ClassColumn>& columns, const Words& w) {
  std::vector<Row> rows;
  for (const ClassColumn& k : columns) rows.push_back({code(k.name), k.unit, w.said(k.meaning)});
  return section(
      w("Columns of class.csv"),
      note(w("One row a student, for your own statistics; empty: not measured. The same list is columns.csv.")) +
          table_of_words({"", w("unit"), ""}, rows));
}

}  // namespace

std::string class_html(const ClassPage& p) {
  const Class c(p);
  const Words& w = p.w;
  Markup all = what_goes_wrong(c);
  all += at_a_glance(c);
  all += times(c);
  all += forces(c);
  all += each(c);
  all += tables_beside(class_columns(p.rows), w);
  Markup footer = program_name();
  if (p.pseudonyms)
    footer += std::string(". ") + w("Names are made from the content of the recordings; nobody's own is on this page.");
  if (!p.reproduce.empty()) footer += Markup(". ") + code(p.reproduce);
  const std::string title = p.lesson ? w("Class: {}", w(p.lesson->title)) : w("Class");
  return text_of({title, w("A class"), opening(p, c.students.size()), summary(c), all, footer, {}, w});
}

}  // namespace limberg
