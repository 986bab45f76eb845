#pragma once
// How the acts of Bones say what they did, or that they do not go.
#include <cstdint>
#include <string>
#include <utility>

#include "sim/base/text.h"
#include "sim/commands/command.h"

namespace limberg::bone {

inline Outcome refused(std::string why) { return {false, std::move(why)}; }
inline std::string no_fragment(int32_t id) { return "there is no fragment " + std::to_string(id); }
inline constexpr const char* kHeld = "a fragment is held; it has to be released first";

}  // namespace limberg::bone
