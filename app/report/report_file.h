#pragma once
// Where a report's data stand.
#include <string>

namespace limberg {

/// DIR/result.json.
std::string result_file(const std::string& dir);
/// Its text. InputError: no folder, or no result in it.
std::string read_result_file(const std::string& dir);

}  // namespace limberg
