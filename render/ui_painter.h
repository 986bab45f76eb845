#pragma once
// Draws the panels of Dear ImGui with our own table of GL functions, into whatever
// frame is bound. The library's packaged back end finds its functions through
// libGL, so it fails where the context comes from OSMesa; this one does not care.
#include <cstdint>
#include <map>
#include <string>

#include "render/gl_functions.h"
#include "render/image.h"

struct ImDrawData;

namespace limberg {

/// The font of the panels: DejaVu Sans where the machine has it, else ImGui's own, which lacks some signs. `pixels` is
/// the height of the em. For the current ImGui context, before its first frame.
void choose_ui_font(float pixels);

class UiPainter {
 public:
  /// Uploads the font atlas of the current ImGui context. The functions must outlive the painter.
  explicit UiPainter(const GlFunctions& gl);
  ~UiPainter();
  UiPainter(const UiPainter&) = delete;
  UiPainter& operator=(const UiPainter&) = delete;

  /// A picture that panels may show, as their ImTextureID; made when it is first asked for by this number.
  void* picture(uint64_t number, const Image& image);
  /// Over the bound frame of width x height pixels, which ImGui's display is stretched to.
  void paint(const ImDrawData& data, int width, int height);

 private:
  const GlFunctions& gl_;
  std::map<uint64_t, GLuint> pictures_;
  GLuint program_ = 0, font_ = 0, array_ = 0, vertices_ = 0, indices_ = 0;
  GLint size_at_ = -1, font_at_ = -1;
};

}  // namespace limberg
