#pragma once
// Places by the texture of the skin: where a picture of it was touched, or a peer's file names its vertices. They hold
// on every mesh that wears the same picture, however finely it is divided.
#include <optional>
#include <string>

#include "sim/body/body.h"

namespace limberg {

/// Where texture coordinates lie on the skin at rest, mm: (0, 0) is the picture's lower left corner, (1, 1) its
/// upper right one. Nothing, and why, where it has no texture coordinates, no triangle has these, or two places that
/// lie more than a hundredth of a millimetre apart have.
std::optional<Vec3> place_on_texture(const Body& body, const Eigen::Vector2d& uv, std::string& reason);

}  // namespace limberg
