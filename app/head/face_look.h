#pragma once
// How the face of a head looks: the surface that [head] face_texture names, in the head's frame.
#include <memory>

#include "app/scene/scene.h"
#include "sim/skull/head/face_texture.h"

namespace limberg {

/// Null where the scene names none. `axes`: of the file of the face. InputError: a file that cannot be read, a surface
/// with neither a picture by texture coordinates nor colours, or a picture where the scene's body wears one already.
std::shared_ptr<const FaceTexture> face_look(const Scene& scene, simplex::Axes axes);

}  // namespace limberg
