#pragma once
// How far two pictures are apart, for tests. The mean over a picture hides a lost stitch; the worst block does not.
#include "render/image.h"

namespace limberg {

/// Largest difference of block means over all blocks of `block` pixels placed every block / 2, over the three channels,
/// in 0..255. Pictures of different size give 255. A harmless change of the rasteriser stays below 4.
double block_mean_difference(const Image& a, const Image& b, int block = 16);

}  // namespace limberg
