#pragma once
// One self-contained report.html from result.json and the pictures beside it: no network, no script needed to read it,
// fit for a phone, a dark screen and paper.
#include <string>

#include "app/words/words.h"

namespace limberg {

/// Writes DIR/report.html (names: report_names.h) and returns its path. Fields that are absent are left out.
/// InputError when DIR or its result.json is missing, is not JSON or is not an object, or when DIR cannot be written.
std::string write_report(const std::string& dir, const Words& words = {});

/// The same as text. Pictures are read from `dir` and embedded; a picture that is missing or is no PNG is left out.
std::string report_html(const std::string& result_json, const std::string& dir, const Words& words = {});

}  // namespace limberg
