#include "app/report/parts.h"

#include <algorithm>
#include <filesystem>

#include "app/report/html.h"

namespace limberg {

html::Light light_of_force(double force_N) {
  return force_N < kSutureForce_N.warn   ? html::Light::good
         : force_N <= kSutureForce_N.bad ? html::Light::warn
                                         : html::Light::bad;
}

std::string title_of(const ReportData& d) {
  const Words& w = d.w;
  if (d.lesson.all_met.value_or(false) && !said(d.lesson.title).empty()) return capital(w(said(d.lesson.title)));
  if (!d.acts_title.empty()) return d.acts_title;
  if (d.command == "design") return w("Flaps ranked for a defect");
  return !said(d.scene_title).empty() ? capital(w.said(said(d.scene_title)))
         : !said(d.scene).empty()     ? capital(said(d.scene))
         : d.command == "superpose"   ? w("Superposition")
         : d.command == "fit"         ? w("Fit of a mesh")
         : d.command == "bench"       ? w("Benchmark")
         : d.study.empty()            ? w("Operation")
                                      : w("Study: {}", d.study);
}

std::string capital(std::string s) {
  if (!s.empty() && s[0] >= 'a' && s[0] <= 'z') s[0] = char(s[0] - 'a' + 'A');
  return s;
}

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
  return name;
}

/// Names of figures of an exercise and of tolerances, spoken, for those who list texts; and how a session was driven.
[[maybe_unused]] constexpr const char* kSpoken[] = {english("lockstep"),
                                                    english("realtime"),
                                                    english("time (s)"),
                                                    english("path (mm)"),
                                                    english("movements"),
                                                    english("tracked (s)"),
                                                    english("pressed (s)"),
                                                    english("tracking gaps"),
                                                    english("tracking lost (s)"),
                                                    english("osteotomies"),
                                                    english("bone moves"),
                                                    english("cuts"),
                                                    english("hooks"),
                                                    english("hook moves"),
                                                    english("stitches"),
                                                    english("threads cut"),
                                                    english("undos"),
                                                    english("redos"),
                                                    english("refused"),
                                                    english("gaps open"),
                                                    english("peaks over 2.5 (N)"),
                                                    english("peaks over 5 (N)"),
                                                    english("design corner mean (mm)"),
                                                    english("design corner max (mm)"),
                                                    english("design angle max (°)"),
                                                    english("design limb max (%)"),
                                                    english("corner (mm)"),
                                                    english("angle (°)"),
                                                    english("limb (%)"),
                                                    english("gap (mm)"),
                                                    english("suture (N)"),
                                                    english("suture peak (N)"),
                                                    english("closure (N)"),
                                                    english("dog ear (mm)"),
                                                    english("wound gape (mm)"),
                                                    english("step off (mm)"),
                                                    english("landmark (mm)"),
                                                    english("waste (mm²)"),
                                                    english("pieces wrong"),
                                                    english("piece (mm)"),
                                                    english("piece (°)"),
                                                    english("sideways (mm)"),
                                                    english("forwards (mm)"),
                                                    english("upwards (mm)"),
                                                    english("stays (mm)"),
                                                    english("midline (mm)"),
                                                    english("osteotomy gap (mm)"),
                                                    english("osteotomy overlap (mm)"),
                                                    english("bone outside (mm)"),
                                                    english("cephalometry (mm)"),
                                                    english("cephalometry (°)")};

std::string name_in_words(const std::string& name, const Words& w) {
  if (w.language() == "en") return spoken(name);
  const Measure* m = find_measure(name);
  return m ? w.said(m->words) + (m->unit[0] ? std::string(", ") + m->unit : "") : w.said(spoken(name));
}

std::string joined(const std::vector<std::string>& words, const char* between) {
  std::string s;
  for (const std::string& w : words)
    if (!w.empty()) s += (s.empty() ? "" : between) + w;
  return s;
}

std::string picture_url(const std::string& dir, const std::string& name, int widest) {
  namespace fs = std::filesystem;
  const fs::path p(name);
  if (name.empty() || p.is_absolute() || name.find('\0') != std::string::npos) return {};
  for (const fs::path& part : p)
    if (part == "..") return {};
  return html::picture_data_url((fs::path(dir) / p).string(), widest);
}

std::vector<LaneOfReport> lanes_of(const ReportData& d) {
  return {{english("Device: wake-up late by"), "µs", d.device.wake_us, 1.0, 1},
          {english("Device: work per tick"), "µs", d.device.work_us, 1.0, 1},
          {english("Solver: one step"), "ms", d.solver.step_ms, 1000.0 / 60, 2},
          {english("Render: one frame"), "ms", d.render.frame_ms, 1000.0 / 30, 3},
          {english("Sample to snapshot"), "ms", d.latency_ms.sample_to_snapshot, {}, 4},
          {english("Sample to picture"), "ms", d.latency_ms.sample_to_frame, {}, 4}};
}

html::Markup chart_of(const ResultChart& c, const Words& w) {
  LineChart chart;
  chart.description = w.said(c.description);
  chart.x.title = w.said(c.x), chart.y.title = w.said(c.y);
  chart.x.log = c.x_log, chart.y.log = c.y_log;
  for (const auto& s : c.series) chart.series.push_back({w.said(s.name), s.x, s.y, s.markers});
  for (const ResultMark& m : c.x_marks) chart.x_marks.push_back({m.value, w.said(m.label)});
  for (const ResultMark& m : c.y_marks) chart.y_marks.push_back({m.value, w.said(m.label)});
  return html::titled(w.said(c.title), html::chart(svg(chart)));
}

namespace {

/// At most so many bytes of a text, and no part of a character.
std::string beginning(const std::string& text, size_t most) {
  size_t n = std::min(text.size(), most);
  while (n > 0 && n < text.size() && (static_cast<unsigned char>(text[n]) & 0xC0) == 0x80) --n;
  return text.substr(0, n);
}

}  // namespace

std::vector<ChartMark> stage_marks(const ReportData& d) {
  std::vector<ChartMark> marks;
  for (const ResultStage& stage : d.stages)
    if (stage.t_s) marks.push_back({*stage.t_s, beginning(d.w(stage.name), 24)});
  return marks;
}

html::Markup bars_of(const ReportData& d) {
  if (d.bars.empty()) return {};
  const Words& w = d.w;
  std::vector<html::Row> rows;
  for (const Bar& b : d.bars)
    rows.push_back({w.said(b.name), html::quantity(b.value, ""),
                    (b.larger_is_better ? "≥ " : "≤ ") + html::quantity(b.bar, ""),
                    b.pass ? html::bold(w("met"), html::Light::good) : html::bold(w("missed"), html::Light::bad),
                    w.said(b.source)});
  return html::table_of_words({w("What is asked"), w("Value"), w("Bar"), "", w("Where it comes from")}, rows);
}

}  // namespace limberg
