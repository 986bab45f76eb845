#include "render/renderer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>

#include "render/colour_map.h"
#include "render/gl_objects.h"
#include "render/occlusion.h"
#include "render/shaders.h"
#include "render/visible.h"

namespace limberg {

namespace {

constexpr int kShadowSize = 2048, kLiveShadowSize = 1024;
constexpr float kLayerRange_mm = 16;

Vec3f unit_rgb(Rgb8 c) { return Vec3f(float(c.r), float(c.g), float(c.b)) / 255.0f; }

// Of an sRGB byte, as make_texture stores colours: the root of linear light.
float root_of_light(uint8_t c) {
  const float v = float(c) / 255.0f;
  return float(std::sqrt(linear_light(double(v))));
}

// The lamp's view: an orthographic box around the scene, looking along the light.
Mat4f light_matrix(const RenderScene& scene, const Vec3f& back) {
  Vec3f lo = scene.bounds_min, hi = scene.bounds_max;
  const Vec3f centre = 0.5f * (lo + hi);
  const float r = std::max(0.5f * (hi - lo).norm(), 1.0f);
  const Vec3f right = Vec3f(Vec3f::UnitY().cross(back)).normalized(), up = back.cross(right);
  Mat4f m = Mat4f::Identity();
  m.block<1, 3>(0, 0) = right.transpose() / r;
  m.block<1, 3>(1, 0) = up.transpose() / r;
  m.block<1, 3>(2, 0) = -back.transpose() / (2 * r);  // props may stand above the tissue
  m.block<3, 1>(0, 3) = -(m.block<3, 3>(0, 0) * centre);
  return m;
}

}  // namespace

struct Renderer::Impl {
  std::unique_ptr<GlContext> context;
  GlFunctions gl;
  GlProgram background, depth, id;
  std::map<int, GlProgram> programs;  // of tissue and props, compiled when first wanted; see shaded()
  GlProgram line;
  GlMesh tissue_mesh, prop_mesh, line_mesh, empty;
  std::array<std::unique_ptr<ShadowMap>, 2> shadows;  // of pictures that are kept, of live ones
  GLuint skin_map, grid_map, detail_map, slope_map, layer_map = 0, image_map = 0;
  std::shared_ptr<const SkinImage> image_sent;  // that image_map holds
  std::array<GLuint, 2> colour_map;             // by ColourScale
  // What the buffers hold, so that only what has changed is sent, and the shadow of what has not moved is kept.
  std::shared_ptr<const TissueMesh> uploaded;
  // the tissue's triangles are those of the mesh, in their order; else those that a view may show
  bool all_triangles = false;
  VisibleTriangles visible;
  std::vector<std::array<uint32_t, 3>> shown_triangles;
  struct {
    std::vector<Vec3f> x_mm;
    std::vector<float> field;
    PropMesh props;
    bool any = false;
  } held;
  struct {
    bool valid = false;
    const ShadowMap* map = nullptr;
    FaceLook face = FaceLook::solid;
    Mat4f to_light = Mat4f::Identity();
  } cast;
  std::unique_ptr<Occlusion> occlusion;
  std::unique_ptr<GlTarget> picture, composed, ids;
  GlTarget* shown = nullptr;                      // what read() and present() take
  std::array<std::unique_ptr<GlTarget>, 2> eyes;  // of an anaglyph
  std::array<GLuint, 2> eye_map{};
  std::unique_ptr<GlProgram> anaglyph;
  GLint largest = 0;
  bool anisotropic = false;

  static GlContext& current(GlContext& c) {
    c.make_current();
    return c;
  }

