#include "render/board.h"

#include <cmath>

#include "render/gl_objects.h"

namespace limberg {

namespace {

const char* const kBoardVertex = R"(#version 330 core
uniform mat4 to_clip;
uniform vec3 centre, right, up;
out vec2 v_at;
void main() {
  vec2 side = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0 - 1.0;
  v_at = vec2(0.5 + 0.5 * side.x, 0.5 - 0.5 * side.y);
  gl_Position = to_clip * vec4(centre + side.x * right + side.y * up, 1.0);
}
)";

const char* const kBoardFragment = R"(#version 330 core
in vec2 v_at;
uniform sampler2D picture;
uniform vec3 dot_at;  // share of width, of height; width over height
out vec4 colour;
void main() {
  vec2 away = (v_at - dot_at.xy) * vec2(dot_at.z, 1.0);
  colour = length(away) < 0.012 ? vec4(1.0, 0.75, 0.2, 1.0) : vec4(texture(picture, v_at).rgb, 1.0);
}
)";

}  // namespace

bool BoardPlace::meets(const Vec3f& from_mm, const Vec3f& towards, float& u, float& v, float& way_mm) const {
  const Vec3f n = normal();
  const float slope = towards.dot(n), away = (from_mm - centre_mm).dot(n);
  if (!(slope < -1e-6f) || away < 0) return false;  // from behind, or along it
  way_mm = -away / slope;
  const Vec3f on = from_mm + way_mm * towards - centre_mm;
  u = 0.5f + 0.5f * on.dot(right_mm) / right_mm.squaredNorm();
  v = 0.5f - 0.5f * on.dot(up_mm) / up_mm.squaredNorm();
  return u >= 0 && u <= 1 && v >= 0 && v <= 1;
}

Board::Board(const GlFunctions& gl) : gl_(gl) {
  program_ = GlProgram(gl, kBoardVertex, kBoardFragment).id();
  gl_.GenVertexArrays(1, &array_);
  gl_.GenTextures(1, &texture_);
}

Board::~Board() {
  gl_.DeleteProgram(program_);
  gl_.DeleteVertexArrays(1, &array_);
  gl_.DeleteTextures(1, &texture_);
}

void Board::show(const Image& image) {
  gl_.ActiveTexture(GL_TEXTURE0);
  gl_.BindTexture(GL_TEXTURE_2D, texture_);
  gl_.PixelStorei(GL_UNPACK_ALIGNMENT, 1);
  width_ = image.width, height_ = image.height;
  gl_.TexImage2D(GL_TEXTURE_2D, 0, GL_RGB8, width_, height_, 0, GL_RGB, GL_UNSIGNED_BYTE, image.rgb.data());
  gl_.GenerateMipmap(GL_TEXTURE_2D);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
}

void Board::paint(const View& view, const BoardPlace& place, int width, int height, float u, float v) {
  if (empty()) return;
  gl_.Viewport(0, 0, width, height);
  gl_.Enable(GL_DEPTH_TEST);
  gl_.UseProgram(program_);
  const Mat4f clip = view.projection * view.to_eye;
  const auto at = [&](const char* name) { return gl_.GetUniformLocation(program_, name); };
  const auto set = [&](const char* name, const Vec3f& x) { gl_.Uniform3f(at(name), x.x(), x.y(), x.z()); };
  gl_.UniformMatrix4fv(at("to_clip"), 1, GL_FALSE, clip.data());
  set("centre", place.centre_mm), set("right", place.right_mm), set("up", place.up_mm);
  set("dot_at", u < 0 ? Vec3f(-9, -9, 1) : Vec3f(u, v, float(width_) / float(height_)));
  gl_.Uniform1i(at("picture"), 0);
  gl_.ActiveTexture(GL_TEXTURE0);
  gl_.BindTexture(GL_TEXTURE_2D, texture_);
  gl_.BindVertexArray(array_);
  gl_.DrawArrays(GL_TRIANGLE_STRIP, 0, 4);
}

TextureCopy::~TextureCopy() {
  for (const auto& [texture, frame] : frame_) gl_.DeleteFramebuffers(1, &frame);
}

void TextureCopy::copy(int from_width, int from_height, GLuint texture, int width, int height) {
  GLint bound = 0;
  gl_.GetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &bound);
  GLuint& frame = frame_[texture];
  if (frame == 0) {
    gl_.GenFramebuffers(1, &frame);
    gl_.BindFramebuffer(GL_DRAW_FRAMEBUFFER, frame);
    gl_.FramebufferTexture2D(GL_DRAW_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, texture, 0);
  }
  gl_.BindFramebuffer(GL_READ_FRAMEBUFFER, GLuint(bound));
  gl_.BindFramebuffer(GL_DRAW_FRAMEBUFFER, frame);
  gl_.BlitFramebuffer(0, 0, from_width, from_height, 0, 0, width, height, GL_COLOR_BUFFER_BIT,
                      from_width == width && from_height == height ? GL_NEAREST : GL_LINEAR);
  gl_.BindFramebuffer(GL_FRAMEBUFFER, GLuint(bound));
}

}  // namespace limberg
