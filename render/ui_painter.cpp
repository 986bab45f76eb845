#include "render/ui_painter.h"

#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <filesystem>

#include "render/gl_objects.h"

namespace limberg {

namespace {

const char* const kVertex = R"(#version 330 core
layout(location = 0) in vec2 position;
layout(location = 1) in vec2 uv;
layout(location = 2) in vec4 colour;
uniform vec2 size;  // of the frame, in the panels' units
out vec2 v_uv;
out vec4 v_colour;
void main() {
  v_uv = uv, v_colour = colour;
  gl_Position = vec4(2.0 * position.x / size.x - 1.0, 1.0 - 2.0 * position.y / size.y, 0.0, 1.0);
}
)";

const char* const kFragment = R"(#version 330 core
in vec2 v_uv;
in vec4 v_colour;
uniform sampler2D font;
out vec4 colour;
void main() { colour = v_colour * texture(font, v_uv); }
)";

constexpr const char* kFontFile = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";  // Debian: fonts-dejavu-core

}  // namespace

void choose_ui_font(float pixels) {
  ImGuiIO& io = ImGui::GetIO();
  // Latin, Greek, general punctuation, superscripts, arrows, mathematical signs, triangles and ticks.
  static const ImWchar ranges[] = {0x20,   0xff,   0x370,  0x3ff,  0x2010, 0x2040, 0x2070, 0x209f, 0x2190,
                                   0x21ff, 0x2200, 0x22ff, 0x25a0, 0x25ff, 0x2713, 0x2717, 0};
  std::error_code ec;
  if (!std::filesystem::exists(kFontFile, ec) || !io.Fonts->AddFontFromFileTTF(kFontFile, pixels, nullptr, ranges))
    io.Fonts->AddFontDefault();
}

UiPainter::UiPainter(const GlFunctions& gl) : gl_(gl) {
  const GlProgram program(gl, kVertex, kFragment);
  program_ = program.id();
  size_at_ = gl.GetUniformLocation(program_, "size"), font_at_ = gl.GetUniformLocation(program_, "font");
  unsigned char* texels = nullptr;
  int w = 0, h = 0;
  ImGui::GetIO().Fonts->GetTexDataAsRGBA32(&texels, &w, &h);
  font_ = make_texture(gl, {w, h, std::vector<uint8_t>(texels, texels + size_t(4) * size_t(w) * size_t(h))}, false,
                       false, false);
  gl.GenVertexArrays(1, &array_);
  gl.GenBuffers(1, &vertices_);
  gl.GenBuffers(1, &indices_);
  gl.BindVertexArray(array_);
  gl.BindBuffer(GL_ARRAY_BUFFER, vertices_);
  gl.BindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices_);
  const auto attribute = [&](GLuint at, int n, GLenum type, GLboolean unit, size_t offset) {
    gl.EnableVertexAttribArray(at);
    gl.VertexAttribPointer(at, n, type, unit, sizeof(ImDrawVert), reinterpret_cast<void*>(offset));
  };
  attribute(0, 2, GL_FLOAT, GL_FALSE, offsetof(ImDrawVert, pos));
  attribute(1, 2, GL_FLOAT, GL_FALSE, offsetof(ImDrawVert, uv));
  attribute(2, 4, GL_UNSIGNED_BYTE, GL_TRUE, offsetof(ImDrawVert, col));
}

UiPainter::~UiPainter() {
  for (const auto& [number, texture] : pictures_) gl_.DeleteTextures(1, &texture);
  gl_.DeleteProgram(program_);
  gl_.DeleteTextures(1, &font_);
  gl_.DeleteBuffers(1, &vertices_);
  gl_.DeleteBuffers(1, &indices_);
  gl_.DeleteVertexArrays(1, &array_);
}

void* UiPainter::picture(uint64_t number, const Image& image) {
  constexpr size_t kMost = 400;  // the oldest go: they are made again when they are seen
  GLuint& texture = pictures_[number];
  if (texture == 0 && !image.empty()) {
    std::vector<uint8_t> rgba;
    rgba.reserve(image.rgb.size() / 3 * 4);
    for (size_t i = 0; i + 2 < image.rgb.size(); i += 3)
      rgba.insert(rgba.end(), {image.rgb[i], image.rgb[i + 1], image.rgb[i + 2], 255});
    texture = make_texture(gl_, {image.width, image.height, std::move(rgba)}, false, false, false);
    if (pictures_.size() > kMost && pictures_.begin()->first != number) {
      gl_.DeleteTextures(1, &pictures_.begin()->second);
      pictures_.erase(pictures_.begin());
    }
  }
  return reinterpret_cast<void*>(uintptr_t(pictures_[number]));
}

void UiPainter::paint(const ImDrawData& data, int width, int height) {
  gl_.Viewport(0, 0, width, height);
  gl_.Disable(GL_DEPTH_TEST);
  gl_.Enable(GL_BLEND);
  gl_.BlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  gl_.Enable(GL_SCISSOR_TEST);
  gl_.UseProgram(program_);
  const float sx = data.DisplaySize.x > 0 ? float(width) / data.DisplaySize.x : 1,
              sy = data.DisplaySize.y > 0 ? float(height) / data.DisplaySize.y : 1;
  gl_.Uniform2f(size_at_, float(width) / sx, float(height) / sy);
  gl_.Uniform1i(font_at_, 0);
  gl_.ActiveTexture(GL_TEXTURE0);
  gl_.BindTexture(GL_TEXTURE_2D, font_);
  gl_.BindVertexArray(array_);
  for (int n = 0; n < data.CmdListsCount; ++n) {
    const ImDrawList& list = *data.CmdLists[n];
    gl_.BindBuffer(GL_ARRAY_BUFFER, vertices_);
    gl_.BufferData(GL_ARRAY_BUFFER, GLsizeiptr(list.VtxBuffer.size_in_bytes()), list.VtxBuffer.Data, GL_STREAM_DRAW);
    gl_.BindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices_);
    gl_.BufferData(GL_ELEMENT_ARRAY_BUFFER, GLsizeiptr(list.IdxBuffer.size_in_bytes()), list.IdxBuffer.Data,
                   GL_STREAM_DRAW);
    for (const ImDrawCmd& c : list.CmdBuffer) {
      const int x0 = std::max(0, int(sx * c.ClipRect.x)), y0 = std::max(0, int(sy * c.ClipRect.y));
      const int x1 = std::min(width, int(std::ceil(sx * c.ClipRect.z))),
                y1 = std::min(height, int(std::ceil(sy * c.ClipRect.w)));
      if (x1 <= x0 || y1 <= y0) continue;
      const auto own = GLuint(reinterpret_cast<uintptr_t>(c.TextureId));
      gl_.BindTexture(GL_TEXTURE_2D, own != 0 ? own : font_);
      gl_.Scissor(x0, height - y1, x1 - x0, y1 - y0);
      gl_.DrawElements(GL_TRIANGLES, GLsizei(c.ElemCount), sizeof(ImDrawIdx) == 2 ? GL_UNSIGNED_SHORT : GL_UNSIGNED_INT,
                       reinterpret_cast<void*>(size_t(c.IdxOffset) * sizeof(ImDrawIdx)));
    }
  }
  gl_.Disable(GL_SCISSOR_TEST);
  gl_.Disable(GL_BLEND);
}

}  // namespace limberg
