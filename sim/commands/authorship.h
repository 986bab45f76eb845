#pragma once
// Which acts of a session stand at its end, and whose they are. A script says both: undo and redo take acts back and
// make them again, and what stands between {"action":"shown"} and its end was done by the program, to show it.
#include <span>
#include <vector>

#include "sim/commands/command.h"

namespace limberg {

/// It is an entry of the patient's history: undo takes it back. Hooks are none; they stand as they stood before the act
/// that is taken back.
bool is_undoable(const Command& command);

struct StandingAct {
  Command command;
  bool shown = false;  // by the program
};

/// In their order, strokes joined (join_strokes); without undo, redo, stages, waits and the brackets themselves.
std::vector<StandingAct> standing_acts(std::span<const Command> script);

/// Of all acts, those that are the learner's own, undo and redo among them: what lies outside the brackets.
std::vector<Command> own_acts(std::span<const Command> script);

/// The program has done something to the patient that was not only taking back.
bool was_shown(std::span<const Command> script);

}  // namespace limberg
