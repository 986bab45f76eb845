#pragma once
// JSON as other programs' writers leave it, with the line of every value: a comma between two entries may be missing,
// or stand after the last one. Everything else is as strict as the standard (RFC 8259) says; numbers are finite.
//
// (The library that reads our own files accepts neither, and does not say where a value stood.)
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace limberg {

struct LenientJson {
  enum class Kind : uint8_t { null, boolean, number, text, list, object };
  Kind kind = Kind::null;
  int line = 0;  // of the file, where the value begins
  bool truth = false;
  double number = 0;
  std::string text;
  std::vector<std::string> key;   // of an object, one for each of `item`
  std::vector<LenientJson> item;  // of a list or an object

  bool is(Kind k) const { return kind == k; }
  /// The last entry of that name; null: there is none, or this is no object.
  const LenientJson* find(std::string_view name) const;
};

struct LenientJsonLimits {
  static constexpr size_t file_bytes = size_t(16) << 20;
  static constexpr size_t values = 2'000'000;
  static constexpr int depth = 32;
};

/// Throws InputError with the line of the trouble. `mended` (may be null) receives what was let pass, a line each.
LenientJson parse_lenient_json(std::string_view text, const std::string& file, std::vector<std::string>* mended);

/// "a number", "a list" and so on, for messages.
const char* kind_words(LenientJson::Kind kind);

}  // namespace limberg
