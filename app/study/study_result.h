#pragma once
// What a study leaves: rows, charts, bars and a report, of the members that are there.
#include <optional>
#include <string>
#include <vector>

#include "app/result/result.h"
#include "app/study/study.h"
#include "app/study/uncertainty.h"

namespace limberg::study {

/// The members of one family, in order, and what they came to.
struct Gathered {
  const Family* family = nullptr;
  std::vector<Values> members;
  std::vector<Row> rows;                                    // of the members that are done, in their order
  std::vector<size_t> row_of;                               // per row: its member
  std::vector<std::pair<std::string, std::string>> failed;  // member's name and why
  bool complete() const { return rows.size() == members.size(); }
};

/// Bars of all parts; those of parts after the first first say which family they are of.
std::vector<Bar> bars_of(const std::vector<Gathered>& parts);

/// result.json: rows and pictures of the first part, bars and charts of all. Of a sampled study its bands and shares,
/// and spread_charts in the place of the family's own.
Result result_of(const std::vector<Gathered>& parts, const std::vector<Bar>& bars,
                 const std::optional<SampledStudy>& sampled = {});

/// rows.csv (further parts: NAME.csv) and the charts as SVG, each file whole or not at all.
void leave_files(const std::vector<Gathered>& parts, const std::string& dir,
                 const std::optional<SampledStudy>& sampled = {});

/// Copies the members' pictures to where the report looks for them, numbered in the order of the rows.
void leave_pictures(const Gathered& part, const std::vector<std::string>& picture_of_row, const std::string& dir);

}  // namespace limberg::study
