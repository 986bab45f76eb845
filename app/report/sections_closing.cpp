// How the wound was closed and what an exercise came to.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "app/report/html.h"
#include "app/report/report_names.h"
#include "app/report/sections.h"
#include "app/report/svg_chart.h"

namespace limberg::sections {

using html::escape;
using html::number;
using html::quantity;

namespace {

std::string table(const std::vector<std::string>& head, const std::vector<std::vector<std::string>>& rows) {
  std::string s = "<div class=\"wide\"><table>\n<thead><tr>";
  for (const std::string& h : head) s += "<th>" + h + "</th>";
  s += "</tr></thead>\n<tbody>\n";
  for (const auto& r : rows) {
    s += "<tr>";
    for (const std::string& c : r) s += "<td>" + c + "</td>";
    s += "</tr>\n";
  }
  return s + "</tbody></table></div>\n";
}

// A map that the run has left, as a picture that cannot run anything.
std::string map(const std::string& dir, const char* name, const std::string& words) {
  std::ifstream in(std::filesystem::path(dir) / name, std::ios::binary);
  const std::string svg((std::istreambuf_iterator<char>(in)), {});
  if (!svg.starts_with("<svg") || svg.size() > (4u << 20)) return {};
  return "<figure class=\"onchart\"><img src=\"data:image/svg+xml;base64," + html::base64(svg) + "\" alt=\"" + words +
         "\"/></figure>\n";
}

/// A name of a figure in words: its unit in brackets, a point between digits.
std::string spoken(std::string name) {
  for (const auto& [ending, unit] : {std::pair<std::string, const char*>{"_deg", "°"},
                                     {"_mm", "mm"},
                                     {"_percent", "%"},
                                     {"_mm2", "mm²"},
                                     {"_s", "s"},
                                     {"_N", "N"},
                                     {"_mN", "mN"},
                                     {"_kPa", "kPa"}})
    if (name.ends_with(ending)) {
      name.resize(name.size() - ending.size());
      name += "_(" + std::string(unit) + ")";
      break;
    }
  for (size_t i = 1; i + 1 < name.size(); ++i)
    if (name[i] == '_' && name[i - 1] >= '0' && name[i - 1] <= '9' && name[i + 1] >= '0' && name[i + 1] <= '9')
      name[i] = '.';
  std::replace(name.begin(), name.end(), '_', ' ');
  std::replace(name.begin(), name.end(), '/', ' ');
  return escape(name);
}

}  // namespace

std::string exercise(const ReportData& d) {
  std::string s;
  if (!d.lesson_title.empty()) {
    s += "<h2>Lesson: " + escape(d.lesson_title) + "</h2>\n<p>" + escape(d.lesson_goal) + "</p>\n";
    std::vector<std::vector<std::string>> rows;
    for (const ResultTolerance& t : d.tolerances)
      rows.push_back({spoken(t.name), quantity(t.value, t.unit), "≤ " + quantity(t.limit, t.unit),
                      t.value         ? std::string("<b class=\"") + (t.met ? "good\">met" : "bad\">missed") + "</b>"
                      : t.why.empty() ? "not measured"
                                      : "not measured: " + escape(t.why)});
    s += table({"Tolerance", "Value", "Limit", ""}, rows);
    if (!d.hints.empty() &&
        std::any_of(d.tolerances.begin(), d.tolerances.end(), [](const auto& t) { return !t.met; })) {
      s += "<p>Hints:</p>\n<ul>\n";
      for (const std::string& h : d.hints) s += "<li>" + escape(h) + "</li>\n";
      s += "</ul>\n";
    }
  }
  if (!d.exercise.empty()) {
    if (s.empty()) s += "<h2>The exercise in figures</h2>\n";
    std::vector<std::vector<std::string>> rows;
    for (const auto& [name, value] : d.exercise) rows.push_back({spoken(name), number(value, 4)});
    s += table({"Figure", "Value"}, rows) +
         "<p class=\"note\">No grade: no published scale turns these figures into one. The script below is the "
         "evidence.</p>\n";
  }
  return s.empty() ? s : "<section>\n" + s + "</section>\n";
}

std::string closing(const ReportData& d, const std::string& dir) {
  std::string s;
  if (d.series_closure_N.size() > 1 && d.series_t_s.size() >= d.series_closure_N.size() &&
      *std::max_element(d.series_closure_N.begin(), d.series_closure_N.end(),
                        [](double a, double b) { return !(a >= b); }) > 0) {
    LineChart chart;
    chart.description = "Sum of the stitches' forces and the largest of them over time";
    chart.x = {"time of the recording, s", false, {}, {}};
    chart.y = {"N", false, {}, {}};
    std::vector<double> t = d.series_t_s;
    t.resize(d.series_closure_N.size());
    chart.series.push_back(thinned({"sum of all stitches", t, d.series_closure_N, false}, 600));
    if (d.series_suture_max_N.size() == t.size())
      chart.series.push_back(thinned({"largest stitch", t, d.series_suture_max_N, false}, 600));
    for (const ResultStage& stage : d.stages)
      if (stage.t_s) chart.x_marks.push_back({*stage.t_s, stage.name.substr(0, 24)});
    s += "<h3>Closure force over the operation</h3>\n<figure class=\"wide\">" + svg(chart) + "</figure>\n";
  }
  if (d.command != "study")
    for (const ResultChart& c : d.charts) s += chart_figure(c);
  if (d.command == "bench") s += bars(d);
  for (const ResultTable& t : d.tables) {
    s += "<h3>" + escape(t.title) + "</h3>\n" + (t.about.empty() ? "" : "<p>" + escape(t.about) + "</p>\n");
    std::vector<std::string> head;
    for (const std::string& c : t.columns) head.push_back(escape(c));
    std::vector<std::vector<std::string>> rows = t.rows;
    for (auto& r : rows)
      for (std::string& c : r) c = escape(c);
    s += table(head, rows);
  }
  if (!d.predicted.empty()) {
    std::vector<std::vector<std::string>> rows;
    for (const ResultPoint& p : d.predicted)
      rows.push_back({"(" + (p.x_mm ? number(*p.x_mm) : "–") + ", " + (p.y_mm ? number(*p.y_mm) : "–") + ")",
                      quantity(p.charge_deg, "°"), quantity(p.deficit_deg, "°"), quantity(p.height_mm, "mm"),
                      quantity(p.volume_mm3, "mm³")});
    s += "<h3>What the plan foretold</h3>\n<p>At each point where tissue angles of sum S are sewn together, 360° − S "
         "is foretold: above nothing a cone that stands "
         "up, below it a saddle and tension. Beside it the deficit that is there now, stretch included, and what "
         "stands up.</p>\n" +
         table({"Place on the chart, mm", "foretold", "deficit now", "height", "volume"}, rows);
  }
  if (!d.landmarks.empty()) {
    std::vector<std::vector<std::string>> rows;
    for (const ResultLandmark& l : d.landmarks)
      rows.push_back({escape(l.name), quantity(l.displacement_mm, "mm", 2), quantity(l.along_mm, "mm", 2),
                      quantity(l.across_mm, "mm", 2), quantity(l.up_mm, "mm", 2)});
    s += "<h3>Landmarks</h3>\n" + table({"Landmark", "displaced by", "along the tension lines", "across", "up"}, rows);
  }
  if (const Maybe v = d.metric("undermined_mm2"); v && *v > 0) {
    s += "<h3>Perfusion risk</h3>\n<p>" + quantity(v, "mm²") + " of skin are undermined; " +
         quantity(d.metric("perfusion_below_40_mm2"), "mm²") +
         " of it lie more than 20\u202fmm of skin away from skin that is still attached, where perfusion of random "
         "flaps in pigs was 40\u202f% and less "
         "(Memarzadeh 2016: 40, 20 and about 0\u202f% at 20, 25 and 30\u202fmm). Lowest index " +
         quantity(d.metric("perfusion_least"), "", 2) + ", farthest " +
         quantity(d.metric("perfusion_farthest_mm"), "mm") +
         (d.metric("perfusion_severed_mm2").value_or(0) > 0.5
              ? ", without any pedicle " + quantity(d.metric("perfusion_severed_mm2"), "mm²")
              : "") +
         ". It orders places and designs; it foretells no necrosis: the source gives no spread, and facial skin is "
         "perfused better than a pig's flank.</p>\n";
  }
  s += map(dir, report_names::ranking, "The best designs as they would lie on the skin, and what each costs");
  s += map(dir, report_names::perfusion, "Map of the perfusion index on the chart") +
       map(dir, report_names::stress, "Map of the skin's largest principal stress on the chart");
  return s.empty() ? s
                   : "<section>\n<h2>" +
                         std::string(d.command == "superpose" || d.command == "bench" || d.command == "fit"
                                         ? "What it came to"
                                     : d.of_bones() ? "Bones and face"
                                                    : "The closure") +
                         "</h2>\n" + s + "</section>\n";
}

}  // namespace limberg::sections
