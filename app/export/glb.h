#pragma once
// The container of a binary glTF 2.0 file, and how its parts look: what the animated export (gltf.h) and the model of a
// page (page_model.h) have in common.
#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace limberg {

/// JSON and binary chunk as one .glb. `json` is one object; `binary` is what its one buffer holds.
std::string glb_bytes(std::string json, const std::string& binary);

struct GltfLook {
  const char* name;
  double r, g, b;  // linear light
  double rough;
};
enum GltfMaterial : int {
  kSkinLook,
  kWoundLook,
  kSideLook,
  kFaceLook,
  kBoneLook,
  kCutBoneLook,
  kThreadLook,
  kHookLook
};
inline constexpr std::array<GltfLook, 8> kGltfLooks{{{"skin", .80, .55, .45, .6},
                                                     {"wound", .55, .08, .07, .4},
                                                     {"side", .85, .70, .45, .8},
                                                     {"face", .80, .58, .48, .6},
                                                     {"bone", .89, .85, .72, .7},
                                                     {"cut bone", .75, .45, .36, .7},
                                                     {"thread", .10, .14, .45, .5},
                                                     {"hook", .55, .56, .60, .3}}};

struct SkinImage;
/// The picture on the skin as a PNG file; empty: it has no pixels.
std::string png_of(const SkinImage& image);
/// Texture coordinates of glTF: from above. `uv`: as the patient has them, from below (sim/body/skin_image.h).
inline std::array<float, 2> from_above(float u, float v) { return {u, 1 - v}; }

struct Collider;
/// How one looks; the name lasts as long as it does.
GltfLook look_of(const Collider& c);
/// Of each vertex in linear light, 0 to 255, opaque (COLOR_0); empty: all of it looks as look_of says.
std::vector<std::array<uint8_t, 4>> colours_of(const Collider& c);

/// Of one of the `materials`. Json: as its writer has it, so that no header includes a library of JSON.
template <class Json>
Json gltf_material(const GltfLook& l) {
  return {{"name", l.name},
          {"pbrMetallicRoughness",
           {{"baseColorFactor", {l.r, l.g, l.b, 1.0}}, {"metallicFactor", 0}, {"roughnessFactor", l.rough}}},
          {"doubleSided", true}};
}

/// One material of a file whose materials are there looks as the PNG in its buffer view `view`, by the texture
/// coordinates of the set of that number.
template <class Json>
void put_on(Json& file, GltfMaterial wears, int view, int set) {
  file["images"] = Json::array({{{"bufferView", view}, {"mimeType", "image/png"}}});
  file["textures"] = Json::array({{{"source", 0}}});
  Json& skin = file["materials"][wears]["pbrMetallicRoughness"];
  skin["baseColorFactor"] = {1, 1, 1, 1};
  skin["baseColorTexture"] = {{"index", 0}, {"texCoord", set}};
}

}  // namespace limberg
