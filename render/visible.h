#pragma once
// Which triangles of a closed surface may show in a picture: those in its frame that do
// not turn their back on it. A graphics card drops the others by itself; a software
// driver works on all their corners first, which is half of what a picture costs there.
#include <array>
#include <span>
#include <vector>

#include "render/view.h"

namespace limberg {

class VisibleTriangles {
 public:
  /// width, height: of the picture, pixels. to_clip: projection times view.
  void look(std::span<const Vec3f> x_mm, const Mat4f& to_clip, int width, int height);
  /// Appends those of `tri` that may show to `out`, in their order, and says how many they are. Counter-clockwise ones
  /// face the picture. What a driver's rounding may turn round (less than a tenth of a pixel) is kept.
  size_t append(std::span<const std::array<uint32_t, 3>> tri, std::vector<std::array<uint32_t, 3>>& out) const;

 private:
  struct Corner {
    float x, y, w;
    unsigned outside;  // bits: left, right, below, above, behind the eye, before the near plane
  };
  std::vector<Corner> corner_;
  double pixels_ = 0;  // of the picture
};

}  // namespace limberg