  explicit Impl(std::unique_ptr<GlContext> c)
      : context(std::move(c)),
        gl(current(*context)),
        background(gl, shaders::background_vertex, shaders::background_fragment),
        depth(gl, shaders::depth_vertex, shaders::depth_fragment),
        id(gl, shaders::id_vertex, shaders::id_fragment),
        line(gl, shaders::line_vertex, shaders::line_fragment),
        tissue_mesh(gl),
        prop_mesh(gl),
        line_mesh(gl),
        empty(gl),
        skin_map(make_texture(gl, skin_texture(512), true, true, true)),
        grid_map(make_texture(gl, grid_texture(), false, true, true)),
        detail_map(make_texture(gl, detail_texture(), false, true, true)),
        slope_map(make_texture(gl, slope_texture(detail_texture()), false, true, true)),
        colour_map{make_texture(gl, scale_texture(ColourScale::magnitude), false, false, false),
                   make_texture(gl, scale_texture(ColourScale::signed_value), false, false, false)} {
    empty.triangles({{0, 1, 2}});
    gl.GetIntegerv(GL_MAX_RENDERBUFFER_SIZE, &largest);
    anisotropic = has_anisotropy(gl);
  }

  ~Impl() { context->make_current(); }  // the targets are freed in their own context

  template <class T>
  static bool same(const std::vector<T>& a, const std::vector<T>& b) {
    return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
  }

  void send_image(const std::shared_ptr<const SkinImage>& image) {
    if (image == image_sent) return;
    if (image_map) gl.DeleteTextures(1, &image_map), image_map = 0;
    image_sent = image;
    if (!image) return;
    Texels t{image->width, image->height, {}};
    t.rgba.resize(4 * size_t(t.width) * size_t(t.height));
    for (size_t i = 0; i < t.rgba.size() / 4; ++i) {
      std::copy_n(image->rgb.begin() + std::ptrdiff_t(3 * i), 3, t.rgba.begin() + std::ptrdiff_t(4 * i));
      t.rgba[4 * i + 3] = 255;
    }
    image_map = make_texture(gl, t, true, true, true);
  }

  void upload(const RenderScene& s) {
    const bool other_mesh = uploaded != s.mesh || !held.any;
    held.any = true;
    if (other_mesh) {
      const TissueMesh& m = *s.mesh;
      std::vector<Eigen::Vector4f> rest(m.X_mm.size());
      for (size_t v = 0; v < rest.size(); ++v) rest[v] << m.X_mm[v], m.depth_mm[v];
      tissue_mesh.floats(3, 4, rest.data(), rest.size() * sizeof rest[0]);
      std::vector<Vec3f> chart_rim(m.X_mm.size());
      for (size_t v = 0; v < chart_rim.size(); ++v) chart_rim[v] << m.chart_mm[v], m.rim_mm[v];
      tissue_mesh.floats(4, 3, chart_rim.data(), chart_rim.size() * sizeof chart_rim[0]);
      if (!m.rgba.empty()) {
        std::vector<Eigen::Vector4f> rgba(m.rgba.size());
        for (size_t v = 0; v < rgba.size(); ++v) {
          for (int k = 0; k < 3; ++k) rgba[v][k] = root_of_light(m.rgba[v][size_t(k)]);
          rgba[v][3] = float(m.rgba[v][3]) / 255.0f;
        }
        tissue_mesh.floats(5, 4, rgba.data(), rgba.size() * sizeof rgba[0]);
      }
      if (!m.uv.empty()) tissue_mesh.floats(6, 2, m.uv.data(), m.uv.size() * sizeof m.uv[0]);
      if (!m.tension_twice.empty())
        tissue_mesh.floats(7, 2, m.tension_twice.data(), m.tension_twice.size() * sizeof m.tension_twice[0]);
      send_image(m.image);
      all_triangles = false;
      if (layer_map) gl.DeleteTextures(1, &layer_map);
      layer_map = make_texture(gl, layer_texture(m.layers, double(kLayerRange_mm)), true, false, false);
      uploaded = s.mesh;
    }
    if (other_mesh || !same(held.x_mm, s.x_mm)) {
      tissue_mesh.floats(0, 3, s.x_mm.data(), s.x_mm.size() * sizeof(Vec3f));
      tissue_mesh.floats(1, 3, s.normal.data(), s.normal.size() * sizeof(Vec3f));  // follow from the places
      held.x_mm = s.x_mm;
      cast.valid = false;
    }
    std::vector<float> none;
    const std::vector<float>& field = s.field.size() == s.x_mm.size() ? s.field : none;
    if (field.empty()) none.assign(s.x_mm.size(), 0.0f);
    if (other_mesh || !same(held.field, field)) {
      tissue_mesh.floats(2, 1, field.data(), field.size() * sizeof(float));
      held.field = field;
    }

    const auto& v = s.props.vertex;
    static_assert(sizeof(PropVertex) == 11 * sizeof(float), "compared byte by byte: nothing between the numbers");
    if (same(held.props.vertex, v) && same(held.props.tri, s.props.tri)) return;
    held.props = s.props;
    cast.valid = false;
    const size_t bytes = v.size() * sizeof(PropVertex), stride = sizeof(PropVertex);
    prop_mesh.floats(0, 3, v.data(), bytes, stride, offsetof(PropVertex, x_mm));
    prop_mesh.floats(1, 3, v.data(), bytes, stride, offsetof(PropVertex, normal));
    prop_mesh.floats(2, 4, v.data(), bytes, stride, offsetof(PropVertex, colour));
    prop_mesh.integers(3, GL_UNSIGNED_INT, v.data(), bytes, stride, offsetof(PropVertex, id));
    prop_mesh.triangles(s.props.tri);
  }

