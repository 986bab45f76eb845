#include "render/gl_objects.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "render/colour_map.h"

namespace limberg {

namespace {

GLuint compile(const GlFunctions& gl, GLenum kind, const std::string& source) {
  const GLuint shader = gl.CreateShader(kind);
  const char* text = source.c_str();
  gl.ShaderSource(shader, 1, &text, nullptr);
  gl.CompileShader(shader);
  GLint good = 0;
  gl.GetShaderiv(shader, GL_COMPILE_STATUS, &good);
  if (!good) {
    std::array<char, 2048> log{};
    gl.GetShaderInfoLog(shader, GLsizei(log.size() - 1), nullptr, log.data());
    throw RenderUnavailable(std::string("the graphics driver refused a shader: ") + log.data());
  }
  return shader;
}

void check(const GlFunctions& gl, const char* what) {
  if (gl.CheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
    throw RenderUnavailable(std::string("the graphics driver cannot draw into ") + what);
}

}  // namespace

bool has_anisotropy(const GlFunctions& gl) {
  GLint n = 0;
  gl.GetIntegerv(GL_NUM_EXTENSIONS, &n);
  for (GLint i = 0; i < n; ++i)
    if (std::strcmp(reinterpret_cast<const char*>(gl.GetStringi(GL_EXTENSIONS, GLuint(i))),
                    "GL_EXT_texture_filter_anisotropic") == 0)
      return true;
  return false;
}

void set_anisotropy(const GlFunctions& gl, bool possible, float amount) {
  constexpr GLenum kMaxAnisotropy = 0x84FE;  // EXT_texture_filter_anisotropic
  if (possible) gl.TexParameterf(GL_TEXTURE_2D, kMaxAnisotropy, amount);
}

GlProgram::GlProgram(const GlFunctions& gl, const std::string& vertex, const std::string& fragment)
    : gl_(&gl), id_(gl.CreateProgram()) {
  const GLuint v = compile(gl, GL_VERTEX_SHADER, vertex), f = compile(gl, GL_FRAGMENT_SHADER, fragment);
  gl.AttachShader(id_, v);
  gl.AttachShader(id_, f);
  gl.LinkProgram(id_);
  gl.DeleteShader(v);
  gl.DeleteShader(f);
  GLint good = 0;
  gl.GetProgramiv(id_, GL_LINK_STATUS, &good);
  if (!good) {
    std::array<char, 2048> log{};
    gl.GetProgramInfoLog(id_, GLsizei(log.size() - 1), nullptr, log.data());
    throw RenderUnavailable(std::string("the graphics driver refused a program: ") + log.data());
  }
}

GlMesh::GlMesh(const GlFunctions& gl) : gl_(&gl) { gl.GenVertexArrays(1, &array_); }

GLuint GlMesh::buffer(GLuint attribute, const void* data, size_t bytes) {
  gl_->BindVertexArray(array_);
  if (!buffers_[attribute]) gl_->GenBuffers(1, &buffers_[attribute]);
  gl_->BindBuffer(GL_ARRAY_BUFFER, buffers_[attribute]);
  gl_->BufferData(GL_ARRAY_BUFFER, GLsizeiptr(bytes), data, GL_STREAM_DRAW);
  gl_->EnableVertexAttribArray(attribute);
  return buffers_[attribute];
}

void GlMesh::floats(GLuint attribute, int components, const void* data, size_t bytes, size_t stride, size_t offset) {
  buffer(attribute, data, bytes);
  gl_->VertexAttribPointer(attribute, components, GL_FLOAT, GL_FALSE, GLsizei(stride), reinterpret_cast<void*>(offset));
}

void GlMesh::integers(GLuint attribute, GLenum type, const void* data, size_t bytes, size_t stride, size_t offset) {
  buffer(attribute, data, bytes);
  gl_->VertexAttribIPointer(attribute, 1, type, GLsizei(stride), reinterpret_cast<void*>(offset));
}

void GlMesh::triangles(const std::vector<std::array<uint32_t, 3>>& tri) {
  gl_->BindVertexArray(array_);
  if (!index_) gl_->GenBuffers(1, &index_);
  gl_->BindBuffer(GL_ELEMENT_ARRAY_BUFFER, index_);
  gl_->BufferData(GL_ELEMENT_ARRAY_BUFFER, GLsizeiptr(tri.size() * sizeof tri[0]), tri.data(), GL_STREAM_DRAW);
  indices_ = GLsizei(3 * tri.size());
}

void GlMesh::draw(size_t first, size_t count) const {
  if (count == 0) return;
  gl_->BindVertexArray(array_);
  gl_->DrawElements(GL_TRIANGLES, GLsizei(3 * count), GL_UNSIGNED_INT,
                    reinterpret_cast<void*>(first * 3 * sizeof(uint32_t)));
}

void GlMesh::draw_lines(size_t ends) const {
  gl_->BindVertexArray(array_);
  gl_->DrawArrays(GL_LINES, 0, GLsizei(ends));
}

GlTarget::GlTarget(const GlFunctions& gl, GLenum colour_format, int width, int height)
    : gl_(&gl), width_(width), height_(height) {
  gl.GenFramebuffers(1, &frame_);
  gl.BindFramebuffer(GL_FRAMEBUFFER, frame_);
  gl.GenRenderbuffers(1, &colour_);
  gl.BindRenderbuffer(GL_RENDERBUFFER, colour_);
  gl.RenderbufferStorage(GL_RENDERBUFFER, colour_format, width, height);
  gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, colour_);
  depth_ = make_frame_texture(gl);
  gl.TexImage2D(GL_TEXTURE_2D, 0, GL_DEPTH_COMPONENT24, width, height, 0, GL_DEPTH_COMPONENT, GL_UNSIGNED_INT, nullptr);
  gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, depth_, 0);
  check(gl, "a picture of this size");
  gl.GenFramebuffers(1, &flat_);
  gl.BindFramebuffer(GL_FRAMEBUFFER, flat_);
  gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, colour_);
  check(gl, "a picture without its depth");
}

