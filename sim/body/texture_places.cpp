#include "sim/body/texture_places.h"

#include <fmt/format.h>

#include <algorithm>

namespace limberg {
namespace {

constexpr double kSame_mm = 0.01;
constexpr double kEdge = 1e-5;  // of a triangle: texture coordinates are single precision

}  // namespace

std::optional<Vec3> place_on_texture(const Body& body, const Eigen::Vector2d& uv, std::string& reason) {
  const TriMesh& m = body.surface;
  if (m.uv.size() != m.tri.size()) {
    reason = "the skin of this scene has no texture coordinates; a place [x, y] or [x, y, z] was expected";
    return std::nullopt;
  }
  std::optional<Vec3> found;
  double best = -1;  // the least share of a corner: how far within its triangle
  for (size_t t = 0; t < m.tri.size(); ++t) {
    if (!m.tag.empty() && m.tag[t] != SurfaceTag::skin) continue;  // what lies beneath may wear the picture, too
    const Eigen::Vector2d a = m.uv[t][0].cast<double>(), b = m.uv[t][1].cast<double>() - a,
                          c = m.uv[t][2].cast<double>() - a, p = uv - a;
    const double area2 = b.x() * c.y() - b.y() * c.x();
    if (!(std::abs(area2) > 0)) continue;
    const double v = (p.x() * c.y() - p.y() * c.x()) / area2, w = (b.x() * p.y() - b.y() * p.x()) / area2;
    const double least = std::min({1 - v - w, v, w});
    if (!(least >= -kEdge)) continue;
    const Vec3 X =
        (1 - v - w) * m.X_mm[size_t(m.tri[t][0])] + v * m.X_mm[size_t(m.tri[t][1])] + w * m.X_mm[size_t(m.tri[t][2])];
    if (found && (X - *found).norm() > kSame_mm && least > 0 && best > 0) {
      reason = fmt::format(
          "the skin has the texture coordinates ({:.4f}, {:.4f}) at two places, {:.2f} mm apart; one was "
          "expected",
          uv.x(), uv.y(), (X - *found).norm());
      return std::nullopt;
    }
    if (!found || least > best) found = X, best = least;
  }
  if (!found)
    reason = fmt::format(
        "the skin has the texture coordinates ({:.4f}, {:.4f}) nowhere; those of one of its triangles "
        "were expected",
        uv.x(), uv.y());
  return found;
}

}  // namespace limberg
