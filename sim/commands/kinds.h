#pragma once
// Kinds of acts, by the rows of the table (table.h).
#include "sim/commands/command.h"

namespace limberg {

/// It may cut skin: redo too, which may do a cut again.
bool cuts_skin(const Command& command);
/// It ties stitches.
bool sews(const Command& command);
/// It sets, moves or releases a hook.
bool is_of_hooks(const Command& command);
/// What it does hangs on the order of the acts before it: it takes one back, or names stitches by their numbers.
bool looks_back(const Command& command);
/// It is the pen's or the swab's.
bool is_of_pen(const Command& command);
/// It changes nothing in the patient: a stage, a wait.
bool leaves_patient(const Command& command);

}  // namespace limberg
