#pragma once
// Draws a RenderScene with OpenGL 3.3 core into an image. No picture depends on anything but the scene, the views and
// the options: the same input gives the same bytes.
//
// Passes: shadow map (optional; kept while nothing moves), tissue, props, background, occlusion (optional,
// occlusion.h), lines, a translucent face; then the image is read back. Text and legends are drawn on
// the image afterwards (overlay.h), so they never depend on the driver.
//
// draw() does all of it. A window takes the steps one by one, so that its panels are drawn in the same frame:
//
//   renderer.paint(scene, views, options);   // once, or again over a part of the frame with options.keep
//   renderer.compose(width, height);         // into the window's frame, enlarged when it
//                                            was drawn smaller; the picture stays as it is
//   ui.paint(...);                           // ui_painter.h
//   renderer.present(width, height);         // to the window; or renderer.read()
//
// So a frame in which only a panel has changed begins with compose().
#include <memory>
#include <span>

#include "render/colour_map.h"
#include "render/gl_context.h"
#include "render/image.h"
#include "render/quality.h"
#include "render/render_scene.h"
#include "render/view.h"

namespace limberg {

/// Of a face over bones.
enum class FaceLook : uint8_t { solid, clear, hidden };

struct DrawOptions {
  int width = 1280, height = 720;
  int supersample = 1;  // 1..4: draws this many times wider and higher, then averages
  int shrink = 1;       // paint(): draws this many times smaller; compose() enlarges
  bool shadow = true;
  bool fine_skin = true;  // bump and second specular lobe
  bool occlusion = false;
  bool still = true;           // QualityLevel::still
  bool tension_lines = false;  // on the skin: dashes along the lines of tension
  bool wireframe = false;      // the tissue's triangles as lines
  bool keep = false;           // paint(): leave what is there; only the views' parts of the frame are drawn anew
  bool colour_field = false;   // show RenderScene::field instead of the skin's (the face's) colour
  FaceLook face = FaceLook::solid;
  float clear_tool_mm = 0;  // a tool is seen through from so far above its tip on; 0: it is not
  Vec3f tool_tip_mm = Vec3f::Zero();
  ColourScale scale = ColourScale::magnitude;
  double field_min = 0, field_max = 1;
  int iso_lines = 10;  // intervals of the colour map that are parted by thin lines; 0 = none
  Rgb8 background_top{108, 142, 148}, background_bottom{44, 66, 74};
  bool operator==(const DrawOptions&) const = default;
};

/// A level of quality (quality.h) at a size; the rest as it is by default.
DrawOptions draw_options(const QualityLevel& level, int width, int height);

/// Per pixel: Part << 24 | number. Number: triangle of SurfaceView (tissue), id of the suture or hook.
struct IdImage {
  int width = 0, height = 0;
  std::vector<uint32_t> id;
  uint32_t at(int x, int y) const { return id[size_t(y) * size_t(width) + size_t(x)]; }
};

struct GlFunctions;

class Renderer {
 public:
  /// RenderUnavailable when the context lacks a function of OpenGL 3.3 core.
  explicit Renderer(std::unique_ptr<GlContext> context);
  ~Renderer();
  Renderer(Renderer&&) noexcept;

  Image draw(const RenderScene& scene, const View& view, const DrawOptions& options);
  Image draw(const RenderScene& scene, std::span<const View> views, const DrawOptions& options);
  /// The same without reading back; the frame keeps it. `supersample` is not regarded.
  void paint(const RenderScene& scene, std::span<const View> views, const DrawOptions& options);
  /// Left and right eye as a red-cyan anaglyph (stereo.h). The views fill the whole frame.
  void paint_anaglyph(const RenderScene& scene, const View& left, const View& right, const DrawOptions& options);
  /// Copies what was painted to a frame of this size, which is then the one that is drawn into, read and presented.
  void compose(int width, int height);
  Image read();
  /// Copies the frame to the context's own and shows it. width, height: of the window's frame, in pixels.
  void present(int width, int height);
  /// For others who draw into the frame that was painted last (it is bound).
  const GlFunctions& functions() const;

  IdImage draw_ids(const RenderScene& scene, const View& view, int width, int height);

  std::string describe() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace limberg
