#pragma once
// Numbers in words, in printf's notation.
#include <fmt/printf.h>

#include <string>

namespace limberg {

std::string text(const char* format, const auto&... value) { return fmt::sprintf(format, value...); }

}  // namespace limberg