  void bind(int unit, GLuint texture) {
    gl.ActiveTexture(GL_TEXTURE0 + GLenum(unit));
    gl.BindTexture(GL_TEXTURE_2D, texture);
  }

  const ShadowMap& shadow_map(bool still) {
    std::unique_ptr<ShadowMap>& map = shadows[still ? 0 : 1];
    if (!map) map = std::make_unique<ShadowMap>(gl, still ? kShadowSize : kLiveShadowSize);
    return *map;
  }

  void want_all_triangles(const TissueMesh& m) {
    if (!all_triangles) tissue_mesh.triangles(m.tri);
    all_triangles = true;
  }

  // Skin, walls and sides close around the tissue: what of them is turned
  // away is never seen. Of a face or bones from a scan that is not sure.
  static bool closed(Part part) { return part == Part::skin || part == Part::wall || part == Part::side; }

  // The triangles of a view become those of the buffer; how many there are of each part.
  std::array<size_t, kParts> want_triangles_of(const RenderScene& s, const Mat4f& to_clip, int w, int h) {
    shown_triangles.clear();
    visible.look(s.x_mm, to_clip, w, h);
    std::array<size_t, kParts> count{};
    std::span<const std::array<uint32_t, 3>> rest(s.mesh->tri);
    for (const Part part : kTissueParts) {
      const auto all = rest.first(s.mesh->triangles_of[size_t(part)]);
      rest = rest.subspan(all.size());
      if (closed(part))
        count[size_t(part)] = visible.append(all, shown_triangles);
      else
        shown_triangles.insert(shown_triangles.end(), all.begin(), all.end()), count[size_t(part)] = all.size();
    }
    tissue_mesh.triangles(shown_triangles);
    all_triangles = false;
    return count;
  }

  void draw_tissue(size_t first, size_t count, bool cull) {
    if (cull) gl.Enable(GL_CULL_FACE), gl.CullFace(GL_BACK);
    tissue_mesh.draw(first, count);
    gl.Disable(GL_CULL_FACE);
  }

  Vec3f lamp() const { return uploaded ? uploaded->lamp : kLamp; }

  Mat4f cast_shadow(const RenderScene& s, bool on, bool still, FaceLook face) {
    if (!on) return Mat4f::Identity();
    const ShadowMap& shadow = shadow_map(still);
    if (cast.valid && cast.map == &shadow && cast.face == face) return cast.to_light;
    const Mat4f light = light_matrix(s, lamp());
    gl.BindFramebuffer(GL_FRAMEBUFFER, shadow.frame);
    gl.Viewport(0, 0, shadow.size, shadow.size);
    gl.Enable(GL_DEPTH_TEST);
    gl.Clear(GL_DEPTH_BUFFER_BIT);
    depth.use();
    depth.set("to_clip", light);
    gl.Enable(GL_POLYGON_OFFSET_FILL);
    gl.PolygonOffset(1.5f, 2.0f);
    const auto count = want_triangles_of(s, light, shadow.size, shadow.size);
    const size_t flesh = count[size_t(Part::skin)] + count[size_t(Part::wall)] + count[size_t(Part::side)];
    draw_tissue(0, flesh, true);
    draw_tissue(flesh, shown_triangles.size() - flesh - (face == FaceLook::solid ? 0 : count[size_t(Part::face)]),
                false);
    prop_mesh.draw();
    gl.Disable(GL_POLYGON_OFFSET_FILL);
    Mat4f half = Mat4f::Identity();
    half.diagonal().head<3>().setConstant(0.5f);
    half.block<3, 1>(0, 3).setConstant(0.5f);
    cast = {true, &shadow, face, half * light};
    return cast.to_light;
  }

