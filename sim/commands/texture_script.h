#pragma once
// Acts whose places are given by the texture of the skin, {"uv": [u, v]}, at the places in space where they lie on a
// body. A patient takes such acts as they are; whoever plans a hand's way or compares acts wants to know where.
#include <optional>
#include <string>

#include "sim/body/texture_places.h"
#include "sim/commands/script.h"

namespace limberg {

/// The same act at the places where its texture places lie. Nothing, and why, where the body does not have one, or has
/// it twice.
std::optional<InSpace> on_texture(InSpace act, const Body& body, std::string& reason);
/// Throws InputError (script.name, line) for a texture place that the body does not have, or has twice.
Script on_texture(Script script, const Body& body);
bool has_texture_places(const Script& script);

}  // namespace limberg
