#pragma once
// Acts in words, by the rows of the table.
#include <string>
#include <vector>

#include "sim/commands/command.h"

namespace limberg {

/// A few words for a list on a screen: "incise 40 mm, 4 mm deep".
std::string in_words(const Command& command);

/// What was done, for the caption of a picture: "Excision of 200 mm², 4 mm deep. 2 hooks set." Cuts first, one sentence
/// each; then how many there were of everything else. Pieces of one stroke are one incision.
std::string story_of(const std::vector<Command>& commands);

}  // namespace limberg