  // The program for one part of the scene (tool: every prop) with the view's and the lamp's uniforms set.
  const GlProgram& shaded(Part part, const View& view, const DrawOptions& o, const Mat4f& to_light,
                          const Eigen::Vector2f& tension) {
    const bool field = o.colour_field && (part == Part::skin || part == Part::wall || part == Part::face);
    const bool clear = part == Part::face && o.face == FaceLook::clear;
    const bool by_place = o.tension_lines && part == Part::skin && !uploaded->tension_twice.empty();
    const bool lines = by_place || (o.tension_lines && part == Part::skin && tension != Eigen::Vector2f::Zero());
    const bool coloured = !uploaded->rgba.empty() && part != Part::bone_cut && part != Part::tool && !field,
               image = uploaded->image && part == uploaded->image_part && !field;
    const int key = int(part) * 512 + by_place * 256 + image * 128 + coloured * 64 + lines * 32 + o.still * 16 +
                    clear * 8 + o.shadow * 4 + o.fine_skin * 2 + field;
    auto it = programs.find(key);
    if (it == programs.end()) {
      std::string text = "#version 330 core\n";
      if (o.shadow) text += o.still ? "#define SHADOW 4\n" : "#define SHADOW 2\n";  // taps a side
      if (lines) text += "#define TENSION_LINES\n";
      if (by_place) text += "#define TENSION_BY_PLACE\n";
      if (o.fine_skin) text += "#define FINE\n";
      if (part == Part::wall) text += "#define PART_WALL\n";
      if (part == Part::bone_cut) text += "#define BONE_CUT\n";
      if (part == Part::face) text += "#define PART_FACE\n";
      if (clear) text += "#define CLEAR\n";
      if (coloured) text += "#define COLOURED\n";
      if (image) text += "#define IMAGE\n";
      const std::string head = text;
      text += shaders::lighting;
      if (part == Part::tool)
        text += shaders::prop_fragment;
      else
        text += std::string(shaders::tissue_common) + (field                ? shaders::field_fragment
                                                       : part == Part::skin ? shaders::skin_fragment
                                                       : part == Part::wall ? shaders::wall_fragment
                                                       : part == Part::face ? shaders::face_fragment
                                                       : part == Part::bone || part == Part::bone_cut
                                                           ? shaders::bone_fragment
                                                           : shaders::side_fragment);
      it = programs
               .emplace(key,
                        GlProgram(gl, part == Part::tool ? shaders::prop_vertex : head + shaders::tissue_vertex, text))
               .first;
    }
    const GlProgram& p = it->second;
    p.use();
    p.set("to_clip", Mat4f(view.projection * view.to_eye));
    p.set("eye", view.eye_mm);
    p.set("key_direction", lamp());
    p.set("to_light", to_light);
    p.set("shadow_map", 0);
    p.set("shadow_texel", 1.0f / float(o.still ? kShadowSize : kLiveShadowSize));
    if (part == Part::tool) {
      p.set("tool_tip", o.tool_tip_mm);
      p.set("clear_tool", o.clear_tool_mm);
      return p;
    }
    int unit = 1;
    for (const char* name : {"skin_map", "grid_map", "detail_map", "layer_map", "colour_map", "slope_map"})
      p.set(name, unit++);
    if (image) p.set("image_map", unit);
    p.set("layer_range", kLayerRange_mm);
    p.set("tension", tension.x(), tension.y());
    p.set("field_min", float(o.field_min));
    p.set("field_scale", float(1 / std::max(o.field_max - o.field_min, 1e-9)));
    p.set("iso_lines", float(o.iso_lines));
    return p;
  }

