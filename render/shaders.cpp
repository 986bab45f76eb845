#include "render/shaders.h"

namespace limberg::shaders {

const char* const lighting = R"(
uniform vec3 eye;            // world mm
uniform vec3 key_direction;  // unit, towards the light
uniform mat4 to_light;       // world -> shadow map, 0..1
uniform sampler2DShadow shadow_map;
uniform float shadow_texel;  // size of one texel

const vec3 key_colour = vec3(3.05, 2.93, 2.75);
const vec3 fill_colour = vec3(0.42, 0.48, 0.56);
const vec3 sky = vec3(0.68, 0.67, 0.66), ground = vec3(0.34, 0.28, 0.25);

// 1 in full light. SHADOW x SHADOW taps over about a millimetre: a lamp, not a point.
float lit(vec3 world, vec3 n) {
#ifndef SHADOW
  return 1.0;
#else
  vec4 p = to_light * vec4(world + 0.25 * n, 1.0);
  if (any(lessThan(p.xyz, vec3(0.0))) || any(greaterThan(p.xyz, vec3(1.0)))) return 1.0;
  float sum = 0.0;
  for (int i = 0; i < SHADOW * SHADOW; ++i) {
    vec2 o = (vec2(i % SHADOW, i / SHADOW) - 0.5 * float(SHADOW - 1)) * 2.2 * shadow_texel;
    sum += texture(shadow_map, vec3(p.xy + o, p.z - 0.0012));
  }
  return sum / float(SHADOW * SHADOW);
#endif
}

// Microfacet lobe of Trowbridge and Reitz with a fitted visibility term; times n.l.
float lobe(vec3 n, vec3 v, vec3 l, float roughness, float f0) {
  vec3 h = normalize(v + l);
  float nl = max(dot(n, l), 0.0), nv = max(dot(n, v), 0.05), nh = max(dot(n, h), 0.0), vh = max(dot(v, h), 0.0);
  float a2 = roughness * roughness * roughness * roughness;
  float d = nh * nh * (a2 - 1.0) + 1.0;
  float k = roughness * roughness * 0.5;
  float visible = 1.0 / ((nl * (1.0 - k) + k) * (nv * (1.0 - k) + k) * 4.0);
  float g = 1.0 - vh, g2 = g * g, fresnel = f0 + (1.0 - f0) * g2 * g2 * g;
  return a2 / (3.14159265 * d * d) * visible * fresnel * nl;
}

vec3 hemisphere(vec3 n) { return mix(ground, sky, 0.5 + 0.5 * n.z); }

// Linear light to the screen: a soft shoulder above 0.7, then the sRGB curve. The curve is fitted by roots, which are
// cheap on a processor: a x^1/2 + b x^1/4 + c x + d x^3/2, off by less than two of 255 levels.
vec3 to_screen(vec3 c) {
  vec3 over = max(c - 0.7, 0.0);
  c = clamp(min(c, vec3(0.7)) + 0.3 * over / (0.3 + over), 0.0, 1.0);
  vec3 r = sqrt(c);
  return 1.678 * r - 0.2027 * sqrt(r) - 0.7489 * c + 0.2736 * c * r;
}
)";

const char* const tissue_vertex = R"(
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in float field;
layout(location = 3) in vec4 rest_depth;
layout(location = 4) in vec3 chart_rim;
#ifdef COLOURED
layout(location = 5) in vec4 rgba;  // roots of linear light
out vec4 v_rgba;
#endif
#ifdef IMAGE
layout(location = 6) in vec2 uv;
out vec2 v_uv;
#endif
#ifdef TENSION_BY_PLACE
layout(location = 7) in vec2 tension_twice;
out vec2 v_tension;
#endif
uniform mat4 to_clip;
out vec3 v_world, v_normal, v_rest;
out vec2 v_chart;
out float v_depth, v_field, v_rim;
void main() {
  v_world = position, v_normal = normal, v_rest = rest_depth.xyz;
#ifdef COLOURED
  v_rgba = rgba;
#endif
#ifdef IMAGE
  v_uv = uv;
#endif
#ifdef TENSION_BY_PLACE
  v_tension = tension_twice;
#endif
  v_chart = chart_rim.xy, v_rim = chart_rim.z, v_depth = rest_depth.w, v_field = field;
  gl_Position = to_clip * vec4(position, 1.0);
}
)";

