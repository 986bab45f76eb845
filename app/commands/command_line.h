#pragma once
// What the programs of this house have in common: limberg and limberg_bench are frames around their commands.
#include <functional>
#include <string>
#include <vector>

#include "app/commands/commands.h"

namespace limberg {

/// Runs a program's body: errors become one line on standard error and the exit status that commands.h names.
int run_framed(const std::function<int()>& body);

/// Parses `words` (without the program's name) and carries out the command that was chosen.
/// `first_steps` is printed when no command was given.
int run_command_line(CLI::App& app, std::vector<std::string> words, const Chosen& chosen, const char* first_steps);

}  // namespace limberg