  // Twice: what tissue hides is faint.
  void paint_lines(const SceneLines& lines, const View& view) {
    if (lines.x_mm.empty()) return;
    line_mesh.floats(0, 3, lines.x_mm.data(), lines.x_mm.size() * sizeof(Vec3f));
    line_mesh.floats(1, 3, lines.colour.data(), lines.colour.size() * sizeof(Vec3f));
    gl.Enable(GL_BLEND);
    gl.BlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ZERO, GL_ONE);
    gl.DepthMask(GL_FALSE);
    line.use();
    line.set("to_clip", Mat4f(view.projection * view.to_eye));
    for (const bool hidden : {true, false}) {
      gl.DepthFunc(hidden ? GL_GREATER : GL_LEQUAL);
      line.set("alpha", hidden ? 0.30f : 0.95f);
      line_mesh.draw_lines(lines.x_mm.size());
    }
    gl.DepthFunc(GL_LESS);
    gl.DepthMask(GL_TRUE);
    gl.Disable(GL_BLEND);
  }

  void paint(const GlTarget& target, const RenderScene& s, const View& view, const DrawOptions& o,
             const Mat4f& to_light) {
    const int w = target.width(), h = target.height();
    const int x0 = int(std::lround(view.x0 * float(w))), x1 = int(std::lround(view.x1 * float(w)));
    const int y0 = int(std::lround(view.y0 * float(h))), y1 = int(std::lround(view.y1 * float(h)));
    gl.Viewport(x0, h - y1, x1 - x0, y1 - y0);
    gl.Enable(GL_DEPTH_TEST);
    if (o.wireframe) gl.PolygonMode(GL_FRONT_AND_BACK, GL_LINE);
    const Eigen::Vector2f tension = s.mesh->tension_chart;
    if (o.shadow) bind(0, shadow_map(o.still).texture);
    int unit = 1;
    for (const GLuint texture : {skin_map, grid_map, detail_map, layer_map, colour_map[size_t(o.scale)], slope_map}) {
      bind(unit++, texture);
      if (texture == skin_map || texture == grid_map)
        set_anisotropy(gl, anisotropic, o.fine_skin && o.still ? 4.0f : 1.0f);
    }
    std::array<size_t, kParts> triangles = s.mesh->triangles_of;
    if (o.wireframe)
      want_all_triangles(*s.mesh);
    else
      triangles = want_triangles_of(s, view.projection * view.to_eye, x1 - x0, y1 - y0);
    if (image_map) bind(unit, image_map);
    size_t first = 0;
    for (const Part part : kTissueParts) {
      const size_t count = triangles[size_t(part)];
      if (count > 0 && (part != Part::face || o.face == FaceLook::solid))
        shaded(part, view, o, to_light, tension), draw_tissue(first, count, !o.wireframe && closed(part));
      first += count;
    }
    const size_t all = first;
    if (o.wireframe) gl.PolygonMode(GL_FRONT_AND_BACK, GL_FILL);
    if (!s.props.tri.empty()) shaded(Part::tool, view, o, to_light, tension), prop_mesh.draw();

    // Behind everything, and only where nothing was drawn.
    gl.DepthFunc(GL_LEQUAL);
    background.use();
    background.set("top", unit_rgb(o.background_top));
    background.set("bottom", unit_rgb(o.background_bottom));
    empty.draw();
    gl.DepthFunc(GL_LESS);

    if (o.occlusion && !o.wireframe) {
      if (!occlusion) occlusion = std::make_unique<Occlusion>(gl);
      occlusion->darken(target, view, empty);
      gl.Viewport(x0, h - y1, x1 - x0, y1 - y0);
    }
    paint_lines(s.lines, view);
    if (const size_t count = triangles[size_t(Part::face)]; count > 0 && o.face == FaceLook::clear) {
      gl.Enable(GL_BLEND);
      gl.BlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ZERO, GL_ONE);
      gl.DepthMask(GL_FALSE);
      if (image_map) bind(unit, image_map);  // shading of corners may have made a texture of its own there
      shaded(Part::face, view, o, to_light, tension);
      tissue_mesh.draw(all - count, count);
      gl.DepthMask(GL_TRUE);
      gl.Disable(GL_BLEND);
    }
  }

  // Paints into `target`, made anew when it has another size.
  void paint_to(std::unique_ptr<GlTarget>& target, const RenderScene& s, std::span<const View> views,
                const DrawOptions& o, int w, int h) {
    context->make_current();
    if (o.width < 1 || o.height < 1 || w > largest || h > largest)
      throw RenderUnavailable("a picture of " + std::to_string(w) + " x " + std::to_string(h) +
                              " pixels cannot be drawn; expected at most " + std::to_string(largest) + " a side");
    const bool anew = !target || target->width() != w || target->height() != h;
    if (anew) target = std::make_unique<GlTarget>(gl, GL_RGBA8, w, h);
    upload(s);
    const Mat4f to_light = cast_shadow(s, o.shadow, o.still, o.face);
    target->bind();
    const float clear[4]{0, 0, 0, 1}, far_depth = 1;
    if (anew || !o.keep) gl.ClearBufferfv(GL_COLOR, 0, clear);
    gl.ClearBufferfv(GL_DEPTH, 0, &far_depth);
    for (const View& view : views) paint(*target, s, view, o, to_light);
    shown = target.get();
  }

  void paint_anaglyph(const RenderScene& s, const View& left, const View& right, const DrawOptions& o) {
    const int w = shrunk(o.width, o), h = shrunk(o.height, o);
    paint_to(eyes[0], s, std::span(&left, 1), o, w, h);
    paint_to(eyes[1], s, std::span(&right, 1), o, w, h);
    if (!picture || picture->width() != w || picture->height() != h)
      picture = std::make_unique<GlTarget>(gl, GL_RGBA8, w, h);
    shown = picture.get();
    if (!anaglyph) {
      anaglyph = std::make_unique<GlProgram>(gl, shaders::background_vertex,
                                             std::string("#version 330 core\n") + shaders::anaglyph_fragment);
      for (GLuint& t : eye_map) t = make_frame_texture(gl);
    }
    for (size_t eye = 0; eye < 2; ++eye) {
      eyes[eye]->bind();
      bind(int(eye), eye_map[eye]);
      gl.CopyTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, 0, 0, w, h, 0);
    }
    picture->bind();
    gl.Viewport(0, 0, w, h);
    gl.Disable(GL_DEPTH_TEST);
    anaglyph->use();
    anaglyph->set("left_eye", 0);
    anaglyph->set("right_eye", 1);
    empty.draw();
  }

  static int shrunk(int size, const DrawOptions& o) {
    return std::max(1, (size + o.shrink - 1) / std::max(1, o.shrink));
  }

  void compose(int w, int h) {
    context->make_current();
    if (!picture) return;
    if (!composed || composed->width() != w || composed->height() != h)
      composed = std::make_unique<GlTarget>(gl, GL_RGBA8, w, h);
    composed->bind();
    gl.BindFramebuffer(GL_READ_FRAMEBUFFER, picture->frame());
    gl.BlitFramebuffer(0, 0, picture->width(), picture->height(), 0, 0, w, h, GL_COLOR_BUFFER_BIT,
                       picture->width() == w && picture->height() == h ? GL_NEAREST : GL_LINEAR);
    composed->bind();
    shown = composed.get();
  }

  Image read() {
    context->make_current();
    if (!shown) return {};
    return image_of(gl, *shown);
  }

  void present(int w, int h) {
    context->make_current();
    if (!shown) return;
    shown->bind();
    gl.BindFramebuffer(GL_DRAW_FRAMEBUFFER, 0);
    gl.BlitFramebuffer(0, 0, shown->width(), shown->height(), 0, 0, w, h, GL_COLOR_BUFFER_BIT, GL_NEAREST);
    context->show();
  }

  Image draw(const RenderScene& s, std::span<const View> views, const DrawOptions& o) {
    const int ss = std::clamp(o.supersample, 1, 4);
    paint_to(picture, s, views, o, o.width * ss, o.height * ss);
    return shrink(read(), ss);
  }

  IdImage draw_ids(const RenderScene& s, const View& view, int w, int h) {
    context->make_current();
    if (w < 1 || h < 1 || w > largest || h > largest)
      throw RenderUnavailable("an id picture of this size cannot be drawn");
    if (!ids || ids->width() != w || ids->height() != h) ids = std::make_unique<GlTarget>(gl, GL_R32UI, w, h);
    upload(s);
    want_all_triangles(*s.mesh);
    ids->bind();
    gl.Viewport(0, 0, w, h);
    gl.Enable(GL_DEPTH_TEST);
    const GLuint nothing[4]{0, 0, 0, 0};
    const float far_depth = 1;
    gl.ClearBufferuiv(GL_COLOR, 0, nothing);
    gl.ClearBufferfv(GL_DEPTH, 0, &far_depth);
    id.use();
    id.set("to_clip", Mat4f(view.projection * view.to_eye));
    id.set("tissue", 1);
    tissue_mesh.draw();
    id.set("tissue", 0);
    prop_mesh.draw();
    std::vector<uint32_t> rows(size_t(w) * size_t(h));
    gl.PixelStorei(GL_PACK_ALIGNMENT, 1);
    gl.ReadPixels(0, 0, w, h, GL_RED_INTEGER, GL_UNSIGNED_INT, rows.data());
    IdImage out{w, h, std::vector<uint32_t>(rows.size())};
    const TissueMesh& m = *s.mesh;
    for (int y = 0; y < h; ++y)
      for (int x = 0; x < w; ++x) {
        uint32_t v = rows[size_t(h - 1 - y) * size_t(w) + size_t(x)];
        if (v & 0x80000000u) {
          const size_t t = v & 0x7fffffffu;
          v = uint32_t(m.part[m.tri[t][0]]) << 24 | uint32_t(m.tri_source[t]);
        }
        out.id[size_t(y) * size_t(w) + size_t(x)] = v;
      }
    return out;
  }
};

