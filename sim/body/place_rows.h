#pragma once
// Files of places: one a line, [x y z] in mm and what is known there; behind a # is a remark.
#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "sim/base/error.h"
#include "sim/base/text_rows.h"
#include "sim/geometry/vec.h"

namespace limberg {

/// take(X_mm, all N numbers of the row, fail) for every row. Throws InputError with file and line, as fail(what) does;
/// `expected` says what a row is, `count` N in words.
template <size_t N, class Take>
void read_place_rows(std::string_view text, const std::string& file, const char* count, const std::string& expected,
                     Take&& take) {
  size_t at = 0, places = 0;
  std::string_view row, word;
  for (int line = 1; next_line(text, at, row); ++line) {
    row = row.substr(0, row.find('#'));
    std::array<double, N> value{};
    size_t given = 0;
    const auto fail = [&](const std::string& what) { throw InputError(file, line, what + "; " + expected); };
    for (; next_word(row, word, " \t,\r"); ++given) {
      if (given == N) fail(std::string("holds more than ") + count + " numbers");
      const std::optional<double> v = finite_number(word);
      if (!v) fail("holds something that is no number");
      value[given] = *v;
    }
    if (given == 0) continue;
    if (given < N) fail("holds " + std::to_string(given) + " numbers");
    const Vec3 X(value[0], value[1], value[2]);
    if (X.cwiseAbs().maxCoeff() > 1e4) fail("is farther than 10 m from the origin");
    take(X, value, fail);
    ++places;
  }
  if (places == 0) throw InputError(file, 0, "holds no place; " + expected + " in every line");
}

}  // namespace limberg
