#pragma once
// Incisions that came in pieces, seen as the strokes that they are.
#include <span>
#include <vector>

#include "sim/commands/command.h"

namespace limberg {

/// The same commands with every run of pieces of one stroke (InciseMore) joined into one Incise, at the place of its
/// first piece: for a hand that is to draw it, and for whoever looks for flaps in a script.
std::vector<Command> join_strokes(std::span<const Command> commands);

}  // namespace limberg
