#pragma once
// What came of an act of one part of a patient, and what takes it back.
#include <optional>
#include <string>
#include <utility>

#include "sim/commands/command.h"

namespace limberg {

template <class Change>
struct Acted : Outcome {
  Acted(bool is_done, std::string why) : Outcome{is_done, std::move(why)} {}
  Acted(Outcome o) : Outcome(std::move(o)) {}
  Acted(Outcome o, Change c) : Outcome(std::move(o)), change(std::move(c)) {}

  std::optional<Change> change;  // none: the act is no entry of the history
  bool goes_on = false;          // the change belongs to the entry before it
  bool ends_redo = false;        // no entry, but what was undone before cannot be redone any more
};

}  // namespace limberg
