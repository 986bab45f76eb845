// What a lesson asked, and what the exercise came to in figures.
#include <algorithm>

#include "app/report/html.h"
#include "app/report/sections.h"

namespace limberg::sections {

using html::Light;
using html::quantity;

namespace {

html::Markup judged(const ResultTolerance& t) {
  if (t.value) {
    html::Markup said = t.met ? html::bold("met", Light::good) : html::bold("missed", Light::bad);
    if (!t.why.empty()) said += html::Markup(" " + t.why);
    return said;
  }
  return t.why.empty() ? "not measured" : "not measured: " + t.why;
}

}  // namespace

html::Markup exercise(const ReportSource& source) {
  const ReportData& d = source.d;
  const std::string lesson = said(d.lesson.title);
  html::Markup body;
  if (!lesson.empty()) {
    body += html::paragraph(said(d.lesson.goal));
    bool all_met = true;
    std::vector<html::Row> rows;
    for (const ResultTolerance& t : entries(d.lesson.tolerances)) {
      all_met &= t.met;
      rows.push_back({spoken(t.name), quantity(t.value, t.unit), "≤ " + quantity(t.limit, t.unit), judged(t)});
    }
    if (const std::vector<std::string>& steps = entries(d.lesson.steps); !steps.empty())
      body += html::list(std::vector<html::Markup>(steps.begin(), steps.end()));
    body += html::table({"Tolerance", "Value", "Limit", ""}, rows);
    const std::vector<std::string>& hints = entries(d.lesson.hints);
    if (!hints.empty() && !all_met)
      body += html::paragraph("Hints:") + html::list(std::vector<html::Markup>(hints.begin(), hints.end()));
  }
  if (!d.exercise.empty()) {
    std::vector<html::Row> rows;
    for (const auto& [name, value] : d.exercise) rows.push_back({spoken(name), html::number(value, 4)});
    body += html::table({"Figure", "Value"}, rows) +
            html::note("No grade: no published scale turns these figures into one. The script below is the evidence.");
  }
  return html::section(lesson.empty() ? "The exercise in figures" : "Lesson: " + lesson, body);
}

}  // namespace limberg::sections
