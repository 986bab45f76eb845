#include "app/export/glb.h"

#include <cmath>
#include <cstdint>

#include "render/colour_map.h"
#include "render/image.h"
#include "sim/body/collider.h"
#include "sim/body/skin_image.h"

namespace limberg {

std::string glb_bytes(std::string json, const std::string& binary) {
  while (json.size() % 4) json += ' ';
  std::string out;
  const auto word = [&](uint32_t v) { out.append(reinterpret_cast<const char*>(&v), 4); };
  word(0x46546C67), word(2), word(uint32_t(12 + 8 + json.size() + 8 + binary.size()));
  word(uint32_t(json.size())), word(0x4E4F534A), out += json;
  word(uint32_t(binary.size())), word(0x004E4942), out += binary;
  return out;
}

std::string png_of(const SkinImage& image) {
  Image out;
  out.width = image.width, out.height = image.height, out.rgb = image.rgb;
  return encode_png(out);
}

GltfLook look_of(const Collider& c) {
  const Vec3f rgb = c.rgb.empty() ? linear_light(c.colour) : Vec3f(Vec3f::Ones());  // else times each vertex's
  return {c.name.c_str(), double(rgb.x()), double(rgb.y()), double(rgb.z()), .5};
}

std::vector<std::array<uint8_t, 4>> colours_of(const Collider& c) {
  std::vector<std::array<uint8_t, 4>> out;
  for (const Vec3f& srgb : c.rgb) {
    const Vec3f l = 255 * linear_light(srgb);
    out.push_back({uint8_t(std::lround(l.x())), uint8_t(std::lround(l.y())), uint8_t(std::lround(l.z())), 255});
  }
  return out;
}

}  // namespace limberg
