#pragma once
// The places for figures in a text: {} {:.1f} {0} {1:.3g}, as fmt has them.
#include <string>
#include <string_view>
#include <vector>

namespace limberg {

struct Placeholder {
  int index = 0;
  std::string spec;  // what follows the colon
  bool operator==(const Placeholder&) const = default;
};

struct Placeholders {
  std::vector<std::string> piece;  // one more than places; braces as they are seen
  std::vector<Placeholder> place;
  std::string wrong;  // not empty: the text is no format, and why
};
Placeholders placeholders_of(std::string_view text);

/// What a translation's places lack or have too many, in words; empty: they are those of the English. In a form for one
/// of several (`may_omit`) places may be left out.
std::string places_differ(const Placeholders& english, const Placeholders& translated, bool may_omit);

/// The format with numbers of floating point by the locale: {:.1f} becomes {:.1Lf}.
std::string by_locale(std::string_view format);

}  // namespace limberg
