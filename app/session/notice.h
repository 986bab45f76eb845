#pragma once
// What the solver did with a command, for whoever shows the session; passed through a ring.
#include <array>
#include <cstdint>
#include <memory>
#include <string>

#include "sim/commands/command.h"

namespace limberg {

struct Notice {
  enum Kind : int32_t { done, undone, redone, refused, dropped };  // dropped: a gesture that was no act
  int32_t kind = done;
  double t_s = 0;                 // session time
  std::array<char, 24> action{};  // as in a script: "incise"
  std::array<char, 232>
      text{};  // done: the act in a few words; refused, dropped: why. Ends with a zero, cut short where it is longer
  int32_t freed = -1;  // done, a cut of bone: so many pieces came free by it, 0: it hangs together; -1: another act
  std::shared_ptr<const Command> command;  // what was done or refused; of undo and redo these

  template <size_t n>
  static void put(std::array<char, n>& to, const std::string& from) {
    to.fill(0);
    for (size_t i = 0; i < from.size() && i + 1 < n; ++i) to[i] = from[i];
  }
};

}  // namespace limberg