const char* const tissue_common = R"(
#ifdef COLOURED
in vec4 v_rgba;
#endif
#ifdef IMAGE
in vec2 v_uv;
uniform sampler2D image_map;  // roots of the albedo
#endif
in vec3 v_world, v_normal, v_rest;
in vec2 v_chart;
in float v_depth, v_field, v_rim;
uniform sampler2D skin_map;    // roots of the albedo, tile of 64 mm
uniform sampler2D grid_map;    // coverage of fine (r) and bold (g) lines, tile of 10 mm
uniform sampler2D detail_map;  // pores (r), lobules (g), mottle (b), number of the lobule (a)
uniform sampler2D slope_map;   // slopes of the pores (rg) and of the lobules (ba); textures.h
uniform sampler2D layer_map;   // roots of the albedo over depth, 0 .. layer_range mm
uniform sampler2D colour_map;
uniform float layer_range;
uniform float field_min, field_scale, iso_lines;
uniform vec2 tension;          // unit, along the tension lines on the chart
out vec4 colour;

#ifdef TENSION_BY_PLACE
in vec2 v_tension;  // cosine and sine of twice their angle on the chart
#endif

// Dashes every 4 mm across the tension lines: 1 on a dash.
float tension_line() {
#ifndef TENSION_LINES
  return 0.0;
#elif defined(TENSION_BY_PLACE)
  // One dash in the middle of every cell of a grid, its rows shifted by half a cell, along the lines there.
  if (dot(v_tension, v_tension) < 0.09) return 0.0;
  const vec2 cell = vec2(6.0, 3.6);
  float row = floor(v_chart.y / cell.y), shift = 0.5 * cell.x * mod(row, 2.0);
  vec2 at = vec2(mod(v_chart.x + shift, cell.x) - 0.5 * cell.x, v_chart.y - (row + 0.5) * cell.y);
  float half_turn = 0.5 * atan(v_tension.y, v_tension.x);
  vec2 along = vec2(cos(half_turn), sin(half_turn)), across = vec2(-along.y, along.x);
  vec2 right = dFdx(v_chart), up = dFdy(v_chart);
  float w = max(length(vec2(dot(across, right), dot(across, up))), 1e-6);  // mm a pixel, across and along
  float l = max(length(vec2(dot(along, right), dot(along, up))), 1e-6);
  float reach = min(2.1, 0.45 * min(cell.x / max(abs(along.x), 1e-3), cell.y / max(abs(along.y), 1e-3)));
  float s = abs(dot(at, across)) / w, end = (reach - abs(dot(at, along))) / l;
  // Where the skin stands upright on the chart a cell of it is long: no dashes there.
  float flat_on = abs(right.x * up.y - right.y * up.x) / max(length(cross(dFdx(v_rest), dFdy(v_rest))), 1e-9);
  return (1.0 - smoothstep(0.7, 1.5, s)) * clamp(end, 0.0, 1.0) * clamp(1.6 - w, 0.0, 1.0) * smoothstep(0.2, 0.4, flat_on);
#else
  float s = dot(v_chart, vec2(-tension.y, tension.x)) * 0.25, w = fwidth(s), row = floor(s + 0.5);
  float d = abs(s - row) / max(w, 1e-6), dash = fract(dot(v_chart, tension) / 7.0 + 0.37 * row);
  return (1.0 - smoothstep(0.7, 1.5, d)) * smoothstep(0.06, 0.12, dash) * (1.0 - smoothstep(0.66, 0.72, dash)) * clamp(1.6 - 4.0 * w, 0.0, 1.0);
#endif
}

// The normal towards the eye: interpolation may carry it past the horizon.
vec3 facing(vec3 v) {
  vec3 n = normalize(v_normal + 1e-9 * v);
  float away = min(dot(n, v), 0.0);
  return normalize(n - 1.02 * away * v);
}

