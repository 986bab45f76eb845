#include "app/report/compare.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>

#include "app/report/html.h"
#include "app/report/report_data.h"
#include "app/report/report_file.h"
#include "app/report/sections.h"
#include "sim/base/whole_file.h"
#include "sim/measure/table.h"

namespace limberg {

namespace {

namespace fs = std::filesystem;
using html::escape;
using html::number;
using html::quantity;

struct Side {
  const ReportData& d;
  const std::string& dir;
};

std::string cell(const Maybe& v, int digits = 4) { return "<td>" + quantity(v, "", digits) + "</td>"; }

std::string signed_number(double v, int digits) { return (v > 0 ? "+" : "") + number(v, digits); }

/// The difference of two figures as two cells: as it is, and in per cent of the first.
std::string difference(const Maybe& a, const Maybe& b, const std::string& mark = "") {
  if (!a || !b) return "<td>–</td><td>–</td>";
  const double by = *b - *a;
  const std::string per_cent = *a != 0 ? signed_number(100 * by / std::abs(*a), 3) + " %" : "–";
  return "<td class=\"" + mark + "\">" + (by == 0 ? std::string("same") : signed_number(by, 3)) + "</td><td>" +
         (by == 0 ? std::string() : per_cent) + "</td>";
}

/// Whether the lattices' errors can explain the difference; nothing when neither is known.
std::optional<bool> explained(const ReportData& a, const ReportData& b, const std::string& name, double by) {
  const auto error = [&](const ReportData& d) -> Maybe {
    const auto e = d.errors.find(name);
    return e == d.errors.end() ? Maybe() : e->second.error;
  };
  const Maybe ea = error(a), eb = error(b);
  if (!ea && !eb) return {};
  return std::abs(by) <= std::abs(ea.value_or(0)) + std::abs(eb.value_or(0));
}

std::string heading(const Side& a, const Side& b) {
  const auto named = [](const Side& s) {
    return escape(sections::title(s.d)) + " <span class=\"soft\">(" + escape(s.dir) + ")</span>";
  };
  std::string s = "<header>\n<h1>Two operations compared</h1>\n<p><b>A</b> " + named(a) + "</p>\n<p><b>B</b> " +
                  named(b) + "</p>\n</header>\n";
  std::vector<std::string> says;
  if (a.d.scene != b.d.scene) says.push_back("Different scenes: " + escape(a.d.scene) + " and " + escape(b.d.scene));
  if (a.d.version != b.d.version || a.d.commit != b.d.commit)
    says.push_back("Different versions: " + escape(a.d.version + " " + a.d.commit) + " and " +
                   escape(b.d.version + " " + b.d.commit));
  if (!a.d.state_hash.empty() && !b.d.state_hash.empty())
    says.push_back(a.d.state_hash == b.d.state_hash ? "The same state at the end, to the last bit"
                                                    : "Different states at the end");
  if (says.empty()) return s;
  s += "<div class=\"notice\">";
  for (const std::string& line : says) s += line + ". ";
  return s + "</div>\n";
}

/// "wound gape, mm", the name in result.json as its title; a figure that the table does not know keeps that name.
std::string named(const std::string& name) {
  const Measure* m = find_measure(name);
  if (!m) return "<code>" + escape(name) + "</code>";
  return "<span title=\"" + escape(name + ": " + m->definition) + "\">" + escape(m->words) +
         (m->unit[0] ? std::string(", ") + m->unit : "") + "</span>";
}

std::string figures(const ReportData& a, const ReportData& b) {
  std::set<std::string> names;
  for (const auto& [n, v] : a.metrics) names.insert(n);
  for (const auto& [n, v] : b.metrics) names.insert(n);
  std::string rows;
  bool any_error = false;
  for (const std::string& n : names) {
    const Maybe va = a.metric(n), vb = b.metric(n);
    std::string mark, note;
    if (va && vb)
      if (const auto by_lattice = explained(a, b, n, *vb - *va)) {
        any_error = true;
        mark = *by_lattice ? "" : "warn";
        note = *by_lattice ? "within" : "beyond";
      }
    rows += "<tr><td>" + named(n) + "</td>" + cell(va, 5) + cell(vb, 5) + difference(va, vb, mark) + "<td>" + note +
            "</td></tr>\n";
  }
  const std::pair<const char*, Maybe ReportData::*> own[] = {{"duration_s", &ReportData::duration_s},
                                                             {"residual", &ReportData::residual},
                                                             {"distance_mm", &ReportData::distance_mm},
                                                             {"memory_mb", &ReportData::memory_mb},
                                                             {"solve_ms", &ReportData::solve_ms}};
  for (const auto& [name, what] : own)
    if (a.*what || b.*what)
      rows += "<tr><td><code>" + std::string(name) + "</code></td>" + cell(a.*what, 5) + cell(b.*what, 5) +
              difference(a.*what, b.*what) + "<td></td></tr>\n";
  if (rows.empty()) return {};
  return "<section>\n<h2>Figures</h2>\n<p class=\"note\">" +
         std::string(any_error ? "Last column: whether the lattices' own errors, added, can explain the difference."
                               : "Neither result says how large its lattice's error is (<code>operate --cells</code> "
                                 "does), so nothing is said about which differences matter.") +
         "</p>\n<div class=\"wide\"><table>\n<thead><tr><th></th><th>A</th><th>B</th><th>B − A</th><th></th><th>" +
         (any_error ? "lattice error" : "") + "</th></tr></thead>\n<tbody>\n" + rows +
         "</tbody></table></div>\n</section>\n";
}

std::string sutures(const ReportData& a, const ReportData& b) {
  std::vector<int64_t> ids;
  for (const ReportData* d : {&a, &b})
    for (const ResultSuture& s : d->sutures)
      if (s.id && std::find(ids.begin(), ids.end(), *s.id) == ids.end()) ids.push_back(*s.id);
  if (ids.empty()) return {};
  const auto find = [](const ReportData& d, int64_t id) {
    for (const ResultSuture& s : d.sutures)
      if (s.id == id) return s;
    return ResultSuture{};
  };
  std::string rows;
  for (const int64_t id : ids) {
    const ResultSuture x = find(a, id), y = find(b, id);
    rows += "<tr><td>" + std::to_string(id) + "</td>" + cell(x.force_N, 3) + cell(y.force_N, 3) +
            difference(x.force_N, y.force_N) + cell(x.gap_mm, 3) + cell(y.gap_mm, 3) + "</tr>\n";
  }
  return "<section>\n<h2>Stitches</h2>\n<p class=\"note\">By the order of tying: they are the same stitches only where "
         "the scripts agree.</p>\n<div class=\"wide\"><table>\n"
         "<thead><tr><th></th><th>force A, N</th><th>force B, N</th><th>B − A</th><th></th><th>gap A, mm</th><th>gap "
         "B, mm</th></tr></thead>\n<tbody>\n" +
         rows + "</tbody></table></div>\n</section>\n";
}

std::string pair_of(const Side& a, const std::string& picture_a, const Side& b, const std::string& picture_b,
                    const std::string& name) {
  const auto half = [&](const Side& s, const std::string& picture, const char* letter) {
    const std::string url = sections::picture_url(s.dir, picture, 960);
    const std::string caption = "<b>" + std::string(letter) + "</b> " + escape(name);
    if (url.empty()) return "<figure><figcaption>" + caption + ": no picture</figcaption></figure>\n";
    return "<figure><img src=\"" + url + "\" alt=\"" + escape(name) + "\"/><figcaption>" + caption +
           "</figcaption></figure>\n";
  };
  return half(a, picture_a, "A") + half(b, picture_b, "B");
}

std::string pictures(const Side& a, const Side& b) {
  std::string s;
  std::vector<bool> used(b.d.stages.size(), false);
  for (const ResultStage& x : a.d.stages) {
    std::string other;
    for (size_t i = 0; i < b.d.stages.size() && other.empty(); ++i)
      if (!used[i] && b.d.stages[i].name == x.name) other = b.d.stages[i].picture, used[i] = true;
    s += pair_of(a, x.picture, b, other, x.name);
  }
  for (size_t i = 0; i < b.d.stages.size(); ++i)
    if (!used[i]) s += pair_of(a, "", b, b.d.stages[i].picture, b.d.stages[i].name);
  if (!a.d.tension.empty() || !b.d.tension.empty()) s += pair_of(a, a.d.tension, b, b.d.tension, "tension of the skin");
  if (s.empty() && (!a.d.overview.empty() || !b.d.overview.empty()))
    s = pair_of(a, a.d.overview, b, b.d.overview, "at the end");
  return s.empty() ? s : "<section>\n<h2>Pictures</h2>\n<div class=\"story pairs\">\n" + s + "</div>\n</section>\n";
}

std::string script(const ReportData& a, const ReportData& b) {
  if (a.script.empty() && b.script.empty()) return {};
  if (a.script == b.script)
    return "<section>\n<h2>Script</h2>\n<p>The same " + std::to_string(a.script.size()) + " lines.</p>\n</section>\n";
  std::string lines;
  for (const LineChange& c : line_changes(a.script, b.script)) {
    const std::string light = c.kind == '-' ? "bad" : c.kind == '+' ? "good" : "";
    const std::string text = std::string(1, c.kind) + " " + escape(c.line);
    lines += (light.empty() ? text : "<b class=\"" + light + "\">" + text + "</b>") + "\n";
  }
  return "<section>\n<h2>Script</h2>\n<p class=\"note\">− only in A, + only in B.</p>\n<pre>" + lines +
         "</pre>\n</section>\n";
}

std::string timing(const ReportData& a, const ReportData& b) {
  const std::pair<const char*, ResultTimes ReportData::*> lanes[] = {
      {"Device: wake-up late by, µs", &ReportData::wake_us},   {"Device: work per tick, µs", &ReportData::work_us},
      {"Solver: one step, ms", &ReportData::step_ms},          {"Render: one frame, ms", &ReportData::frame_ms},
      {"Sample to snapshot, ms", &ReportData::to_snapshot_ms}, {"Sample to picture, ms", &ReportData::to_frame_ms}};
  std::string rows;
  for (const auto& [name, what] : lanes) {
    const ResultTimes &x = a.*what, &y = b.*what;
    if (x.any() || y.any())
      rows += "<tr><td>" + std::string(name) + "</td>" + cell(x.p50, 3) + cell(y.p50, 3) + difference(x.p50, y.p50) +
              cell(x.p99, 3) + cell(y.p99, 3) + difference(x.p99, y.p99) + "</tr>\n";
  }
  if (rows.empty()) return {};
  return "<section>\n<h2>Lanes in time</h2>\n<div class=\"wide\"><table>\n<thead><tr><th></th><th>median "
         "A</th><th>B</th><th>B − A</th><th></th><th>p99 A</th><th>B</th><th>B − "
         "A</th><th></th></tr></thead>\n<tbody>\n" +
         rows + "</tbody></table></div>\n</section>\n";
}

std::string page(const Side& a, const Side& b) {
  return whole_page("Comparison", heading(a, b) + "<main>\n" + figures(a.d, b.d) + sutures(a.d, b.d) + pictures(a, b) +
                                      timing(a.d, b.d) + script(a.d, b.d) + "</main>\n" + sections::footer(b.d));
}

}  // namespace

std::vector<LineChange> line_changes(const std::vector<std::string>& a, const std::vector<std::string>& b) {
  constexpr size_t most = 4000;
  std::vector<LineChange> out;
  const size_t n = a.size(), m = b.size();
  if (n > most || m > most) {
    for (const std::string& l : a) out.push_back({'-', l});
    for (const std::string& l : b) out.push_back({'+', l});
    return out;
  }
  // common[i][j]: length of the longest common subsequence of a[i..] and b[j..].
  std::vector<uint16_t> common((n + 1) * (m + 1), 0);
  const auto at = [&](size_t i, size_t j) -> uint16_t& { return common[i * (m + 1) + j]; };
  for (size_t i = n; i-- > 0;)
    for (size_t j = m; j-- > 0;)
      at(i, j) = a[i] == b[j] ? uint16_t(at(i + 1, j + 1) + 1) : std::max(at(i + 1, j), at(i, j + 1));
  size_t i = 0, j = 0;
  while (i < n || j < m) {
    if (i < n && j < m && a[i] == b[j])
      out.push_back({' ', a[i]}), ++i, ++j;
    else if (i < n && (j == m || at(i + 1, j) >= at(i, j + 1)))
      out.push_back({'-', a[i++]});
    else
      out.push_back({'+', b[j++]});
  }
  return out;
}

std::string comparison_html(const std::string& json_a, const std::string& dir_a, const std::string& json_b,
                            const std::string& dir_b) {
  const ReportData a = read_report_data(json_a, result_file(dir_a)), b = read_report_data(json_b, result_file(dir_b));
  return page({a, dir_a}, {b, dir_b});
}

std::string write_comparison(const std::string& dir_a, const std::string& dir_b, const std::string& file) {
  const std::string a = read_result_file(dir_a), b = read_result_file(dir_b);
  write_whole_file(file, comparison_html(a, dir_a, b, dir_b));
  return file;
}

}  // namespace limberg
