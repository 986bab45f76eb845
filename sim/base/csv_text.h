#pragma once
// Text out of a file, as it may stand in a table of comma-separated values.
#include <string>
#include <string_view>

namespace limberg {

/// In quotes, its own quotes doubled. A spreadsheet takes what begins with = + - @ for a formula, and carries it out:
/// such text begins with an apostrophe.
inline std::string csv_text(std::string_view text) {
  std::string cell = "\"";
  if (!text.empty() && std::string_view("=+-@\t\r").find(text[0]) != std::string_view::npos) cell += '\'';
  for (const char c : text) cell += c == '"' ? std::string("\"\"") : std::string(1, c);
  return cell + '"';
}

}  // namespace limberg