// Tilts n by a height field on the surface, of which is known how it changes (mm) from pixel to pixel. Smooth over a
// triangle, where a difference of two pixels' heights would be one for four of them.
vec3 tilt(vec3 n, vec3 p, float hx, float hy) {
  vec3 px = dFdx(p), py = dFdy(p);
  vec3 rx = cross(py, n), ry = cross(n, px);
  float det = dot(px, rx);
  vec3 g = sign(det) * (hx * rx + hy * ry);
  return normalize(abs(det) * n - g + 1e-12 * n);
}

// Slopes of the two heights (mm for a height of 1) at a place of a tile that is `tile` mm wide: d/du, d/dv each.
vec4 slopes(vec2 at, float tile) { return (texture(slope_map, at / tile) - 0.5) * (512.0 / (4.0 * tile)); }

// The same over a solid: seen along each axis, as much as the surface faces it.
struct Solid { vec3 pores, lobules; };
Solid slopes_in(vec3 p, vec3 n, float tile) {
  vec3 w = n * n;
  w /= w.x + w.y + w.z + 1e-6;
  vec4 x = w.x * slopes(p.yz, tile), y = w.y * slopes(p.xz, tile), z = w.z * slopes(p.xy, tile);
  return Solid(vec3(y.x + z.x, x.x + z.y, x.y + y.y), vec3(y.z + z.z, x.z + z.w, x.w + y.w));
}

// What a moist or oily surface mirrors of the room, most where it is seen aslant.
vec3 sheen(vec3 n, vec3 v, float f0, float most) {
  float g = 1.0 - max(dot(n, v), 0.0), g2 = g * g;
  return hemisphere(reflect(-v, n)) * (f0 + (most - f0) * g2 * g2 * g);
}

// Light enters and leaves a little further on: the terminator is soft, and softest in red.
vec3 wrapped(float nl, vec3 wrap) { return clamp((vec3(nl) + wrap) / (1.0 + wrap), 0.0, 1.0); }
)";

const char* const skin_fragment = R"(
void main() {
  vec3 v = normalize(eye - v_world), n = facing(v), l = key_direction;
#ifdef IMAGE
  vec2 grid = vec2(0.0);  // a picture is landmark enough
  vec3 albedo = texture(image_map, vec2(v_uv.x, 1.0 - v_uv.y)).rgb;
#else
  vec2 grid = texture(grid_map, v_chart * 0.1).rg;
  vec3 albedo = texture(skin_map, v_chart * (1.0 / 64.0)).rgb;
#endif
  albedo *= albedo;
#ifdef COLOURED
  albedo = mix(albedo, v_rgba.rgb * v_rgba.rgb, v_rgba.a);  // a region beneath or in it
#endif
  vec3 ink = vec3(0.105, 0.07, 0.22);  // gentian violet, as on a marked patient
  albedo = mix(albedo, albedo * vec3(0.56, 0.45, 0.58), 0.44 * grid.r);
  albedo = mix(albedo, mix(ink, albedo, 0.16), 0.76 * grid.g);
  albedo = mix(albedo, vec3(0.0, 0.10, 0.13), 0.75 * tension_line());
  // Beside a cut the skin is flushed, and its very edge is dark.
  albedo *= mix(vec3(1.0), vec3(0.97, 0.76, 0.74), exp(-v_rim * 1.1) * step(v_rim, 2.99));
  albedo = mix(albedo, vec3(0.26, 0.035, 0.03), 0.85 * (1.0 - smoothstep(0.10, 0.26, v_rim)));
  float shade = lit(v_world, n);
  vec3 soft = n;  // light that has gone through the skin has forgotten the pores
#ifdef FINE
  // Lines and pores, and under them the unevenness of some millimetres that breaks up the shine.
  vec2 g = 0.026 * slopes(v_chart, 13.0).xy + 0.070 * slopes(v_chart.yx + 3.7, 71.0).yx;
  n = tilt(n, v_world, dot(g, dFdx(v_chart)), dot(g, dFdy(v_chart)));
  soft = normalize(soft + 0.8 * n);
#endif
  vec3 diffuse = wrapped(dot(soft, l), vec3(0.42, 0.22, 0.15));
  diffuse *= diffuse * 0.35 + 0.65;
  vec3 shadow = mix(vec3(0.16, 0.07, 0.05), vec3(1.0), vec3(shade));
  float fill = clamp(0.5 + 0.5 * dot(n, vec3(0.768, -0.329, 0.549)), 0.0, 1.0);
  vec3 light = key_colour * diffuse * shadow * 0.318 + fill_colour * fill * 0.30 + hemisphere(n) * 0.27;
  float s = lobe(n, v, l, 0.50, 0.030);
#ifdef FINE
  s = 0.75 * s + 0.25 * lobe(n, v, l, 0.33, 0.030);
#endif
  colour = vec4(to_screen(albedo * light + key_colour * (s * shade * 0.95) + 0.55 * sheen(n, v, 0.028, 0.45)), 1.0);
}
)";

