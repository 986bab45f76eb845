#pragma once
// Where a report's data stand, and what a page begins with.
#include <string>

namespace limberg {

/// DIR/result.json.
std::string result_file(const std::string& dir);
/// Its text. InputError: no folder, or no result in it.
std::string read_result_file(const std::string& dir);
/// A whole page: head with the style sheet, nothing from the network. `title` is text, `body` markup.
std::string whole_page(const std::string& title, const std::string& body);

}  // namespace limberg
