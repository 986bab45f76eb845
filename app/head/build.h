#pragma once
// From a scene's [head] to what a Head is made of.
#include "app/scene/scene.h"
#include "sim/base/workers.h"
#include "sim/skull/head/head.h"

namespace limberg {

/// Makes the synthetic head (a second or two) or reads the meshes. Throws InputError: a file that cannot be read, a
/// bone's name or a landmark's that is not there.
HeadParts head_parts(const Scene& scene, Workers& workers);

}  // namespace limberg
