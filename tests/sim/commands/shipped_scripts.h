#pragma once
// The shipped scripts recordings/NAME.jsonl, for tests.
#include <string>
#include <vector>

#include "app/program/places.h"
#include "sim/commands/script.h"

namespace limberg::test {

inline Script shipped_script(const std::string& name) {
  return load_script(source_dir() + "/recordings/" + name + ".jsonl");
}
inline std::vector<Command> shipped_commands(const std::string& name) {
  std::vector<Command> commands;
  for (const ScriptLine& l : shipped_script(name).lines) commands.push_back(l.command);
  return commands;
}
/// The first of a kind.
template <class C>
C first_of(const std::vector<Command>& commands) {
  for (const Command& c : commands)
    if (const C* of_kind = std::get_if<C>(&c)) return *of_kind;
  return {};
}

}  // namespace limberg::test
