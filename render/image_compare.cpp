#include "render/image_compare.h"

#include <algorithm>
#include <cmath>

namespace limberg {

double block_mean_difference(const Image& a, const Image& b, int block) {
  if (a.width != b.width || a.height != b.height) return 255;
  double worst = 0;
  const int step = std::max(1, block / 2);
  for (int y0 = 0; y0 < a.height; y0 += step)
    for (int x0 = 0; x0 < a.width; x0 += step) {
      const int x1 = std::min(x0 + block, a.width), y1 = std::min(y0 + block, a.height);
      int64_t sum[3]{};
      for (int y = y0; y < y1; ++y) {
        const size_t row = size_t(y) * size_t(a.width);
        for (int x = x0; x < x1; ++x)
          for (size_t c = 0; c < 3; ++c) {
            const size_t i = 3 * (row + size_t(x)) + c;
            sum[c] += int(a.rgb[i]) - int(b.rgb[i]);
          }
      }
      const double n = double(x1 - x0) * double(y1 - y0);
      for (const int64_t s : sum) worst = std::max(worst, std::abs(double(s)) / n);
    }
  return worst;
}

}  // namespace limberg
