#pragma once
// Acts whose places are given by the texture of the skin, {"uv": [u, v]}, at the places in space where they lie on a
// body. A patient takes such acts as they are; whoever plans a hand's way or compares acts wants to know where.
#include "sim/body/texture_places.h"
#include "sim/commands/script.h"

namespace limberg {

/// Throws InputError (script.name, line) for a texture place that the body does not have, or has twice.
Script on_texture(Script script, const Body& body);
bool has_texture_places(const Script& script);

}  // namespace limberg
