#pragma once
// Two results beside each other on one page: six sentences, pictures, both patients to be turned; folded below them
// every figure, stitches, timing and script. Self-contained like report.html.
//
// A figure whose difference is larger than what both lattices' errors together
// explain is marked; where no error is known for either, nothing is claimed.
#include <string>
#include <vector>

#include "app/words/words.h"

namespace limberg {

/// Writes `file` from the folders of two runs (names: report_names.h) and returns it. InputError as write_report.
std::string write_comparison(const std::string& dir_a, const std::string& dir_b, const std::string& file,
                             const Words& words = {});

/// The same as text; the texts are those of result.json.
std::string comparison_html(const std::string& json_a, const std::string& dir_a, const std::string& json_b,
                            const std::string& dir_b, const Words& words = {});

/// One line of a difference of two texts: ' ' in both, '-' only in the first, '+' only in the second.
struct LineChange {
  char kind = ' ';
  std::string line;
};
/// A shortest way from a to b by whole lines (longest common subsequence; O(|a| |b|), at most 4000 lines each: beyond
/// that everything counts as changed).
std::vector<LineChange> line_changes(const std::vector<std::string>& a, const std::vector<std::string>& b);

}  // namespace limberg
