#include "app/report/script_words.h"

#include "sim/base/error.h"
#include "sim/commands/script.h"
#include "sim/commands/words.h"

namespace limberg {

std::vector<std::pair<std::string, std::string>> stage_words(const std::vector<std::string>& script) {
  std::vector<std::pair<std::string, std::string>> out;
  std::vector<Command> done;
  for (const std::string& line : script) {
    try {
      done.push_back(parse_command(line, "script", 0));
    } catch (const InputError&) {
      continue;
    }
    const auto* stage = std::get_if<Stage>(&done.back());
    if (!stage) continue;
    out.emplace_back(stage->name, story_of(done));
    done.clear();
  }
  return out;
}

}  // namespace limberg
