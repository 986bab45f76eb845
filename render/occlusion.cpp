#include "render/occlusion.h"

#include <algorithm>
#include <cmath>

#include "render/shaders.h"

namespace limberg {

namespace {

const char* const look_fragment = R"(#version 330 core
uniform sampler2D depth_map;
uniform vec2 corner, extent;   // of the view in the depth map, pixels
uniform vec3 lens;             // 1 / P00, 1 / P11, scale of a length at distance 1 in pixels
uniform vec2 shift;            // P02, P12
uniform vec2 to_z;             // P22, P23
uniform float reach;           // share of the distance
out vec4 hidden;

float distance_at(ivec2 p) { return to_z.y / (to_z.x + 2.0 * texelFetch(depth_map, p, 0).r - 1.0); }
vec3 place(vec2 p, float z) {
  vec2 ndc = (p - corner) / extent * 2.0 - 1.0;
  return vec3(z * (ndc + shift) * lens.xy, -z);
}

void main() {
  ivec2 here = ivec2(gl_FragCoord.xy) * 2, low = ivec2(corner), high = ivec2(corner + extent) - 1;
  here = clamp(here, low, high);
  float depth = texelFetch(depth_map, here, 0).r;
  float z = to_z.y / (to_z.x + 2.0 * depth - 1.0);
  vec2 at = vec2(here) + 0.5;
  vec3 p = place(at, z);
  float sum = 0.0;
  if (depth < 1.0) {
    // The tangent plane, from the nearer neighbour on each axis: an outline does not bend it.
    ivec2 l = max(here - ivec2(2, 0), low), r = min(here + ivec2(2, 0), high), d = max(here - ivec2(0, 2), low), u = min(here + ivec2(0, 2), high);
    float zl = distance_at(l), zr = distance_at(r), zd = distance_at(d), zu = distance_at(u);
    vec3 dx = abs(zr - z) < abs(zl - z) ? place(vec2(r) + 0.5, zr) - p : p - place(vec2(l) + 0.5, zl);
    vec3 dy = abs(zu - z) < abs(zd - z) ? place(vec2(u) + 0.5, zu) - p : p - place(vec2(d) + 0.5, zd);
    vec3 n = normalize(cross(dx, dy));
    float far = reach * z, pixels = clamp(far * lens.z / z, 3.0, 90.0);
    float turned = 1.5708 * float((int(gl_FragCoord.x) & 1) * 2 + (int(gl_FragCoord.y) & 1)) * 0.35;
    const int kTaps = 12;
    for (int i = 0; i < kTaps; ++i) {
      float a = 2.39996 * float(i) + turned, out_by = (float(i) + 0.5) / float(kTaps);
      ivec2 q = clamp(ivec2(at + pixels * out_by * vec2(cos(a), sin(a))), low, high);
      vec3 v = place(vec2(q) + 0.5, distance_at(q)) - p;
      float d2 = dot(v, v) + 1e-6;
      sum += max(dot(v, n) * inversesqrt(d2) - 0.08, 0.0) * max(1.0 - d2 / (far * far), 0.0);
    }
    sum = min(3.2 * sum / float(kTaps), 1.0);
  }
  float packed_z = clamp(z / 2048.0, 0.0, 0.9999) * 255.0;
  hidden = vec4(sum, floor(packed_z) / 255.0, fract(packed_z), 1.0);
}
)";

const char* const darken_fragment = R"(#version 330 core
uniform sampler2D depth_map, hidden_map;
uniform vec2 to_z;
uniform vec2 low, high;  // the view in the hidden map, pixels
out vec4 factor;
void main() {
  float depth = texelFetch(depth_map, ivec2(gl_FragCoord.xy), 0).r;
  if (depth >= 1.0) discard;
  float z = to_z.y / (to_z.x + 2.0 * depth - 1.0);
  vec2 at = gl_FragCoord.xy * 0.5 - 0.5;
  ivec2 base = ivec2(floor(at));
  vec2 f = at - vec2(base);
  float sum = 0.0, weight = 1e-4;
  for (int k = 0; k < 9; ++k) {
    ivec2 o = ivec2(k % 3, k / 3) - (ivec2(1) - ivec2(step(0.5, f)));
    vec4 h = texelFetch(hidden_map, clamp(base + o, ivec2(low), ivec2(high)), 0);
    float there = (floor(h.g * 255.0 + 0.5) + h.b) / 255.0 * 2048.0;
    vec2 away = abs(vec2(o) - f);
    float w = max(1.5 - away.x, 0.0) * max(1.5 - away.y, 0.0) * max(1.0 - abs(there - z) / (0.012 * z + 0.1), 0.003);
    sum += w * h.r, weight += w;
  }
  float open = 1.0 - sum / weight;
  // light that has gone through tissue is what is left
  factor = vec4(mix(vec3(0.50, 0.40, 0.38), vec3(1.0), open), 1.0);
}
)";

}  // namespace

Occlusion::Occlusion(const GlFunctions& gl)
    : gl_(gl),
      look_(gl, shaders::background_vertex, look_fragment),
      darken_(gl, shaders::background_vertex, darken_fragment) {}

void Occlusion::darken(const GlTarget& target, const View& view, const GlMesh& one_triangle) {
  const int w = target.width(), h = target.height(), hw = (w + 1) / 2, hh = (h + 1) / 2;
  if (!half_ || half_->width != hw || half_->height != hh) half_ = std::make_unique<GlLayer>(gl_, hw, hh);
  const int x0 = int(std::lround(view.x0 * float(w))), x1 = int(std::lround(view.x1 * float(w)));
  const int y0 = int(std::lround((1 - view.y1) * float(h))),
            y1 = int(std::lround((1 - view.y0) * float(h)));  // from below
  const Mat4f& P = view.projection;
  gl_.Disable(GL_DEPTH_TEST);
  gl_.ActiveTexture(GL_TEXTURE0);
  gl_.BindTexture(GL_TEXTURE_2D, target.depth());

  gl_.BindFramebuffer(GL_FRAMEBUFFER, half_->frame);
  const int u0 = x0 / 2, v0 = y0 / 2, u1 = (x1 + 1) / 2, v1 = (y1 + 1) / 2;
  gl_.Viewport(u0, v0, u1 - u0, v1 - v0);
  look_.use();
  look_.set("depth_map", 0);
  look_.set("corner", float(x0), float(y0));
  look_.set("extent", float(x1 - x0), float(y1 - y0));
  look_.set("lens", Vec3f(1 / P(0, 0), 1 / P(1, 1), 0.5f * P(1, 1) * float(y1 - y0)));
  look_.set("shift", P(0, 2), P(1, 2));
  look_.set("to_z", P(2, 2), P(2, 3));
  look_.set("reach", kReach);
  one_triangle.draw();

  target.bind_flat();
  gl_.Viewport(x0, y0, x1 - x0, y1 - y0);
  gl_.ActiveTexture(GL_TEXTURE1);
  gl_.BindTexture(GL_TEXTURE_2D, half_->texture);
  gl_.Enable(GL_BLEND);
  gl_.BlendFuncSeparate(GL_DST_COLOR, GL_ZERO, GL_ZERO, GL_ONE);
  darken_.use();
  darken_.set("depth_map", 0);
  darken_.set("hidden_map", 1);
  darken_.set("to_z", P(2, 2), P(2, 3));
  darken_.set("low", float(u0), float(v0));
  darken_.set("high", float(u1 - 1), float(v1 - 1));
  one_triangle.draw();
  gl_.Disable(GL_BLEND);
  target.bind();
  gl_.Enable(GL_DEPTH_TEST);
}

}  // namespace limberg
