#pragma once
// Acts in words, by the rows of the table.
#include <span>
#include <string>
#include <vector>

#include "sim/commands/command.h"

namespace limberg {

/// A few words for a list on a screen: "incise 40 mm, 4 mm deep".
std::string in_words(const Command& command);

/// What was done, for the caption of a picture: "Excision of 200 mm², 4 mm deep. 2 hooks set." Cuts first, one sentence
/// each; then how many there were of everything else. Pieces of one stroke are one incision, and so are strokes that go
/// on within 0.5 mm of where the one before ended, as deep and as steep. Incisions alike that follow each other share a
/// sentence; what was taken back and what has no length is not told.
std::string story_of(const std::vector<Command>& commands);

/// The kinds of acts that stand at the end, for a title, in the order of their first: "Excision, undermining and
/// sutures". Empty: nothing was cut, sewn or moved.
std::string title_of_acts(std::span<const Command> script);

}  // namespace limberg
