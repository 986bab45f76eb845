#pragma once
// A picture on the skin of a body.
#include <cstdint>
#include <vector>

namespace limberg {

/// Rows from the top down, three bytes a pixel, sRGB. A triangle's texture coordinates are parts of its width from the
/// left and of its height from below.
struct SkinImage {
  int width = 0, height = 0;
  std::vector<uint8_t> rgb;
};

}  // namespace limberg
