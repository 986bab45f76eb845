#include "render/visible.h"

namespace limberg {

void VisibleTriangles::look(std::span<const Vec3f> x_mm, const Mat4f& to_clip, int width, int height) {
  pixels_ = double(width) * double(height);
  corner_.resize(x_mm.size());
  for (size_t v = 0; v < x_mm.size(); ++v) {
    const Eigen::Vector4f c = to_clip * x_mm[v].homogeneous();
    const float w = c.w() * 1.001f;  // a hair wider than the frame
    corner_[v] = {c.x(), c.y(), c.w(),
                  unsigned(c.x() < -w) | unsigned(c.x() > w) << 1 | unsigned(c.y() < -w) << 2 |
                      unsigned(c.y() > w) << 3 | unsigned(c.w() <= 0) << 4 | unsigned(c.z() < -w) << 5};
  }
}

size_t VisibleTriangles::append(std::span<const std::array<uint32_t, 3>> tri,
                                std::vector<std::array<uint32_t, 3>>& out) const {
  constexpr double kDoubtful_px2 = 0.1;
  constexpr unsigned kBehind = 1u << 4;
  const size_t before = out.size();
  for (const auto& t : tri) {
    const Corner &a = corner_[t[0]], &b = corner_[t[1]], &c = corner_[t[2]];
    if (a.outside & b.outside & c.outside) continue;
    if (!((a.outside | b.outside | c.outside) & kBehind)) {
      // The determinant of the corners (x, y, w) is twice the area
      // on the screen times the three w; the screen is 2 x 2.
      const double ax = double(a.x), ay = double(a.y), aw = double(a.w), bx = double(b.x), by = double(b.y),
                   bw = double(b.w), cx = double(c.x), cy = double(c.y), cw = double(c.w);
      const double det = ax * (by * cw - bw * cy) - ay * (bx * cw - bw * cx) + aw * (bx * cy - by * cx);
      if (det * pixels_ / 8 < -kDoubtful_px2 * aw * bw * cw) continue;
    }
    out.push_back(t);
  }
  return out.size() - before;
}

}  // namespace limberg
