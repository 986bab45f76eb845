#pragma once
// result.json as plain data: what is absent is absent here too. Read once, without trust; the sections of the report
// only see this. Names that results are written with are those of the structs that are read here (run_result.h).
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/result/run_result.h"
#include "app/result/uncertainty_result.h"
#include "app/words/words.h"

namespace limberg {

/// residual, distance_mm: of a session its solver's.
struct ReportData : ResultOrigin, ResultRun {
  Words w;  // that it is told in; the texts here are those of the result, in English
  std::map<std::string, double> lattice_numbers, metrics;  // every number in `lattice`, in `metrics`
  ResultPatient patient;
  std::vector<ResultStage> stages;
  ResultPictures pictures;  // their usual names, where the result says none
  std::vector<ResultPicture> gallery;
  std::vector<double> series_t_s, series_residual, series_distance_mm;  // NaN where a value is missing
  std::vector<double> series_closure_N, series_suture_max_N;
  std::vector<std::pair<std::string, std::vector<double>>> balance;  // name, N; "sum_N" and others
  Maybe balance_relative;
  std::vector<ResultConvergence> convergence;
  std::map<std::string, ResultError> errors;  // by the name of the metric
  std::vector<std::string> script;
  std::string acts_title;  // of the acts in it (title_of_acts)
  std::string reproduce;
  MaybeCount commands;  // how many were carried out
  std::string study, about;
  std::vector<std::string> study_columns;
  std::vector<std::vector<Maybe>> study_rows;  // as the columns
  ResultUncertainty uncertainty;               // of a sampled study
  std::vector<Bar> bars;
  std::vector<ResultVerdict> verdict;  // bad lines first, as it was written
  std::vector<ResultChart> charts;
  std::vector<ResultTable> tables;
  std::map<std::string, double> exercise;  // and "design/..."
  ResultLesson lesson;
  std::vector<std::pair<std::string, std::string>> damage;  // of the recording: name, value

  /// Bone alone was operated on, with no lattice of skin.
  bool of_bones() const { return lattice_numbers.empty() && sutures().empty() && metrics.count("fragments") > 0; }

  const std::vector<ResultSuture>& sutures() const { return entries(patient.sutures); }

  Maybe metric(const std::string& name) const {
    const auto it = metrics.find(name);
    return it == metrics.end() ? Maybe() : Maybe(it->second);
  }
};

/// InputError (file, line) when the text is not JSON or not an object.
ReportData read_report_data(const std::string& json_text, const std::string& file, const Words& words = {});

}  // namespace limberg
