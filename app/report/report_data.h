#pragma once
// result.json as plain data: what is absent is absent here too. Read once, without trust; the sections of the report
// only see this.
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/result/schema.h"

namespace limberg {

struct ReportData {
  std::string version, commit, command, scene, scene_title, scene_note, mode, state_hash, reproduce, cpu;
  Maybe cores;
  std::optional<bool> ok;
  Maybe duration_s, memory_mb, residual, distance_mm, solve_ms, solver_steps, render_frames;
  Maybe device_ticks, late_ticks, events_lost;
  ResultTimes wake_us, work_us, step_ms, frame_ms, to_snapshot_ms, to_frame_ms;
  std::vector<std::string> parts;
  std::vector<std::pair<std::string, double>> lattice;
  std::map<std::string, double> metrics;  // every number in `metrics`
  std::vector<ResultSuture> sutures;
  std::vector<ResultStage> stages;
  std::string overview, tension;  // picture files, relative
  std::vector<ResultPicture> gallery;
  std::vector<double> series_t_s, series_residual, series_distance_mm;  // NaN where a value is missing
  std::vector<std::pair<std::string, std::vector<double>>> balance;     // name, N; "sum_N" and others
  Maybe balance_relative;
  std::vector<ResultConvergence> convergence;
  std::map<std::string, ResultError> errors;  // by the name of the metric
  std::vector<std::string> script;
  std::string study, about;
  std::vector<std::string> study_columns;
  std::vector<std::vector<Maybe>> study_rows;  // as the columns
  std::vector<ResultBar> bars;
  std::vector<ResultChart> charts;
  std::vector<ResultTable> tables;
  std::map<std::string, double> exercise;  // and "design/..."
  std::string lesson_title, lesson_goal;
  std::vector<ResultTolerance> tolerances;
  std::vector<std::string> hints;
  std::vector<ResultPoint> predicted;
  std::vector<ResultLandmark> landmarks;
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
