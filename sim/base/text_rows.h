#pragma once
// Lines of a text, words of a line, and the number that a word is.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>

namespace limberg {

/// The line that begins at `at`, without its end; moves `at` behind it. False at the end.
inline bool next_line(std::string_view text, size_t& at, std::string_view& line) {
  if (at >= text.size()) return false;
  const size_t end = std::min(text.find('\n', at), text.size());
  line = text.substr(at, end - at);
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  at = end + 1;
  return true;
}

/// The next of the words that any of `gaps` part; takes it off the line. False: there is none.
inline bool next_word(std::string_view& line, std::string_view& word, std::string_view gaps = " \t,;") {
  line.remove_prefix(std::min(line.find_first_not_of(gaps), line.size()));
  word = line.substr(0, line.find_first_of(gaps));
  line.remove_prefix(word.size());
  return !word.empty();
}

/// All of the word, without a plus; none where it is no finite number.
inline std::optional<double> finite_number(std::string_view word) {
  double v = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), v);
  if (word.empty() || error != std::errc() || end != word.data() + word.size() || !std::isfinite(v))
    return std::nullopt;
  return v;
}

}  // namespace limberg
