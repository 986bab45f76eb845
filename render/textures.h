#pragma once
// Procedural textures: skin with pores and mottling, the millimetre grid, and the colours of the layers under the skin.
// All tiles repeat without a seam and depend on nothing but their size.
#include <cstdint>
#include <vector>

#include "render/colour_map.h"
#include "sim/body/body.h"

namespace limberg {

struct Texels {
  int width = 0, height = 0;
  std::vector<uint8_t> rgba;
};

/// Albedo of skin, sRGB, a tile of 64 mm.
Texels skin_texture(int size = 1024);

/// Lines of the grid as coverage: r = every millimetre, g = every centimetre; a tile of 10 mm, the bold lines on its
/// edges. The grid is the landmark by which one sees the skin stretch and turn.
Texels grid_texture(int size = 1024);

/// Heights and noise, linear: r pores, g fat lobules, b mottle, a number of the lobule.
Texels detail_texture(int size = 512);

/// Slopes of a detail texture's heights, along u and v: r and g of the pores, b and a of the lobules. A texel is 1/2 +
/// kSlopeGain x (change of the height from one texel to the next), so that smaller copies of it are the mean slope:
/// from afar the surface is smooth, and nothing flickers.
Texels slope_texture(const Texels& detail);
inline constexpr float kSlopeGain = 4;

/// Albedo, sRGB, from the skin (left) to `range_mm` deep (right): a thin epidermis, pale dermis, yellow fat, red below.
Texels layer_texture(const std::vector<Layer>& layers, double range_mm, int size = 512);

/// A colour map's 256 colours, side by side.
Texels scale_texture(ColourScale scale);

}  // namespace limberg
