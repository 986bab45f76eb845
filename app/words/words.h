#pragma once
// Words in the language that somebody asked for. The English text stands in the code and is the key of its translation,
// which a table in a plain file gives (po_file.h, docs/words.md): what the table lacks stays English.
//
//   const Words w;                                           // English
//   w("Try again")
//   w("{:.1f} mm beside the line{}", mm, where)              // checked by the compiler, numbers by the language
//   w.counted(n, "{} stitch", "{} stitches", n)              // the right form, in either language
//   w.as("tool", "Hook")                                     // where one English word has two meanings
//   w.said(line_of_a_result)                                 // an English text that is finished, with its figures
//
// It is handed down to whoever shows words, as a value: a copy is a pointer. Nothing of it is global.
#include <fmt/format.h>

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

namespace limberg {

struct WordTable;

/// Marks an English text that stands in a table of the code and is shown in the language asked for elsewhere: so that
/// it is found by whoever lists the texts (./do words, tests/app/words).
constexpr const char* english(const char* text) { return text; }

/// The same of one and of several.
struct EnglishCount {
  const char *one, *many;
};
constexpr EnglishCount english_counted(const char* one, const char* many) { return {one, many}; }

class Words {
 public:
  Words() = default;  // English
  explicit Words(std::shared_ptr<const WordTable> table) : table_(std::move(table)) {}

  /// "en", "de".
  const std::string& language() const;
  /// Between a number and its fraction.
  char decimal() const;
  /// With a thin space before units, for screens and paper: what operator() with figures, counted and said return.
  Words typeset() const {
    Words w(*this);
    w.typeset_ = true;
    return w;
  }

  /// Lasts as long as the table.
  const char* operator()(const char* english) const { return as("", english); }
  std::string operator()(const std::string& english) const;
  const char* as(const char* context, const char* english) const;

  template <class First, class... Rest>
  std::string operator()(fmt::format_string<First, Rest...> english, First&& first, Rest&&... rest) const {
    return filled(english, fmt::make_format_args(first, rest...));
  }
  /// The form for `n`. A form may leave the number out.
  template <class... Args>
  std::string counted(int64_t n, fmt::format_string<Args...> one, fmt::format_string<Args...> many,
                      Args&&... args) const {
    return filled(n, one, many, fmt::make_format_args(args...));
  }

  /// A finished English text, with its figures, in this language: the entry that it is, else the entry with places for
  /// figures that it fits and that has most letters; else sentence by sentence; else as it is, with the language's
  /// numbers. What stands in a place is itself said so.
  std::string said(std::string_view english) const;

 private:
  std::string filled(fmt::string_view english, fmt::format_args args) const;
  std::string filled(int64_t n, fmt::string_view one, fmt::string_view many, fmt::format_args args) const;

  std::shared_ptr<const WordTable> table_;
  bool typeset_ = false;
};

}  // namespace limberg
