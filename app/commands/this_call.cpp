#include "app/commands/this_call.h"

#include <fstream>

namespace limberg {

std::string this_call() {
  std::ifstream in("/proc/self/cmdline", std::ios::binary);
  std::string call, word;
  for (bool first = true; std::getline(in, word, '\0'); first = false) {
    if (first) word = "limberg";  // from wherever it was called
    const bool plain = !word.empty() && word.find_first_of(" \t\n'\"\\$`*?[](){}<>|&;#~!") == std::string::npos;
    std::string quoted = plain ? word : "'";
    if (!plain) {
      for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
      quoted += "'";
    }
    call += (first ? "" : " ") + quoted;
  }
  return call;
}

}  // namespace limberg
