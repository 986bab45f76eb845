#include "app/export/glb.h"

#include <cstdint>

#include "render/colour_map.h"
#include "sim/body/collider.h"

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

GltfLook look_of(const Collider& c) {
  const Vec3f rgb = linear_light(c.colour);
  return {c.name.c_str(), double(rgb.x()), double(rgb.y()), double(rgb.z()), .5};
}

}  // namespace limberg
