#include "app/report/compare.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>

#include "app/report/html.h"
#include "app/report/page.h"
#include "app/report/report_file.h"
#include "app/report/sections.h"
#include "app/report/viewer.h"
#include "app/result/verdict_words.h"
#include "sim/base/whole_file.h"

namespace limberg {

namespace {

using html::Light;
using html::Markup;
using html::number;
using html::quantity;
using Sides = std::pair<ReportSource, ReportSource>;

std::string signed_number(double v, int digits) { return (v > 0 ? "+" : "") + number(v, digits); }

/// Both values, their difference, and the difference in per cent of the first.
void add_pair(const Words& w, html::Row& row, const Maybe& a, const Maybe& b, int digits, Light light = Light::none) {
  row.push_back(quantity(a, "", digits)), row.push_back(quantity(b, "", digits));
  if (!a || !b) {
    row.push_back("–"), row.push_back("–");
    return;
  }
  const double by = *b - *a;
  row.push_back({by == 0 ? w("same") : signed_number(by, 3), light});
  row.push_back(by == 0 ? "" : *a != 0 ? signed_number(100 * by / std::abs(*a), 3) + " %" : "–");
}

/// Whether the lattices' errors can explain the difference; nothing when neither is known.
std::optional<bool> within_errors(const ReportData& a, const ReportData& b, const std::string& name, double by) {
  const auto error = [&](const ReportData& d) -> Maybe {
    const auto e = d.errors.find(name);
    return e == d.errors.end() ? Maybe() : e->second.error;
  };
  const Maybe ea = error(a), eb = error(b);
  if (!ea && !eb) return {};
  return std::abs(by) <= std::abs(ea.value_or(0)) + std::abs(eb.value_or(0));
}

Markup operations(const ReportSource& a, const ReportSource& b) {
  const auto named = [](const ReportSource& s) { return title_of(s.d) + " " + html::soft("(" + s.dir + ")"); };
  return html::paragraph(html::bold("A") + " " + named(a)) + html::paragraph(html::bold("B") + " " + named(b));
}

Markup differences(const ReportData& a, const ReportData& b) {
  const auto version = [](const ReportData& d) { return said(d.limberg.version) + " " + said(d.limberg.commit); };
  std::string says;
  const Words& w = a.w;
  if (a.scene != b.scene) says += w("Different scenes: {} and {}.", said(a.scene), said(b.scene)) + " ";
  if (version(a) != version(b)) says += w("Different versions: {} and {}.", version(a), version(b)) + " ";
  if (a.state_hash && b.state_hash)
    says += w(a.state_hash == b.state_hash ? english("The same state at the end, to the last bit.")
                                           : english("Different states at the end."));
  return says.empty() ? Markup() : html::notice(says);
}

/// "wound gape, mm", the name in result.json as its title.
Markup name_of_figure(const std::string& name, const Words& w) {
  const Measure* m = find_measure(name);
  if (!m) return html::explained(w.said(spoken(name)), name);
  return html::explained(w.said(m->words) + (m->unit[0] ? std::string(", ") + m->unit : ""),
                         name + ": " + w.said(m->definition));
}

Markup figures_of(const Sides& sides) {
  const ReportData &a = sides.first.d, &b = sides.second.d;
  const Words& w = a.w;
  std::set<std::string> names;
  for (const auto& [n, v] : a.metrics) names.insert(n);
  for (const auto& [n, v] : b.metrics) names.insert(n);
  std::vector<html::Row> rows;
  bool any_error = false;
  for (const std::string& n : names) {
    const Maybe va = a.metric(n), vb = b.metric(n);
    std::optional<bool> within;
    if (va && vb) within = within_errors(a, b, n, *vb - *va);
    any_error |= within.has_value();
    html::Row row{name_of_figure(n, w)};
    add_pair(w, row, va, vb, 5, within && !*within ? Light::warn : Light::none);
    row.push_back(!within ? "" : *within ? w("within") : w("beyond"));
    rows.push_back(row);
  }
  const std::pair<const char*, Maybe ReportData::*> own[] = {
      {english("duration, s"), &ReportData::duration_s},
      {english("relative residual"), &ReportData::residual},
      {english("distance to equilibrium, mm"), &ReportData::distance_mm},
      {english("memory, MB"), &ReportData::memory_mb},
      {english("time of the solver, ms"), &ReportData::solve_ms}};
  for (const auto& [name, what] : own)
    if (a.*what || b.*what) {
      html::Row row{w(name)};
      add_pair(w, row, a.*what, b.*what, 5);
      row.push_back("");
      rows.push_back(row);
    }
  if (rows.empty()) return {};
  const char* about = w(
      any_error ? english("Last column: whether the lattices' own errors, added, can explain the difference.")
                : english("Neither result says how large its lattice's error is (operate --cells does), so nothing is "
                          "said about which differences matter."));
  return html::folded(
      w("All figures"),
      html::note(about) + html::table({"", "A", "B", "B − A", "", any_error ? w("lattice error") : ""}, rows));
}

Markup stitches(const Sides& sides) {
  const ReportData &a = sides.first.d, &b = sides.second.d;
  const Words& w = a.w;
  std::vector<int64_t> ids;
  for (const ReportData* d : {&a, &b})
    for (const ResultSuture& s : d->sutures())
      if (s.id && std::find(ids.begin(), ids.end(), *s.id) == ids.end()) ids.push_back(*s.id);
  if (ids.empty()) return {};
  const auto find = [](const ReportData& d, int64_t id) {
    for (const ResultSuture& s : d.sutures())
      if (s.id == id) return s;
    return ResultSuture{};
  };
  std::vector<html::Row> rows;
  for (const int64_t id : ids) {
    const ResultSuture x = find(a, id), y = find(b, id);
    html::Row row{std::to_string(id)};
    add_pair(w, row, x.force_N, y.force_N, 3);
    row.push_back(quantity(x.gap_mm, "")), row.push_back(quantity(y.gap_mm, ""));
    rows.push_back(row);
  }
  return html::folded(
      w("Stitches"),
      html::note(w("By the order of tying: they are the same stitches only where the scripts agree.")) +
          html::table({"", w("force A, N"), w("force B, N"), "B − A", "", w("gap A, mm"), w("gap B, mm")}, rows));
}

Markup pair_of(const Sides& sides, const std::string& picture_a, const std::string& picture_b,
               const std::string& name_a, const std::string& name_b) {
  const auto half = [&](const ReportSource& s, const std::string& picture, const std::string& name,
                        const char* letter) {
    if (name.empty()) return html::figure("", "", html::bold(letter) + " -");
    const std::string url = picture_url(s.dir, picture, 960);
    return html::figure(url, name, html::bold(letter) + " " + (url.empty() ? s.d.w("{}: no picture", name) : name));
  };
  return half(sides.first, picture_a, name_a, "A") + half(sides.second, picture_b, name_b, "B");
}

Markup pictures(const Sides& sides) {
  const ReportData &a = sides.first.d, &b = sides.second.d;
  const Words& w = a.w;
  // Stages of one name stand side by side; then those of one side alone, the next of either together: no half of the
  // page is empty.
  Markup m;
  std::vector<bool> used(b.stages.size(), false);
  std::vector<const ResultStage*> of_a, of_b;
  for (const ResultStage& x : a.stages) {
    std::optional<size_t> same;
    for (size_t i = 0; i < b.stages.size() && !same; ++i)
      if (!used[i] && b.stages[i].name == x.name) same = i;
    if (!same) {
      of_a.push_back(&x);
      continue;
    }
    used[*same] = true;
    m += pair_of(sides, x.picture, b.stages[*same].picture, w(x.name), w(x.name));
  }
  for (size_t i = 0; i < b.stages.size(); ++i)
    if (!used[i]) of_b.push_back(&b.stages[i]);
  for (size_t i = 0; i < std::max(of_a.size(), of_b.size()); ++i) {
    const ResultStage none;
    const ResultStage &x = i < of_a.size() ? *of_a[i] : none, &y = i < of_b.size() ? *of_b[i] : none;
    m += pair_of(sides, x.picture, y.picture, w(x.name), w(y.name));
  }
  const bool of_skin = !picture_url(sides.first.dir, a.pictures.tension, 960).empty() ||
                       !picture_url(sides.second.dir, b.pictures.tension, 960).empty();
  if (of_skin)
    m += pair_of(sides, a.pictures.tension, b.pictures.tension, w("tension of the skin"), w("tension of the skin"));
  if (m.empty() && (!a.pictures.overview.empty() || !b.pictures.overview.empty()))
    m = pair_of(sides, a.pictures.overview, b.pictures.overview, w("at the end"), w("at the end"));
  return m.empty() ? m : html::section(w("Pictures"), html::pairs(m));
}

/// A figure that is told in a sentence: its name in result.json, and the sentence for a value.
struct Told {
  const char *figure, *words;
  const char* unit;
};
constexpr Told kToldOfSkin[] = {
    {"closure_force_N", english("The stitches together pull with {}"), "N"},
    {"wound_gape_mm", english("The wound gapes by {}"), "mm"},
    {"dog_ear_mm", english("The skin stands up by at most {}"), "mm"},
    {"stress_p95_kPa", english("All skin but a twentieth is pulled by less than {}"), "kPa"},
    {"waste_mm2", english("Of healthy skin was cut away {}"), "mm²"},
    {"elongation", english("The line was lengthened by a factor of {}"), ""}};
constexpr Told kToldOfBones[] = {
    {"fragment_moved_max_mm", english("The farthest piece of bone was carried by {}"), "mm"},
    {"face_moved_max_mm", english("The face follows by at most {}"), "mm"},
    {"fragments", english("Pieces of bone: {}"), ""}};

/// "The wound gapes by 1.2 mm in A and by 2.2 mm in B, 83 % more." Of what is the same to 0.5 %: "... in both."
std::string sentence_on(const Told& told, const Sides& sides) {
  const ReportData &a = sides.first.d, &b = sides.second.d;
  const Maybe va = a.metric(told.figure), vb = b.metric(told.figure);
  if (!va || !vb) return {};
  const double by = *vb - *va;
  const std::string x = quantity(va, told.unit), y = quantity(vb, told.unit);
  const Words& w = a.w;
  const bool same = x == y || std::abs(by) <= 0.005 * std::abs(*va);
  // The sentence is a format by itself in either language.
  const std::string values = same ? w("{} in both", x) : w("{} in A and {} in B", x, y);
  std::string s = fmt::vformat(w(told.words), fmt::make_format_args(values));
  if (same) return s + ".";
  if (const double share = std::abs(by / *va); *va != 0 && share < 10)
    s += ", " + (by > 0 ? w("{} % more", number(100 * share, 2)) : w("{} % less", number(100 * share, 2)));
  if (const auto within = within_errors(a, b, told.figure, by))
    s += w(*within ? english("; the errors of the lattices could explain it")
                   : english(", beyond what the errors of the lattices explain"));
  return s + ".";
}

/// "In A: excision and sutures, 27 stitches, 34 acts in 54.8 s; in B: ..."
std::string sentence_on_acts(const Sides& sides) {
  const auto done = [](const ReportData& d) {
    const size_t stitches = d.sutures().size();
    std::string s = d.acts_title.empty() ? title_of(d) : d.acts_title;
    if (stitches > 0) s += ", " + d.w.counted(int64_t(stitches), "{} stitch", "{} stitches", stitches);
    if (d.commands) s += ", " + d.w.counted(*d.commands, "{} act", "{} acts", *d.commands);
    if (d.duration_s) s += " " + d.w("in {}", quantity(d.duration_s, "s"));
    return s;
  };
  const std::string a = done(sides.first.d), b = done(sides.second.d);
  const Words& w = sides.first.d.w;
  return a == b ? w("Both: {}.", a) : "A: " + a + ". B: " + b + ".";
}

/// What the verdicts found.
std::string sentence_on_verdicts(const Sides& sides) {
  const auto found = [](const ReportData& d) {
    std::vector<std::string> bad;
    for (const ResultVerdict& v : d.verdict)
      if (v.light == light_names::bad) bad.push_back(d.w.said(v.what));
    if (d.interrupted.value_or(false)) bad.insert(bad.begin(), d.w("it was interrupted"));
    return bad.empty() ? std::string(d.w("nothing is wrong")) : d.w("wrong is: {}", joined(bad, ", "));
  };
  if (sides.first.d.verdict.empty() || sides.second.d.verdict.empty()) return {};
  const std::string a = found(sides.first.d), b = found(sides.second.d);
  const Words& w = sides.first.d.w;
  return a == b ? w("In both {}.", a) : w("In A {}; in B {}.", a, b);
}

/// At most six sentences.
Markup in_words(const Sides& sides) {
  constexpr size_t kSentences = 6;
  std::vector<Markup> said;
  const auto say = [&](const std::string& s) {
    if (!s.empty() && said.size() < kSentences) said.push_back(s);
  };
  say(sentence_on_acts(sides)), say(sentence_on_verdicts(sides));
  for (const Told& t : kToldOfBones) say(sentence_on(t, sides));
  for (const Told& t : kToldOfSkin) say(sentence_on(t, sides));
  return html::section(sides.first.d.w("What differs"), html::list(said));
}

Markup lanes(const Sides& sides) {
  const std::vector<LaneOfReport> a = lanes_of(sides.first.d), b = lanes_of(sides.second.d);
  const Words& w = sides.first.d.w;
  std::vector<html::Row> rows;
  for (size_t i = 0; i < a.size(); ++i) {
    const ResultTimes &x = a[i].t, &y = b[i].t;
    if (!x.any() && !y.any()) continue;
    html::Row row{w(a[i].name) + std::string(", ") + a[i].unit};
    add_pair(w, row, x.p50, y.p50, 3), add_pair(w, row, x.p99, y.p99, 3);
    rows.push_back(row);
  }
  if (rows.empty()) return {};
  return html::folded(w("Lanes in time"),
                      html::table({"", w("median A"), "B", "B − A", "", "p99 A", "B", "B − A", ""}, rows));
}

Markup scripts(const Sides& sides) {
  const std::vector<std::string>&a = sides.first.d.script, &b = sides.second.d.script;
  if (a.empty() && b.empty()) return {};
  const Words& w = sides.first.d.w;
  if (a == b) return html::folded(w("Script"), html::paragraph(w("The same {} lines.", a.size())));
  Markup text;
  for (const LineChange& c : line_changes(a, b)) {
    const std::string line = std::string(1, c.kind) + " " + c.line;
    text += (c.kind == '-'   ? html::bold(line, Light::bad)
             : c.kind == '+' ? html::bold(line, Light::good)
                             : Markup(line)) +
            "\n";
  }
  return html::folded(w("Script"), html::note(w("− only in A, + only in B.")) + html::lines(text));
}

/// What is folded below words and pictures, in its order.
constexpr Markup (*kCompared[])(const Sides&) = {figures_of, stitches, lanes, scripts};

std::string page_of(const Sides& sides) {
  const auto named = [](const ReportSource& s) {
    const std::filesystem::path dir = std::filesystem::path(s.dir) / ".";
    return ViewedOperation{title_of(s.d) + " (" + dir.parent_path().filename().string() + ")", s.dir};
  };
  const Viewer turned = viewer({named(sides.first), named(sides.second)}, sides.first.d.w);
  const Words& w = sides.first.d.w;
  Markup all = in_words(sides) + pictures(sides) + turned.section;
  for (const auto& section : kCompared) all += section(sides);
  return text_of({w("Comparison"), w("Two operations compared"), operations(sides.first, sides.second),
                  differences(sides.first.d, sides.second.d), all, sections::footer(sides.second), turned.nonce, w});
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
                            const std::string& dir_b, const Words& w) {
  const ReportData a = read_report_data(json_a, result_file(dir_a), w),
                   b = read_report_data(json_b, result_file(dir_b), w);
  return page_of({{a, dir_a}, {b, dir_b}});
}

std::string write_comparison(const std::string& dir_a, const std::string& dir_b, const std::string& file,
                             const Words& w) {
  const std::string a = read_result_file(dir_a), b = read_result_file(dir_b);
  write_whole_file(file, comparison_html(a, dir_a, b, dir_b, w));
  return file;
}

}  // namespace limberg
