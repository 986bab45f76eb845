#pragma once
// A piece of a page. It is well-formed by its type: text becomes Markup by being escaped, here and nowhere else, and
// tags come from the elements (elements.h) alone. So a section of a report names data and words.
//
//   html::paragraph("Closure force: " + html::bold("7.25 N"))     "a < b" reads a < b, and is never a tag
#include <concepts>
#include <string>
#include <string_view>
#include <utility>

namespace limberg::html {

/// Text for an element or a quoted attribute: & < > " ' are escaped, control characters and broken UTF-8 become U+FFFD.
std::string escape(std::string_view text);

class Markup {
 public:
  Markup() = default;
  template <std::convertible_to<std::string_view> Text>
  Markup(const Text& text) : tags_(escape(text)) {}
  /// What is well-formed XML already: for elements.cpp.
  static Markup of_tags(std::string tags) {
    Markup m;
    m.tags_ = std::move(tags);
    return m;
  }

  bool empty() const { return tags_.empty(); }
  const std::string& tags() const { return tags_; }
  Markup& operator+=(const Markup& more) {
    tags_ += more.tags_;
    return *this;
  }
  friend Markup operator+(Markup a, const Markup& b) { return std::move(a += b); }

 private:
  std::string tags_;
};

}  // namespace limberg::html
