#pragma once
// An act in a few words, for a list on a screen: "incise 40 mm, 4 mm deep".
#include <string>

#include "sim/commands/command.h"

namespace limberg {

std::string in_words(const Command& command);

}  // namespace limberg
