#pragma once
// What several sections of a report share: words, limits, pictures of the result's folder, charts.
#include <string>
#include <vector>

#include "app/report/elements.h"
#include "app/report/report_data.h"
#include "app/report/svg_chart.h"
#include "app/words/words.h"
#include "sim/measure/table.h"

namespace limberg {

/// What a page is made of: a result, and the folder where its pictures lie.
struct ReportSource {
  const ReportData& d;
  const std::string& dir;
};

inline constexpr double kAtRest = 1e-4;  // residual below which the tissue counts as at rest

html::Light light_of_force(double force_N);

/// What a result is of, for the title of its page: the lesson that was met, else what was done, else the scene.
std::string title_of(const ReportData& d);
/// "Rhomboid" of "rhomboid".
std::string capital(std::string words);
/// A name of a figure in words: its unit in brackets, a point between digits.
std::string spoken(std::string name);
/// The same in the words of a page: of a tolerance of a lesson and of a measure those that it has, else as above.
std::string name_in_words(const std::string& name, const Words& words);
/// What there is of them, with `between` between two.
std::string joined(const std::vector<std::string>& words, const char* between);

/// A picture of a result as a data URL, made smaller to so many pixels; a name that leads out of the folder gives
/// nothing.
std::string picture_url(const std::string& dir, const std::string& name, int widest = 1600);

/// A lane's times: what they are of, their unit in the result, what their lane may take.
struct LaneOfReport {
  const char *name, *unit;
  const ResultTimes& t;
  Maybe budget_ms;
  int colour;  // of a chart
};
std::vector<LaneOfReport> lanes_of(const ReportData& d);

/// A chart that a command left, with its title.
html::Markup chart_of(const ResultChart& chart, const Words& words);
/// The stages of the operation on an axis of time.
std::vector<ChartMark> stage_marks(const ReportData& d);
/// What was asked of a study or a bench, and whether it was met.
html::Markup bars_of(const ReportData& d);

}  // namespace limberg
