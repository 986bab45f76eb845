#include "app/window/waiting.h"

#include <imgui.h>

#include "app/window/desk.h"
#include "render/gl_objects.h"
#include "render/ui_painter.h"

namespace limberg {

namespace {

constexpr float kWaitingFontPx = 18;

/// Dear ImGui for one picture.
struct Panels {
  ImGuiContext* context = ImGui::CreateContext();
  Panels() { ImGui::SetCurrentContext(context); }
  ~Panels() { ImGui::DestroyContext(context); }
};

}  // namespace

Image show_words(Screen& screen, const std::string& words) {
  const int width = screen.width, height = screen.height;
  const std::unique_ptr<GlContext> context = screen.context();
  context->make_current();
  const GlFunctions gl(*context);
  const Panels panels;
  ImGui::GetIO().IniFilename = nullptr;
  ImGui::GetIO().DisplaySize = {float(width), float(height)};
  choose_ui_font(kWaitingFontPx * desk_scale(width, height));
  UiPainter ui(gl);
  ImGui::NewFrame();
  const ImVec2 size = ImGui::CalcTextSize(words.c_str());
  ImGui::GetForegroundDrawList()->AddText({0.5f * (float(width) - size.x), 0.5f * (float(height) - size.y)},
                                          IM_COL32(225, 235, 238, 255), words.c_str());
  ImGui::Render();
  const GlTarget target(gl, GL_RGBA8, width, height);
  target.bind();
  gl.Viewport(0, 0, width, height);
  gl.ClearBufferfv(GL_COLOR, 0, kPaper.data());
  ui.paint(*ImGui::GetDrawData(), width, height);
  const Image drawn = image_of(gl, target);
  gl.BindFramebuffer(GL_DRAW_FRAMEBUFFER, 0);
  gl.BlitFramebuffer(0, 0, width, height, 0, 0, width, height, GL_COLOR_BUFFER_BIT, GL_NEAREST);
  context->show();
  return drawn;
}

}  // namespace limberg
