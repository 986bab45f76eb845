#pragma once
// result.json as plain data: what is absent is absent here too. Read once, without trust; the sections of the report
// only see this.
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace limberg {

using Maybe = std::optional<double>;

struct ReportTimes {
  Maybe p50, p95, p99, p999, max;
  bool any() const { return p50 || p95 || p99 || p999 || max; }
};

struct ReportSuture {
  std::string id;
  Maybe force_N, gap_mm, tied_N, peak_N;
};

struct ReportTable {
  std::string title, about;
  std::vector<std::string> columns;
  std::vector<std::vector<std::string>> rows;
};

struct ReportTolerance {
  std::string name, unit;
  Maybe limit, value;
  bool met = false;
  std::string why;  // there is no value
};

struct ReportStage {
  std::string name, picture, caption;
  Maybe t_s, residual, sutures, pieces;
};

struct ReportConvergence {
  Maybe cell_mm, nodes, closure_force_N, suture_gap_max_mm, suture_force_max_N, dog_ear_mm, residual, solve_ms;
};

/// The lattice's share of a figure's error.
struct ReportError {
  Maybe value, error, order, extrapolated;
  bool asymptotic = false;
  std::string says;
};

/// Of a study.
struct ReportBar {
  std::string name, source;
  Maybe value, bar;
  bool larger_is_better = false, pass = false;
};
struct ReportChart {
  std::string title, description, x, y;
  struct Series {
    std::string name;
    std::vector<double> x, y;
    bool markers = false;
  };
  std::vector<Series> series;
  bool x_log = false, y_log = false;
  std::vector<std::pair<double, std::string>> x_marks,
      y_marks;  // lines at values worth comparing with, each with its label
};

struct ReportData {
  std::string version, commit, command, scene, scene_title, scene_note, mode, state_hash, reproduce, cpu;
  Maybe cores;
  std::optional<bool> ok;
  Maybe duration_s, memory_mb, residual, distance_mm, solve_ms, solver_steps, render_frames;
  Maybe device_ticks, late_ticks, events_lost;
  ReportTimes wake_us, work_us, step_ms, frame_ms, to_snapshot_ms, to_frame_ms;
  std::vector<std::string> parts;
  std::vector<std::pair<std::string, double>> lattice;
  std::map<std::string, double> metrics;  // every number in `metrics`
  std::vector<ReportSuture> sutures;
  std::vector<ReportStage> stages;
  std::string overview, tension;                                        // picture files, relative
  std::vector<std::pair<std::string, std::string>> gallery;             // picture, caption
  std::vector<double> series_t_s, series_residual, series_distance_mm;  // NaN where a value is missing
  std::vector<std::pair<std::string, std::vector<double>>> balance;     // name, N; "sum_N" and others
  Maybe balance_relative;
  std::vector<ReportConvergence> convergence;
  std::map<std::string, ReportError> errors;  // by the name of the metric
  std::vector<std::string> script;
  std::string study, about;
  std::vector<std::string> study_columns;
  std::vector<std::vector<Maybe>> study_rows;  // as the columns
  std::vector<ReportBar> bars;
  std::vector<ReportChart> charts;
  std::vector<ReportTable> tables;
  std::map<std::string, double> exercise;  // and "design/..."
  std::string lesson_title, lesson_goal;
  std::vector<ReportTolerance> tolerances;
  std::vector<std::string> hints;
  std::vector<std::vector<Maybe>> predicted;                          // charge, x, y, height, volume, deficit
  std::vector<std::pair<std::string, std::vector<Maybe>>> landmarks;  // name; displacement, along, across, up
  std::vector<double> series_closure_N, series_suture_max_N;
  std::vector<std::pair<std::string, std::string>> damage;  // of the recording: name, value

  /// Bone alone was operated on, with no lattice of skin.
  bool of_bones() const { return lattice.empty() && sutures.empty() && metrics.count("fragments") > 0; }

  Maybe metric(const std::string& name) const {
    const auto it = metrics.find(name);
    return it == metrics.end() ? Maybe() : Maybe(it->second);
  }
};

/// InputError (file, line) when the text is not JSON or not an object.
ReportData read_report_data(const std::string& json_text, const std::string& file);

}  // namespace limberg
