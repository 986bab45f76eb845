#pragma once
// A window of the desktop, through GLFW. Made, pumped and destroyed on the main thread.
#include <functional>
#include <memory>
#include <string>

#include "app/window/screen.h"

namespace limberg {

class GlfwScreen final : public Screen {
 public:
  /// RenderUnavailable when there is no display or it has no OpenGL 3.3 core.
  GlfwScreen(const std::string& title, int width, int height);
  ~GlfwScreen() override;
  std::unique_ptr<GlContext> context() override;

  /// Takes what the desktop has to say. `on_event` hears it (x, y in pixels of the frame) and passes on what the render
  /// thread is to see; without it, that is everything.
  void pump();
  std::function<void(const WindowEvent& event)> on_event;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace limberg
