#include "app/window/glfw_screen.h"

#include "sim/base/part.h"

namespace limberg {

std::unique_ptr<DesktopScreen> open_glfw_screen(const std::string& title, int width, int height) {
  const LoadedPart part = load_part("glfw", "limberg_glfw_screen", "GLFW (Debian: libglfw3)");
  if (!part.entry) throw RenderUnavailable("no window: " + part.why);
  software_drawing_threads(0);
  const auto make = reinterpret_cast<DesktopScreen* (*)(const std::string&, int, int)>(part.entry);
  return std::unique_ptr<DesktopScreen>(make(title, width, height));
}

}  // namespace limberg
