#pragma once
// A scene to begin with, for a closed surface of one's own.
//
// Which side is looked at is not in a mesh: the one of the six sides of its box that most of its surface faces. The
// chart's origin is the place there that faces it, as near to the middle as it can be; what faces the other way is
// held. Layers are those of the shipped face. All of it is meant to be changed.
#include <string>

#include "sim/body/body.h"

namespace limberg {

/// The scene's text. `mesh`: the surface's file, as the scene is to name it; `scale_to_mm`: what its numbers were
/// multiplied with for this body.
std::string first_scene(const Body& body, const std::string& mesh, double scale_to_mm = 1);

/// The [[layer]] sections of the shipped face, its skin so thick.
std::string layers_of_the_shipped_face(double skin_mm);

}  // namespace limberg