GlTarget::~GlTarget() {
  gl_->DeleteFramebuffers(1, &frame_);
  gl_->DeleteFramebuffers(1, &flat_);
  gl_->DeleteRenderbuffers(1, &colour_);
  gl_->DeleteTextures(1, &depth_);
}

Image image_of(const GlFunctions& gl, const GlTarget& target) {
  target.bind();
  Image image(target.width(), target.height());
  gl.PixelStorei(GL_PACK_ALIGNMENT, 1);
  std::vector<uint8_t> rows(image.rgb.size());
  gl.ReadPixels(0, 0, image.width, image.height, GL_RGB, GL_UNSIGNED_BYTE, rows.data());
  const size_t stride = 3 * size_t(image.width);
  for (int y = 0; y < image.height; ++y)
    std::memcpy(&image.rgb[stride * size_t(y)], &rows[stride * size_t(image.height - 1 - y)], stride);
  return image;
}

GlLayer::GlLayer(const GlFunctions& gl, int w, int h) : functions(gl), width(w), height(h) {
  texture = make_frame_texture(gl);
  gl.TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, w, h, 0, GL_RGBA, GL_UNSIGNED_BYTE, nullptr);
  gl.GenFramebuffers(1, &frame);
  gl.BindFramebuffer(GL_FRAMEBUFFER, frame);
  gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, texture, 0);
  check(gl, "a layer of a picture");
}

GlLayer::~GlLayer() {
  functions.DeleteFramebuffers(1, &frame);
  functions.DeleteTextures(1, &texture);
}

ShadowMap::ShadowMap(const GlFunctions& gl, int side) : size(side) {
  gl.GenTextures(1, &texture);
  gl.BindTexture(GL_TEXTURE_2D, texture);
  gl.TexImage2D(GL_TEXTURE_2D, 0, GL_DEPTH_COMPONENT24, side, side, 0, GL_DEPTH_COMPONENT, GL_UNSIGNED_INT, nullptr);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);
  gl.GenFramebuffers(1, &frame);
  gl.BindFramebuffer(GL_FRAMEBUFFER, frame);
  gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, texture, 0);
  gl.DrawBuffer(GL_NONE);
  gl.ReadBuffer(GL_NONE);
  check(gl, "a shadow map");
}

namespace {

/// sRGB to the root of linear light, both 0..255.
std::array<uint8_t, 256> root_table() {
  std::array<uint8_t, 256> table{};
  for (size_t i = 0; i < table.size(); ++i) {
    const double linear = linear_light(double(i) / 255);
    table[i] = uint8_t(std::lround(255 * std::sqrt(linear)));
  }
  return table;
}

}  // namespace

GLuint make_texture(const GlFunctions& gl, const Texels& texels, bool srgb, bool repeat, bool mipmaps) {
  std::vector<uint8_t> roots;
  if (srgb) {
    const std::array<uint8_t, 256> table = root_table();
    roots = texels.rgba;
    for (size_t i = 0; i < roots.size(); ++i)
      if (i % 4 != 3) roots[i] = table[roots[i]];
  }
  GLuint id = 0;
  gl.GenTextures(1, &id);
  gl.BindTexture(GL_TEXTURE_2D, id);
  gl.PixelStorei(GL_UNPACK_ALIGNMENT, 1);
  gl.TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, texels.width, texels.height, 0, GL_RGBA, GL_UNSIGNED_BYTE,
                srgb ? roots.data() : texels.rgba.data());
  const GLint wrap = repeat ? GL_REPEAT : GL_CLAMP_TO_EDGE;
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, wrap);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, wrap);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, mipmaps ? GL_LINEAR_MIPMAP_LINEAR : GL_LINEAR);
  if (mipmaps) gl.GenerateMipmap(GL_TEXTURE_2D);
  return id;
}

GLuint make_frame_texture(const GlFunctions& gl) {
  GLuint id = 0;
  gl.GenTextures(1, &id);
  gl.BindTexture(GL_TEXTURE_2D, id);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  return id;
}

}  // namespace limberg