DrawOptions draw_options(const QualityLevel& level, int width, int height) {
  DrawOptions o;
  o.width = width, o.height = height;
  o.supersample = level.supersample;
  o.shadow = level.shadow, o.fine_skin = level.fine_skin, o.occlusion = level.occlusion, o.still = level.still;
  o.shrink = level.shrink;
  return o;
}

Renderer::Renderer(std::unique_ptr<GlContext> context) : impl_(std::make_unique<Impl>(std::move(context))) {}
Renderer::~Renderer() = default;
Renderer::Renderer(Renderer&&) noexcept = default;

Image Renderer::draw(const RenderScene& scene, const View& view, const DrawOptions& options) {
  return impl_->draw(scene, std::span(&view, 1), options);
}
Image Renderer::draw(const RenderScene& scene, std::span<const View> views, const DrawOptions& options) {
  return impl_->draw(scene, views, options);
}
void Renderer::paint(const RenderScene& scene, std::span<const View> views, const DrawOptions& options) {
  impl_->paint_to(impl_->picture, scene, views, options, Impl::shrunk(options.width, options),
                  Impl::shrunk(options.height, options));
}
void Renderer::paint_anaglyph(const RenderScene& scene, const View& left, const View& right,
                              const DrawOptions& options) {
  impl_->paint_anaglyph(scene, left, right, options);
}
void Renderer::compose(int width, int height) { impl_->compose(width, height); }
Image Renderer::read() { return impl_->read(); }
void Renderer::present(int width, int height) { impl_->present(width, height); }
const GlFunctions& Renderer::functions() const { return impl_->gl; }
IdImage Renderer::draw_ids(const RenderScene& scene, const View& view, int width, int height) {
  return impl_->draw_ids(scene, view, width, height);
}
std::string Renderer::describe() const {
  impl_->context->make_current();
  const auto text = [&](GLenum name) { return reinterpret_cast<const char*>(impl_->gl.GetString(name)); };
  return impl_->context->describe() + ": OpenGL " + text(GL_VERSION) + ", " + text(GL_RENDERER);
}

}  // namespace limberg
