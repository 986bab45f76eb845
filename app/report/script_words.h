#pragma once
// What was done between two stages of an operation script, as one sentence for a caption.
#include <string>
#include <utility>
#include <vector>

#include "sim/commands/command.h"

namespace limberg {

/// The acts of a script; lines that are not understood are passed over.
std::vector<Command> acts_of(const std::vector<std::string>& script);

/// Per stage of the script, in order: its name and what led to it ("Excision 4 mm deep. Incision of 40 mm ..."). A
/// stroke that was still drawn when a stage passed is told whole, in the stage where it began.
std::vector<std::pair<std::string, std::string>> stage_words(const std::vector<Command>& acts);

}  // namespace limberg
