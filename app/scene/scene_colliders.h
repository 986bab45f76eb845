#pragma once
// What the tissue lies against and what does not move:
//
//   [[collider]]  mesh = "teeth.obj"       a closed surface in the body's frame, beside the scene file
//                 scale_to_mm              mm per unit of the file (1)
//                 colour = [r, g, b]       sRGB, 0 to 1
//
// At most 16. Recordings hold their files, as they hold the body's.
#include "app/scene/scene.h"
#include "app/scene/toml_table.h"

namespace limberg {

/// [[collider]], after [body].
void read_colliders(const toml::table& root, const std::string& file, Scene& scene);

}  // namespace limberg
