#pragma once
// How deep lists and objects of a JSON text lie in each other: reading and writing them takes stack for every level, so
// a file is asked before it is parsed.
#include <algorithm>
#include <string>

namespace limberg {

inline int json_nesting(const std::string& text) {
  int depth = 0, deepest = 0;
  bool quoted = false;
  for (size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (quoted) {
      if (c == '\\')
        ++i;
      else
        quoted = c != '"';
    } else if (c == '"') {
      quoted = true;
    } else if (c == '[' || c == '{') {
      deepest = std::max(deepest, ++depth);
    } else if (c == ']' || c == '}') {
      --depth;
    }
  }
  return deepest;
}

}  // namespace limberg