const char* const wall_fragment = R"(
vec4 detail_on_wall(vec3 p, vec3 n, float scale) {
  vec3 w = n * n;
  w /= w.x + w.y + w.z + 1e-6;
  return w.x * texture(detail_map, p.yz * scale) + w.y * texture(detail_map, p.xz * scale) + w.z * texture(detail_map, p.xy * scale);
}

void main() {
  vec3 v = normalize(eye - v_world), n = facing(v), l = key_direction, smooth_n = n;
  float shade = lit(v_world, n);
  vec4 m = detail_on_wall(v_rest, n, 1.0 / 19.0);
  float ragged = (m.b - 0.5) * 0.35 + (m.r - 0.5) * 0.12;
  vec3 albedo = texture(layer_map, vec2((v_depth + ragged * smoothstep(0.15, 0.6, v_depth)) / layer_range, 0.5)).rgb;
  albedo *= albedo;
  float fat = smoothstep(1.4, 2.1, v_depth);
#ifdef COLOURED
  albedo = mix(albedo, v_rgba.rgb * v_rgba.rgb * (0.85 + 0.3 * m.b), v_rgba.a);
  fat *= 1.0 - v_rgba.a;  // whatever it is, it has no lobules
#endif
  // Lobules differ in tone; between them lie thin septa, paler and redder than fat.
  vec3 lobule = mix(vec3(0.95, 0.78, 0.70), vec3(1.0), smoothstep(0.15, 0.55, m.g)) * (0.93 + 0.14 * m.a);
  albedo *= mix(vec3(0.98 + 0.22 * (m.b - 0.5)), lobule, fat);
  // Blood: a film here and there, most of it between the lobules.
  float film = smoothstep(0.46, 0.80, m.b) * mix(1.0, 1.35 - 0.7 * m.g, fat);
#ifndef FINE
  film *= 0.45;  // without the lobules' relief it would be all that one sees
#endif
  albedo = mix(albedo, albedo * vec3(0.88, 0.30, 0.26), (0.05 + 0.58 * film) * smoothstep(0.2, 0.8, v_depth));
#ifdef FINE
  Solid s3 = slopes_in(v_rest, n, 19.0);
  vec3 g = mix(0.05 * s3.pores, 0.42 * s3.lobules + 0.012 * s3.pores, fat);
  n = tilt(n, v_world, dot(g, dFdx(v_rest)), dot(g, dFdy(v_rest)));
#endif
  vec3 diffuse = wrapped(dot(n, l), vec3(0.50, 0.30, 0.22));
  float cavity = mix(0.62, 1.0, exp(-v_depth / 3.2));  // the deeper, the less of the room is seen
  vec3 shadow = mix(vec3(0.34, 0.22, 0.17), vec3(1.0), vec3(shade));
  // A lamp on the surgeon's head looks into the wound where the room's light does not reach.
  float from_eye = max(dot(n, v), 0.0) * (1.0 - 0.75 * shade * max(dot(n, l), 0.0));
  vec3 light = key_colour * diffuse * shadow * 0.318 * mix(1.0, cavity, 0.35) +
               (hemisphere(n) * vec3(0.44, 0.36, 0.31) + vec3(0.72, 0.63, 0.55) * from_eye) * cavity;
  // What is dim is lit by its neighbours: warmer, never olive.
  float dim = clamp(1.0 - dot(light, vec3(0.42)), 0.0, 1.0);
  albedo = mix(albedo, albedo * vec3(1.05, 0.88, 0.76), dim * fat);
  float s = 0.6 * lobe(n, v, l, 0.30, 0.040) + 0.5 * lobe(smooth_n, v, l, 0.42, 0.040) + 0.30 * lobe(n, v, vec3(0.503, -0.503, 0.704), 0.30, 0.040);
  colour = vec4(to_screen(albedo * light + key_colour * (s * mix(0.25, 1.0, shade) * 0.75) + 0.6 * cavity * sheen(n, v, 0.035, 0.6)), 1.0);
}
)";

