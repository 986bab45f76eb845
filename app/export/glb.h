#pragma once
// The container of a binary glTF 2.0 file, and how its parts look: what the animated export (gltf.h) and the model of a
// page (page_model.h) have in common.
#include <array>
#include <nlohmann/json.hpp>
#include <string>

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

struct Collider;
/// How one looks; the name lasts as long as it does.
GltfLook look_of(const Collider& c);

nlohmann::ordered_json gltf_material(const GltfLook& look);

}  // namespace limberg
