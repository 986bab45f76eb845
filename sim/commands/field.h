#pragma once
// A field of a command, as a line of a script holds it: its key, its limits, whether it may be left out, what it means.
// The kind of value follows from the type of the command's member (table.h).
#include <cstdint>
#include <span>

#include "sim/commands/script_limits.h"

namespace limberg {

/// When a field stands in a line.
enum class Stands : uint8_t {
  always,   // it must be given
  written,  // it may be left out and then has its default; it is written in any case
  if_other  // it may be left out; it is written when it differs from its default: 0, false (`on`), empty, none
};

struct Field {
  const char* key;   // ends in its unit where it has one
  const char* help;  // one sentence, with the reason of its limit where that is not plain
  Stands stands = Stands::always;
  double from = 0, to = 0;                       // limits of a number; of a path, `from` is the least number of points
  bool above = false;                            // `from` itself is refused
  bool on = false;                               // of a true or false: its default
  size_t bytes = 0;                              // of a text: the most
  std::span<const char*const> names{}, words{};  // of a choice: its names in a script and in words, in its order
  double usual_from = 0, usual_to = 0;           // what a slider offers

  constexpr Field usually(double lo, double hi) const {
    Field f = *this;
    f.usual_from = lo, f.usual_to = hi;
    return f;
  }

  constexpr Field maybe() const {
    Field f = *this;
    f.stands = Stands::if_other;
    return f;
  }

  // The kinds of fields.
  static constexpr Field given(const char* key, const char* help) { return {.key = key, .help = help}; }
  static constexpr Field path(const char* key, size_t least, const char* help) {
    return {.key = key, .help = help, .from = double(least), .to = double(ScriptLimits::path_points)};
  }
  static constexpr Field number(const char* key, double from, double to, const char* help,
                                Stands stands = Stands::written) {
    return {.key = key, .help = help, .stands = stands, .from = from, .to = to};
  }
  static constexpr Field number_above(const char* key, double from, double to, const char* help) {
    return {.key = key, .help = help, .stands = Stands::written, .from = from, .to = to, .above = true};
  }
  static constexpr Field flag(const char* key, bool otherwise, const char* help) {
    return {.key = key, .help = help, .stands = Stands::if_other, .on = otherwise};
  }
  static constexpr Field text(const char* key, size_t bytes, const char* help, Stands stands = Stands::always) {
    return {.key = key, .help = help, .stands = stands, .bytes = bytes};
  }
  static constexpr Field choice(const char* key, std::span<const char* const> names, std::span<const char* const> words,
                                const char* help, Stands stands = Stands::always) {
    return {.key = key, .help = help, .stands = stands, .bytes = 40, .names = names, .words = words};
  }
  static constexpr Field optional(const char* key, const char* help, Stands stands = Stands::if_other) {
    return {.key = key, .help = help, .stands = stands};
  }
};

}  // namespace limberg