const char* const side_fragment = R"(
void main() {
  vec3 v = normalize(eye - v_world), n = facing(v);
  vec3 layer = texture(layer_map, vec2(v_depth / layer_range, 0.5)).rgb;
  layer *= layer;
#ifdef COLOURED
  layer = mix(layer, v_rgba.rgb * v_rgba.rgb, v_rgba.a);
#endif
  // The border of what is computed: the layers, as of a specimen that was cut off, paler than a wound.
  float grey = dot(layer, vec3(0.30, 0.59, 0.11));
  vec3 albedo = mix(vec3(0.50, 0.47, 0.44) * (0.45 + 0.75 * grey), layer, 0.50) * 0.85;
  float nl = max(dot(n, key_direction), 0.0);
  colour = vec4(to_screen(albedo * (key_colour * nl * mix(0.12, 1.0, lit(v_world, n)) * 0.318 + fill_colour * 0.18 + hemisphere(n) * 0.36)), 1.0);
}
)";

// Bone: dry and pale where it was not cut, marrow and fresh edges where it was.
const char* const bone_fragment = R"(
void main() {
  vec3 v = normalize(eye - v_world), n = facing(v), l = key_direction;
  vec3 w = n * n;
  w /= w.x + w.y + w.z + 1e-6;
  vec4 m = w.x * texture(detail_map, v_rest.yz / 53.0) + w.y * texture(detail_map, v_rest.xz / 53.0) + w.z * texture(detail_map, v_rest.xy / 53.0);
#ifdef BONE_CUT
  vec3 albedo = mix(vec3(0.55, 0.15, 0.10), vec3(0.80, 0.52, 0.38), smoothstep(0.25, 0.75, 0.6 * m.r + 0.5 * m.b));
#else
  // Ivory, with the stains of old blood and thin places, and small foramina.
  vec3 albedo = mix(vec3(0.79, 0.69, 0.52), vec3(0.89, 0.82, 0.69), smoothstep(0.15, 0.75, m.b));
  albedo *= 0.92 + 0.10 * m.r;
#ifdef COLOURED
  albedo = mix(albedo, v_rgba.rgb * v_rgba.rgb, v_rgba.a);
#endif
  // Where the saw went: a dark line, however close the pieces lie, and blood beside it.
  albedo *= mix(vec3(1.0), vec3(0.93, 0.66, 0.58), exp(-v_rim * 1.2) * step(v_rim, 2.99));
  albedo = mix(albedo, vec3(0.20, 0.05, 0.04), 0.85 * (1.0 - smoothstep(0.16, 0.42, v_rim)));
#endif
  float shade = lit(v_world, n);
  vec3 soft = n;
#ifdef FINE
  Solid s3 = slopes_in(v_rest, n, 53.0), s4 = slopes_in(v_rest.zxy, n.zxy, 17.0);
#ifdef BONE_CUT
  vec3 g = 0.55 * s3.pores + 0.10 * s4.pores.yzx;
#else
  vec3 g = 0.05 * s3.pores + 0.02 * s4.pores.yzx;  // nearly smooth: deeper pores make leather of it
#endif
  n = tilt(n, v_world, dot(g, dFdx(v_rest)), dot(g, dFdy(v_rest)));
#endif
  vec3 diffuse = wrapped(dot(n, l), vec3(0.18, 0.12, 0.08));
  float fill = clamp(0.5 + 0.5 * dot(n, vec3(0.768, 0.329, 0.549)), 0.0, 1.0);
  float from_eye = max(dot(soft, v), 0.0);
  vec3 light = key_colour * diffuse * mix(0.10, 1.0, shade) * 0.30 + fill_colour * fill * 0.26 + hemisphere(n) * 0.19 + vec3(0.13, 0.12, 0.11) * from_eye;
  // Thin edges let light through; hollows are lit by bone alone.
  float dim = clamp(1.0 - dot(light, vec3(0.45)), 0.0, 1.0);
  albedo = mix(albedo, albedo * vec3(1.05, 0.86, 0.70), dim);
  colour = vec4(to_screen(albedo * light + key_colour * (lobe(n, v, l, 0.46, 0.038) * shade * 0.6) + 0.35 * sheen(n, v, 0.03, 0.4)), 1.0);
}
)";

