#pragma once
// A word out of a file, as it may stand in a message: short, and without the zero bytes that would end the message
// before its reason, or what a terminal would take for a command.
#include <string>
#include <string_view>

namespace limberg {

inline std::string quoted(std::string_view word, size_t most = 40) {
  std::string s = "'" + std::string(word.substr(0, most)) + "'";
  for (char& c : s)
    if (static_cast<unsigned char>(c) < ' ' || c == 127) c = '?';
  return s;
}

}  // namespace limberg
