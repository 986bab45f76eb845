// What a script does, line by line. Needs scripts alone: neither meshes nor a solver are linked.
//
//   script_lines recordings/rhomboid.jsonl
#include <fmt/core.h>

#include "sim/base/error.h"
#include "sim/commands/script.h"

int main(int argc, char** argv) try {
  using namespace limberg;
  if (argc < 2) {
    fmt::print(stderr, "script_lines SCRIPT\n");
    return 2;
  }
  const Script script = load_script(argv[1]);
  for (const ScriptLine& l : script.lines) fmt::print("{:4} {}\n", l.line, action_name(l.command));
  fmt::print("{} actions on {}\n", script.lines.size(), script.header.scene);
} catch (const limberg::InputError& e) {
  fmt::print(stderr, "script_lines: {}\n", e.what());
  return 2;
}
