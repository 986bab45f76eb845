#pragma once
// A window of the desktop, through GLFW. Made, pumped and destroyed on the main thread. GLFW and X11 are loaded with
// the first one (sim/base/part.h, glfw/glfw_part.cpp).
#include <functional>
#include <memory>
#include <string>

#include "app/window/screen.h"

namespace limberg {

class DesktopScreen : public Screen {
 public:
  /// Takes what the desktop has to say. `on_event` hears it (x, y in pixels of the frame) and passes on what the render
  /// thread is to see; without it, that is everything.
  virtual void pump() = 0;
  std::function<void(const WindowEvent& event)> on_event;
};

/// RenderUnavailable when there is no display, it has no OpenGL 3.3 core, or GLFW cannot be loaded.
std::unique_ptr<DesktopScreen> open_glfw_screen(const std::string& title, int width, int height);

}  // namespace limberg
