#include "app/window/run_window.h"
#include "render/gl_context.h"

namespace limberg {

std::unique_ptr<SessionWindow> open_window(const Scene&, const WindowCall&) {
  throw RenderUnavailable("no window: this program was built without one (LIMBERG_WINDOW=OFF)");
}

}  // namespace limberg
