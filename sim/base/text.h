#pragma once
// Numbers in words, as printf writes them.
#include <cstdio>
#include <string>

namespace limberg {

std::string text(const char* format, auto... value) {
  std::string s(size_t(std::snprintf(nullptr, 0, format, value...)), '\0');
  std::snprintf(s.data(), s.size() + 1, format, value...);
  return s;
}

}  // namespace limberg
