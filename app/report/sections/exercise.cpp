// What a lesson asked, and what the exercise came to in figures.
#include <algorithm>

#include "app/report/html.h"
#include "app/report/sections.h"

namespace limberg::sections {

using html::Light;
using html::quantity;

namespace {

html::Markup judged(const ResultTolerance& t, const Words& w) {
  if (t.value) {
    html::Markup said = t.met ? html::bold(w("met"), Light::good) : html::bold(w("missed"), Light::bad);
    if (!t.why.empty()) said += html::Markup(" " + w.said(t.why));
    return said;
  }
  return t.why.empty() ? w("not measured") : w("not measured: {}", w.said(t.why));
}

html::Markup list_of(const std::vector<std::string>& texts, const Words& w) {
  std::vector<html::Markup> items;
  for (const std::string& t : texts) items.emplace_back(w(t));
  return html::list(items);
}

}  // namespace

html::Markup exercise(const ReportSource& source) {
  const ReportData& d = source.d;
  const Words& w = d.w;
  const std::string lesson = w(said(d.lesson.title));
  html::Markup body;
  if (!lesson.empty()) {
    body += html::paragraph(w(said(d.lesson.goal)));
    bool all_met = true;
    std::vector<html::Row> rows;
    for (const ResultTolerance& t : entries(d.lesson.tolerances)) {
      all_met &= t.met;
      rows.push_back(
          {name_in_words(t.name, w), quantity(t.value, t.unit), "≤ " + quantity(t.limit, t.unit), judged(t, w)});
    }
    if (const std::vector<std::string>& steps = entries(d.lesson.steps); !steps.empty()) body += list_of(steps, w);
    body += html::table({w("Tolerance"), w("Value"), w("Limit"), ""}, rows);
    const std::vector<std::string>& hints = entries(d.lesson.hints);
    if (!hints.empty() && !all_met) body += html::paragraph(w("Hints:")) + list_of(hints, w);
  }
  if (!d.exercise.empty()) {
    std::vector<html::Row> rows;
    for (const auto& [name, value] : d.exercise) rows.push_back({name_in_words(name, w), html::number(value, 4)});
    body +=
        html::table({w("Figure"), w("Value")}, rows) +
        html::note(w("No grade: no published scale turns these figures into one. The script below is the evidence."));
  }
  return html::section(lesson.empty() ? w("The exercise in figures") : w("Lesson: {}", lesson), body);
}

}  // namespace limberg::sections
