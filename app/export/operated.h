#pragma once
// What `operate` has left of itself in its result.json: enough to carry it out again.
#include <cstdint>
#include <optional>
#include <string>

#include "sim/commands/script.h"

namespace limberg {

struct OperatedCall {
  std::string scene_path;        // empty: the result does not say
  double cell_mm = 0;            // 0: the scene's own
  std::optional<uint64_t> seed;  // that the lattice was made with; nothing: the scene's own
  Script script;
};

/// `file`: what a refusal names. InputError: no result of an operate, or none with a script.
OperatedCall operated_call(const std::string& text, const std::string& file);

}  // namespace limberg
