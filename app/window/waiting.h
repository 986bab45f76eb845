#pragma once
// What the window shows until there is a patient, which takes seconds for a head.
#include <string>

#include "app/window/screen.h"
#include "render/image.h"

namespace limberg {

/// Draws a line of words into the middle of the screen, in
/// the colours of the panels, and shows it. Returns what
/// was drawn. RenderUnavailable as the screen's context.
Image show_words(Screen& screen, const std::string& words);

}  // namespace limberg