// The face over a skull; clear: what faces the eye lets it through, its outline does not.
const char* const face_fragment = R"(
void main() {
  vec3 v = normalize(eye - v_world), l = key_direction;
  float alpha = 1.0;
#ifdef CLEAR
  if (!gl_FrontFacing) discard;
#endif
  vec3 n = facing(v);
  vec3 w = n * n;
  w /= w.x + w.y + w.z + 1e-6;
  vec4 m = w.x * texture(detail_map, v_rest.yz / 83.0) + w.y * texture(detail_map, v_rest.xz / 83.0) + w.z * texture(detail_map, v_rest.xy / 83.0);
  vec3 albedo = mix(vec3(0.67, 0.40, 0.30), vec3(0.76, 0.50, 0.395), smoothstep(0.10, 0.85, m.b));
#ifdef IMAGE
  vec3 worn = texture(image_map, vec2(v_uv.x, 1.0 - v_uv.y)).rgb;  // v_rgba: how much of it
#elif defined(COLOURED)
  vec3 worn = v_rgba.rgb;
#endif
#ifdef COLOURED
  albedo = mix(albedo, worn * worn * (0.94 + 0.09 * m.b), v_rgba.a);
#endif
  albedo *= 0.95 + 0.08 * m.r;
  float shade = lit(v_world, n);
#ifdef CLEAR
  shade = 1.0;
  alpha = mix(0.22, 0.80, pow(1.0 - max(dot(n, v), 0.0), 2.5));
#endif
  vec3 soft = n;
#ifdef FINE
  Solid s3 = slopes_in(v_rest, n, 23.0), s4 = slopes_in(v_rest.zxy, n.zxy, 83.0);
  vec3 g = 0.040 * s3.pores + 0.07 * s4.pores.yzx;  // a head is seen from afar: coarser relief reads as leather
  n = tilt(n, v_world, dot(g, dFdx(v_rest)), dot(g, dFdy(v_rest)));
  soft = normalize(soft + 0.8 * n);
#endif
  vec3 diffuse = wrapped(dot(soft, l), vec3(0.42, 0.22, 0.15));
  diffuse *= diffuse * 0.35 + 0.65;
  vec3 shadow = mix(vec3(0.16, 0.07, 0.05), vec3(1.0), vec3(shade));
  float fill = clamp(0.5 + 0.5 * dot(n, vec3(0.768, 0.329, 0.549)), 0.0, 1.0);
  vec3 light = key_colour * diffuse * shadow * 0.318 + fill_colour * fill * 0.30 + hemisphere(n) * 0.27;
  float s = lobe(n, v, l, 0.50, 0.030);
#ifdef FINE
  s = 0.75 * s + 0.25 * lobe(n, v, l, 0.33, 0.030);
#endif
  colour = vec4(to_screen(albedo * light + key_colour * (s * shade * 0.9) + 0.45 * sheen(n, v, 0.028, 0.45)), alpha);
}
)";

