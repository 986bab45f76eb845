#pragma once
// The manual page and the shell's completion, made from the command line itself so that they never differ from --help.
#include <string>

namespace CLI {
class App;
}

namespace limberg {

/// limberg(1) in man's macros.
std::string manual_page(const CLI::App& app, const std::string& version);
/// A completion for bash: commands, options, and the words that an option expects where it names them.
std::string bash_completion(const CLI::App& app);

}  // namespace limberg
