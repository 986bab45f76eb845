#include "app/report/script_words.h"

#include <map>

#include "sim/base/error.h"
#include "sim/commands/script.h"
#include "sim/commands/words.h"

namespace limberg {

std::vector<Command> acts_of(const std::vector<std::string>& script) {
  std::vector<Command> acts;
  for (const std::string& line : script) try {
      acts.push_back(parse_command(line, "script", 0));
    } catch (const InputError&) {
    }
  return acts;
}

std::vector<std::pair<std::string, std::string>> stage_words(const std::vector<Command>& acts) {
  std::vector<std::string> names;
  std::vector<std::vector<Command>> led_to(1);  // each stage, and what came after the last
  std::map<int, size_t> drawn;                  // strokes that have not ended, by the stage where they began
  for (const Command& act : acts) {
    size_t stage = led_to.size() - 1;
    if (const auto* piece = std::get_if<InciseMore>(&act)) {
      stage = drawn.try_emplace(piece->stroke, stage).first->second;
      if (piece->last) drawn.erase(piece->stroke);
    }
    led_to[stage].push_back(act);
    if (const auto* passed = std::get_if<Stage>(&act)) names.push_back(passed->name), led_to.emplace_back();
  }
  std::vector<std::pair<std::string, std::string>> out;
  for (size_t i = 0; i < names.size(); ++i) out.emplace_back(names[i], story_of(led_to[i]));
  return out;
}

}  // namespace limberg