// The colour map on the skin; walls stay grey so that a wound reads as one.
const char* const field_fragment = R"(
// sRGB to linear light: a cubic through both ends, off by at most 2.1 of 255 levels from a twenty-fifth up.
vec3 to_linear(vec3 c) { return c * (0.0360 + c * (0.6400 + c * 0.3240)); }

void main() {
  vec3 v = normalize(eye - v_world), n = facing(v);
#ifdef PART_WALL
  vec3 c = vec3(0.46, 0.42, 0.42) * mix(0.55, 1.0, exp(-v_depth / 3.0));
#else
  float t = (v_field - field_min) * field_scale;
  vec3 c = texture(colour_map, vec2((clamp(t, 0.0, 1.0) * 255.0 + 0.5) / 256.0, 0.5)).rgb;
  if (iso_lines > 0.0) {
    float s = t * iso_lines, w = fwidth(s);
    float d = abs(fract(s + 0.5) - 0.5) / max(w, 1e-6);
    float line = (1.0 - smoothstep(0.4, 1.2, d)) * clamp(1.6 - 4.0 * w, 0.0, 1.0) * step(0.5, s) * step(s, iso_lines - 0.5);
    c = mix(c, vec3(dot(c, vec3(0.3, 0.6, 0.1)) > 0.62 ? 0.0 : 1.0), 0.42 * line);  // on light colours dark lines
  }
#ifndef PART_FACE
  c = mix(c, vec3(0.0), 0.16 * texture(grid_map, v_chart * 0.1).g);
#endif
  c = mix(c, vec3(0.05), 0.75 * (1.0 - smoothstep(0.10, 0.26, v_rim)));
  c = mix(c, vec3(0.0), 0.6 * tension_line());
#endif
  float light = 0.62 + 0.30 * max(dot(n, key_direction), 0.0) * mix(0.45, 1.0, lit(v_world, n)) + 0.12 * max(dot(n, v), 0.0);
#ifdef CLEAR
  if (!gl_FrontFacing) discard;
  float alpha = 0.55;
#else
  float alpha = 1.0;
#endif
  colour = vec4(to_screen(to_linear(c) * light), alpha);
}
)";

const char* const prop_vertex = R"(#version 330 core
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec4 colour_metal;
layout(location = 3) in uint id;
uniform mat4 to_clip;
out vec3 v_world, v_normal, v_colour;
out float v_metal;
flat out uint v_part;
void main() {
  v_part = id >> 24;
  v_world = position, v_normal = normal, v_colour = colour_metal.rgb, v_metal = colour_metal.a;
  gl_Position = to_clip * vec4(position, 1.0);
}
)";

const char* const prop_fragment = R"(
in vec3 v_world, v_normal, v_colour;
in float v_metal;
flat in uint v_part;
uniform vec3 tool_tip;
uniform float clear_tool;  // mm above the tip; 0: solid
out vec4 colour;

// What steel reflects: a room with a bright ceiling lamp, a lighter wall and a dark floor.
vec3 room(vec3 d) {
  float up = d.z;
  vec3 c = mix(vec3(0.20, 0.21, 0.22), vec3(0.74, 0.79, 0.82), smoothstep(-0.45, 0.55, up));
  c += vec3(1.1) * smoothstep(0.72, 0.95, dot(d, key_direction));
  c *= 1.0 - 0.55 * exp(-36.0 * (up + 0.02) * (up + 0.02));  // the horizon's dark band
  return c;
}

