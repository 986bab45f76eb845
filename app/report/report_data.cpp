#include "app/report/report_data.h"

#include <algorithm>
#include <cmath>

#include "app/report/report_names.h"
#include "app/report/script_words.h"
#include "app/result/json_nesting.h"
#include "app/result/read_result.h"
#include "sim/base/error.h"
#include "sim/commands/words.h"

namespace limberg {

namespace {

using result_json::Json;
using result_json::member;
using result_json::number;
using result_json::read;
using result_json::words;

int line_of(const std::string& text, size_t byte) {
  return 1 + int(std::count(text.begin(), text.begin() + std::ptrdiff_t(std::min(byte, text.size())), '\n'));
}

Json parse(const std::string& text, const std::string& file) {
  if (json_nesting(text) > 64) throw InputError(file, 0, "nests deeper than 64 levels; expected the result of a run");
  Json j;
  try {
    j = Json::parse(text);
  } catch (const Json::parse_error& e) {
    throw InputError(file, line_of(text, e.byte ? e.byte - 1 : 0), "is not JSON; expected the result of a run");
  } catch (const Json::exception&) {
    throw InputError(file, 0, "holds a number that is out of range; expected the result of a run");
  }
  if (!j.is_object()) throw InputError(file, 1, "is JSON but no object; expected the result of a run");
  return j;
}

void read_study(const Json& j, ReportData& d) {
  read(member(j, "study"), d.study);
  read(member(j, "about"), d.about);
  read(member(j, "columns"), d.study_columns);
  read(member(j, "uncertainty"), d.uncertainty);
  if (const Json& rows = member(j, "rows"); rows.is_array())
    for (const Json& r : rows) {
      auto& row = d.study_rows.emplace_back();
      for (const std::string& c : d.study_columns) row.push_back(number(member(r, c.c_str())));
    }
}

/// "Excision, undermining and sutures", kind by kind.
std::string title_in(const Words& w, std::string title) {
  if (w.language() == "en" || title.empty()) return title;
  std::vector<std::string> kinds;
  title[0] = char(std::tolower(title[0]));
  for (size_t at = 0; at < title.size();) {
    const size_t comma = title.find(", ", at), last = title.find(" and ", at),
                 end = std::min({comma, last, title.size()});
    kinds.push_back(w(title.substr(at, end - at)));
    at = end + (end == title.size() ? 0 : end == comma ? 2 : 5);
    if (end == title.size()) break;
  }
  std::string all = kinds[0];
  for (size_t i = 1; i < kinds.size(); ++i)
    all = i + 1 < kinds.size() ? all + ", " + kinds[i] : w("{} and {}", all, kinds[i]);
  return all;
}

/// A stage without words of its own says what the script did since the stage before.
void tell_stages(ReportData& d) {
  const std::vector<Command> acts = acts_of(d.script);
  d.acts_title = title_in(d.w, title_of_acts(acts));
  // Sawn and moved are all bones alike: the last stage says which.
  const bool of_bones =
      std::any_of(acts.begin(), acts.end(), [](const Command& c) { return std::holds_alternative<HeadCommand>(c); });
  if (of_bones && !d.acts_title.empty() && !d.stages.empty() && !d.stages.back().name.empty())
    d.acts_title += ": " + std::string(d.w(d.stages.back().name));
  const auto words_of = stage_words(acts);
  for (size_t i = 0; i < std::min(d.stages.size(), words_of.size()); ++i)
    if (d.stages[i].caption.empty() && d.stages[i].name == words_of[i].first) d.stages[i].caption = words_of[i].second;
}

void read_story(const Json& j, ReportData& d) {
  ResultStory story;
  read(j, story);
  d.reproduce = story.reproduce, d.commands = story.commands;
  const auto column = [](const MaybeList<double>& v) { return v.value_or(std::vector<double>()); };
  d.series_t_s = column(story.series.t_s);
  d.series_residual = column(story.series.residual);
  d.series_distance_mm = column(story.series.distance_mm);
  d.series_closure_N = column(story.series.closure_N);
  d.series_suture_max_N = column(story.series.suture_max_N);
  if (const Json& stages = member(j, "stages"); stages.is_array())  // a text alone is a name
    for (const Json& s : stages) {
      read(s, d.stages.emplace_back());
      if (s.is_string()) d.stages.back().name = s.get<std::string>();
    }
  if (const Json& script = member(j, "script"); script.is_array())  // lines, or the acts themselves
    for (const Json& l : script) d.script.push_back(l.is_string() ? l.get<std::string>() : l.dump());
  tell_stages(d);
}

void read_charts(const Json& j, ReportData& d) {
  read(member(j, "charts"), d.charts);
  for (ResultChart& c : d.charts) {
    std::erase_if(c.series, [](const ResultChart::Series& s) { return s.x.size() != s.y.size(); });
    // A mark without a value is none.
    for (auto* marks : {&c.x_marks, &c.y_marks})
      std::erase_if(*marks, [](const ResultMark& m) { return !std::isfinite(m.value); });
  }
  read(member(j, "tables"), d.tables);
}

void read_balance(const Json& j, ReportData& d) {
  if (!j.is_object()) return;
  for (const auto& [name, value] : j.items()) {
    if (name == "relative")
      d.balance_relative = number(value);
    else if (value.is_array() && value.size() == 3)
      read(value, d.balance.emplace_back(name, std::vector<double>()).second);
  }
}

}  // namespace

ReportData read_report_data(const std::string& text, const std::string& file, const Words& words_of_page) {
  const Json j = parse(text, file);
  ReportData d;
  d.w = words_of_page;
  read(j, static_cast<ResultOrigin&>(d));
  if (const Json& program = member(j, "limberg"); program.is_string()) d.limberg.version = words(program);
  read(j, static_cast<ResultRun&>(d));
  if (d.solver.residual) d.residual = d.solver.residual;
  if (d.solver.distance_mm) d.distance_mm = d.solver.distance_mm;
  read(member(j, "lattice"), d.lattice_numbers);

  const Json& metrics = member(j, "metrics");
  read(metrics, d.metrics);
  read(metrics, d.patient);

  read(member(j, "pictures"), d.pictures);
  if (d.pictures.overview.empty()) d.pictures.overview = report_names::overview;
  if (d.pictures.tension.empty()) d.pictures.tension = report_names::tension;
  read(member(j, "gallery"), d.gallery);

  read_story(j, d);
  read_balance(member(j, "balance"), d);
  read(member(j, "convergence"), d.convergence);
  if (const Json& errors = member(j, "discretisation"); errors.is_object())
    for (const auto& [name, e] : errors.items()) read(e, d.errors[name]);
  if (d.command == "study") read_study(j, d);
  if (d.command == "study" || d.command == "bench") read(member(j, "bars"), d.bars);
  read(member(j, "verdict"), d.verdict);
  read_charts(j, d);

  const Json& exercise = member(j, "exercise");
  read(exercise, d.exercise);
  read(member(exercise, "design"), d.exercise, "design/");
  read(member(j, "lesson"), d.lesson);
  if (const Json& damage = member(j, "damage"); damage.is_object())
    for (const auto& [name, value] : damage.items())
      d.damage.emplace_back(name, value.is_structured() ? value.dump() : words(value));
  return d;
}

}  // namespace limberg
