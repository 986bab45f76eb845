#pragma once
// How Dear ImGui looks and which of our keys it knows. For .cpp files of the window only.
#include <cstdint>

#include "app/assembly/desk_memory.h"

namespace limberg {

/// A key as Dear ImGui counts them; -1: it needs it for nothing.
int imgui_key(int32_t code);
/// Of the current ImGui context.
void set_style(DeskColours colours);

}  // namespace limberg