void main() {
  // A tool that would hide what it works on: every other pixel, and further up three of four, are left out.
  if (v_part == 6u && clear_tool > 0.0) {
    float above = distance(v_world, tool_tip);
    ivec2 at = ivec2(gl_FragCoord.xy) & 1;
    if (above > clear_tool && (at.x ^ at.y) == 1) discard;
    if (above > 2.0 * clear_tool && at.x + at.y > 0) discard;
  }
  vec3 v = normalize(eye - v_world);
  vec3 n = normalize(v_normal + 1e-9 * v);
  if (dot(n, v) < 0.0) n = -n;
  float shade = lit(v_world, n), nl = max(dot(n, key_direction), 0.0);
  vec3 plain = v_colour * (key_colour * nl * shade * 0.318 + hemisphere(n) * 0.45 + fill_colour * 0.12) +
               key_colour * lobe(n, v, key_direction, 0.36, 0.05) * shade * 0.7 * (1.0 + min(v_metal, 0.0));
  vec3 f = v_colour + (1.0 - v_colour) * pow(1.0 - max(dot(n, v), 0.0), 5.0);
  vec3 steel = f * room(reflect(-v, n)) * mix(0.75, 1.0, shade) + key_colour * lobe(n, v, key_direction, 0.25, 0.5) * shade * 0.8;
  colour = vec4(to_screen(mix(plain, steel, max(v_metal, 0.0))), 1.0);
}
)";

const char* const background_vertex = R"(#version 330 core
out vec2 v_at;
void main() {
  v_at = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0;  // one triangle over the whole view
  gl_Position = vec4(v_at * 2.0 - 1.0, 1.0, 1.0);  // as far as can be
}
)";

const char* const background_fragment = R"(#version 330 core
in vec2 v_at;
uniform vec3 top, bottom;  // sRGB
out vec4 colour;
void main() {
  vec2 d = v_at - vec2(0.5, 0.55);
  float fall = clamp(1.15 - 1.1 * dot(d, d), 0.0, 1.0);
  vec3 c = mix(bottom, top, smoothstep(0.0, 1.0, v_at.y)) * mix(0.72, 1.0, fall);
  // Half a grey level of noise against banding.
  float noise = fract(52.9829189 * fract(dot(floor(gl_FragCoord.xy), vec2(0.06711056, 0.00583715))));
  colour = vec4(c + (noise - 0.5) / 255.0, 1.0);
}
)";

// Red-cyan by least squares (Dubois 2001): each eye's picture, in linear light, through the matrix fitted to its
// filter.
const char* const anaglyph_fragment = R"(
in vec2 v_at;
uniform sampler2D left_eye, right_eye;
out vec4 colour;
const mat3 left_filter = mat3(0.4561, -0.0400822, -0.0152161,   0.500484, -0.0378246, -0.0205971,   0.176381, -0.0157589, -0.00546856);
const mat3 right_filter = mat3(-0.0434706, 0.378476, -0.0721527,   -0.0879388, 0.73364, -0.112961,   -0.00155529, -0.0184503, 1.2264);
void main() {
  vec3 l = pow(texture(left_eye, v_at).rgb, vec3(2.2)), r = pow(texture(right_eye, v_at).rgb, vec3(2.2));
  colour = vec4(pow(clamp(left_filter * l + right_filter * r, 0.0, 1.0), vec3(1.0 / 2.2)), 1.0);
}
)";

const char* const line_vertex = R"(#version 330 core
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 rgb;
uniform mat4 to_clip;
out vec3 v_colour;
void main() {
  v_colour = rgb;
  gl_Position = to_clip * vec4(position, 1.0);
  gl_Position.z -= 0.0004 * gl_Position.w;  // before the surface that it lies on
}
)";

const char* const line_fragment = R"(#version 330 core
in vec3 v_colour;
uniform float alpha;
out vec4 colour;
void main() { colour = vec4(sqrt(v_colour), alpha); }
)";

const char* const depth_vertex = R"(#version 330 core
layout(location = 0) in vec3 position;
uniform mat4 to_clip;
void main() { gl_Position = to_clip * vec4(position, 1.0); }
)";

const char* const depth_fragment = R"(#version 330 core
void main() {}
)";

const char* const id_vertex = R"(#version 330 core
layout(location = 0) in vec3 position;
layout(location = 3) in uint id;  // props only
uniform mat4 to_clip;
flat out uint v_id;
void main() {
  v_id = id;
  gl_Position = to_clip * vec4(position, 1.0);
}
)";

const char* const id_fragment = R"(#version 330 core
flat in uint v_id;
uniform bool tissue;
out uint id;
void main() { id = tissue ? 0x80000000u | uint(gl_PrimitiveID) : v_id; }
)";

}  // namespace limberg::shaders
