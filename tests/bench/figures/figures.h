#pragma once
// docs/figures.md, written from results of `limberg bench SUITE --json FILE`.
//
//   keep_result("out/speed.json", "docs/figures", {...});      // the bars of a result, as a small JSON file
//   write_page("docs/figures", "docs/figures.md");             // the page, between its markers
//
// One file holds one measurement: suite, call, machine, date, version, bars; of soak and start their rows, and the
// pictures that lie beside the result, as well. A second measurement by the same call
// takes the place of the first. earlier.json in the folder maps suites to the date of their last figures; the page
// names them for suites without a whole measurement.
#include <string>

namespace limberg::bench {

struct KeepOptions {
  std::string date;    // of the measurement, "2026-11-23"; empty: the day on which the result was written
  std::string remark;  // a sentence for the reader: what ran beside it, say
};

/// Keeps a result's bars in `folder` and returns the file's path. InputError: no result of a bench.
std::string keep_result(const std::string& result_file, const std::string& folder, const KeepOptions& options);

/// The tables of all measurements in `folder`, in the order of their names. InputError: a file that was not kept by
/// keep_result.
std::string figures_text(const std::string& folder);

/// Replaces the lines between the markers of `page_file`. InputError: the page has no markers.
void write_page(const std::string& folder, const std::string& page_file);

inline constexpr const char* kFiguresBegin = "<!-- figures: written by ./do figures, not by hand -->";
inline constexpr const char* kFiguresEnd = "<!-- end of figures -->";

}  // namespace limberg::bench
