#include "app/class/findings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "app/assembly/lesson.h"
#include "app/report/parts.h"
#include "app/words/words.h"
#include "sim/measure/table.h"

namespace limberg {
namespace {

constexpr int kMany = 2;  // more than so many presses, refusals or acts taken back are told (as the window does)

std::string figure_words(double value, double limit, const std::string& unit) {
  return fmt::format(english("{}, at most {}"), fmt::format("{:.3g}", value) + (unit.empty() ? "" : " " + unit),
                     fmt::format("{:.3g}", limit));
}

void add_count(std::vector<Finding>& all, const char* key, const char* what, Maybe n, double most) {
  if (!n) return;
  all.push_back({std::string("count/") + key, what, fmt::format("{:.0f}", *n), "", n, most, *n > most});
}

/// What to do about it, as a lesson says it.
std::string advice_on(const ClassFinding& f) {
  const size_t slash = f.key.find('/');
  if (f.key.substr(0, slash) != "tolerance" || !f.median || !f.limit) return "";
  const Judgement j{f.key.substr(slash + 1), f.unit, *f.limit, *f.median, "", false};
  std::string said;
  for (const std::string& s : to_do_better(std::span(&j, 1), 1)) said = s;
  const size_t advice = said.rfind(": ");
  return advice == std::string::npos ? "" : capital(said.substr(advice + 2));
}

}  // namespace

double median_of(std::vector<double> v) {
  std::erase_if(v, [](double x) { return !std::isfinite(x); });
  if (v.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::sort(v.begin(), v.end());
  const size_t n = v.size();
  return n % 2 ? v[n / 2] : (v[n / 2 - 1] + v[n / 2]) / 2;
}

std::vector<Finding> findings_of(const ClassMember& m, const ClassWalk& w) {
  std::vector<Finding> all;
  const ReportData& d = m.result;
  for (const ResultTolerance& t : entries(d.lesson.tolerances)) {
    if (!t.value && t.why.find("shown by the program") != std::string::npos) continue;
    Finding f{"tolerance/" + t.name, words_of_tolerance(t.name), t.why, t.unit, t.value, t.limit, !t.met};
    // A cut that is missing is a fault of the cuts; a figure of stitches that nobody tied is told by the steps.
    const bool of_cuts =
        t.name == "corner_mm" || t.name == "angle_deg" || t.name == "limb_percent" || t.name == "pieces_wrong";
    if (!t.value && !of_cuts) f.judged = f.wrong = false;
    if (t.value && t.limit) f.words = figure_words(*t.value, *t.limit, t.unit);
    all.push_back(std::move(f));
  }
  for (const StepWalk& s : w.steps) {
    if (s.shown > 0 && s.shown == s.done) continue;
    const bool whole = s.done == s.planned;
    all.push_back(
        {"not done/" + s.name,
         fmt::format(english("Step \"{}\" not done"), s.name),
         s.sawn ? fmt::format(english("{} of {} acts; {:.0f} % of a line is sawn"), s.done, s.planned, 100 * *s.sawn)
                : fmt::format(english("{} of {} acts"), s.done, s.planned),
         "acts",
         double(s.done),
         {},
         !whole});
    if (s.done > s.shown)
      all.push_back({"off/" + s.name, fmt::format(english("Step \"{}\" otherwise than planned"), s.name), s.off, "",
                     s.share, 1.0, s.share > 1});
  }
  if (!w.steps.empty()) {
    add_count(all, "order", english("Acts out of order"), double(w.out_of_order), 0);
    add_count(all, "elsewhere", english("Acts elsewhere than planned"), double(w.elsewhere), 0);
  }
  Maybe missed;
  if (d.device.missed_presses) missed = double(*d.device.missed_presses + d.device.dropped_gestures.value_or(0));
  add_count(all, "missed", english("Presses that came to nothing, more than two"), missed, kMany);
  add_count(all, "refused", english("Acts that were refused"), exercise_of(d, "refused"), 0);
  const auto judged_undos = [](const Finding& f) { return f.key == "tolerance/undos"; };
  if (std::none_of(all.begin(), all.end(), judged_undos))
    add_count(all, "undos", english("Acts taken back, more than two"), exercise_of(d, "undos"), kMany);
  if (const Maybe n = d.metric("inverted_cells")) {
    const std::string words =
        fmt::format(english("{:.3g} mm3 in {:.0f} cells"), d.metric("inverted_mm3").value_or(0), *n);
    all.push_back({"count/inverted", english("Tissue inside out"), words, "cells", n, 0.0, *n > 0});
  }
  if (d.residual)
    all.push_back({"count/rest", english("Not at rest at the end"),
                   fmt::format(english("residual {:.2g}"), *d.residual), "", d.residual, kAtRest,
                   !(*d.residual <= kAtRest)});
  if (const Maybe most = d.metric("suture_force_peak_N"); most && !d.sutures().empty())
    all.push_back({"count/force", english("A stitch that ever pulled with more than 2.5 N"),
                   figure_words(*most, kSutureForce_N.warn, "N"), "N", most, kSutureForce_N.warn,
                   *most > kSutureForce_N.warn});
  if (m.also.whole && !*m.also.whole)
    all.push_back(
        {"count/ended", english("The session was cut short"), english("no end in the recording"), "", {}, {}, true});
  else if (m.also.whole)
    all.push_back({"count/ended", english("The session was cut short"), "", "", {}, {}, false});
  return all;
}

std::vector<ClassFinding> class_findings(std::span<const std::vector<Finding>> students,
                                         std::span<const Finding> expert) {
  std::vector<ClassFinding> all;
  std::map<std::string, size_t> place;
  std::map<std::string, std::vector<double>> values;
  for (const std::vector<Finding>& of_one : students)
    for (const Finding& f : of_one) {
      if (!f.judged) continue;
      const auto [at, is_new] = place.try_emplace(f.key, all.size());
      if (is_new) all.push_back({f.key, f.what, f.unit, "", 0, 0, {}, f.limit, {}, false});
      ClassFinding& c = all[at->second];
      ++c.judged, c.wrong += f.wrong;
      if (f.wrong && f.value) values[f.key].push_back(*f.value);
    }
  for (const Finding& f : expert)
    if (const auto at = place.find(f.key); at != place.end())
      all[at->second].expert = f.value, all[at->second].expert_wrong = f.wrong;
  std::erase_if(all, [](const ClassFinding& c) { return c.wrong == 0; });
  for (ClassFinding& c : all) {
    if (const auto v = values.find(c.key); v != values.end()) c.median = median_of(v->second);
    c.advice = advice_on(c);
  }
  std::stable_sort(all.begin(), all.end(), [](const ClassFinding& a, const ClassFinding& b) {
    return a.share() != b.share() ? a.share() > b.share() : a.wrong > b.wrong;
  });
  return all;
}

}  // namespace limberg
