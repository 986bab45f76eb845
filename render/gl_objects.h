#pragma once
// The few kinds of GL object that the renderer needs. They live as long as their context and are freed with it; only
// what is replaced while drawing (framebuffers of another size) is freed by hand.
#include <string>
#include <vector>

#include "render/gl_functions.h"
#include "render/image.h"
#include "render/textures.h"
#include "render/view.h"

namespace limberg {

/// A linked program and its uniforms by name. Uniforms that the compiler dropped are ignored.
class GlProgram {
 public:
  GlProgram(const GlFunctions& gl, const std::string& vertex, const std::string& fragment);
  void use() const { gl_->UseProgram(id_); }
  GLuint id() const { return id_; }
  void set(const char* name, float v) const { gl_->Uniform1f(at(name), v); }
  void set(const char* name, int v) const { gl_->Uniform1i(at(name), v); }
  void set(const char* name, float x, float y) const { gl_->Uniform2f(at(name), x, y); }
  void set(const char* name, const Vec3f& v) const { gl_->Uniform3f(at(name), v.x(), v.y(), v.z()); }
  void set(const char* name, const Mat4f& m) const { gl_->UniformMatrix4fv(at(name), 1, GL_FALSE, m.data()); }

 private:
  GLint at(const char* name) const { return gl_->GetUniformLocation(id_, name); }
  const GlFunctions* gl_;
  GLuint id_ = 0;
};

/// A vertex array with its buffers. Attribute data are whole arrays, one buffer each.
class GlMesh {
 public:
  explicit GlMesh(const GlFunctions& gl);
  void floats(GLuint attribute, int components, const void* data, size_t bytes, size_t stride = 0, size_t offset = 0);
  void integers(GLuint attribute, GLenum type, const void* data, size_t bytes, size_t stride = 0, size_t offset = 0);
  void triangles(const std::vector<std::array<uint32_t, 3>>& tri);
  void draw() const { draw(0, size_t(indices_) / 3); }
  void draw(size_t first, size_t count) const;  // triangles
  void draw_lines(size_t ends) const;           // two ends each, in their order

 private:
  GLuint buffer(GLuint attribute, const void* data, size_t bytes);
  const GlFunctions* gl_;
  GLuint array_ = 0, index_ = 0, buffers_[8]{};
  GLsizei indices_ = 0;
};

/// A framebuffer with a colour (RGBA8 or R32UI) and a depth attachment; the depth can be read as a texture.
class GlTarget {
 public:
  GlTarget(const GlFunctions& gl, GLenum colour_format, int width, int height);
  ~GlTarget();
  GlTarget(const GlTarget&) = delete;
  GlTarget& operator=(const GlTarget&) = delete;
  void bind() const { gl_->BindFramebuffer(GL_FRAMEBUFFER, frame_); }
  /// The colour alone, so that the depth may be read meanwhile.
  void bind_flat() const { gl_->BindFramebuffer(GL_FRAMEBUFFER, flat_); }
  GLuint depth() const { return depth_; }
  GLuint frame() const { return frame_; }
  int width() const { return width_; }
  int height() const { return height_; }

 private:
  const GlFunctions* gl_;
  GLuint frame_ = 0, flat_ = 0, colour_ = 0, depth_ = 0;
  int width_, height_;
};

/// What was drawn into an RGBA8 target, the top row first.
Image image_of(const GlFunctions& gl, const GlTarget& target);

/// A framebuffer whose only attachment is an RGBA8 texture, to be read without a filter.
struct GlLayer {
  GlLayer(const GlFunctions& gl, int width, int height);
  ~GlLayer();
  GlLayer(const GlLayer&) = delete;
  GlLayer& operator=(const GlLayer&) = delete;
  const GlFunctions& functions;
  GLuint frame = 0, texture = 0;
  int width, height;
};

/// A depth texture with comparison, and a framebuffer that fills it.
struct ShadowMap {
  ShadowMap(const GlFunctions& gl, int size);
  GLuint frame = 0, texture = 0;
  int size;
};

/// How much sharper a texture stays when seen aslant, where the driver can; 1 = plain. For the texture bound last.
void set_anisotropy(const GlFunctions& gl, bool possible, float amount);
bool has_anisotropy(const GlFunctions& gl);

/// Uploads a texture with mipmaps; `srgb`: the colours are sRGB, and what is read are the roots of linear light, for
/// the shader to square: software drivers read plain bytes several times faster than sRGB ones.
GLuint make_texture(const GlFunctions& gl, const Texels& texels, bool srgb, bool repeat, bool mipmaps);

/// An empty texture for a frame to be copied into: no mipmaps, no filter.
GLuint make_frame_texture(const GlFunctions& gl);

}  // namespace limberg
