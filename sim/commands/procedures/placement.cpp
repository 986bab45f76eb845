#include "sim/commands/procedures/placement.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "sim/base/elementary.h"
#include "sim/base/error.h"

namespace limberg {
namespace {

std::string text(const Vec2& p) { return fmt::format("({:.2f}, {:.2f}) mm", p.x(), p.y()); }

Vec3 unit_normal(const TriMesh& m, int t) {
  const Tri& c = m.tri[size_t(t)];
  return (m.X_mm[size_t(c[1])] - m.X_mm[size_t(c[0])]).cross(m.X_mm[size_t(c[2])] - m.X_mm[size_t(c[0])]).normalized();
}

bool is_skin(const TriMesh& m, int t) { return m.tag.empty() || m.tag[size_t(t)] == SurfaceTag::skin; }

}  // namespace

OnSkin::OnSkin(const Skin& skin, const Placement& placement) : skin_(skin), placement_(placement) {
  const Body& body = skin.body();
  const TriMesh& m = body.surface;
  const auto hit = skin.at(placement.origin);
  if (!hit)
    throw InputError(
        "placement", 0,
        "the point " + text(placement.origin) + " lies off the skin; expected a point on the skin of " + body.name);
  origin_ = {hit->X_mm, hit->normal, hit->triangle};
  const Vec3 n = unit_normal(m, hit->triangle);
  const double a = placement.turn_deg * std::numbers::pi / 180;
  const Vec3 ahead = elementary::cos(a) * body.chart_e1 + elementary::sin(a) * body.chart_e2;
  u_ = (ahead - ahead.dot(n) * n).normalized();
  v_ = n.cross(u_);
  std::map<std::pair<int32_t, int32_t>, std::pair<int32_t, int32_t>> half;  // directed edge -> triangle, edge
  for (int32_t t = 0; t < int32_t(m.tri.size()); ++t)
    if (is_skin(m, t))
      for (int32_t k = 0; k < 3; ++k)
        half[{m.tri[size_t(t)][size_t(k)], m.tri[size_t(t)][size_t((k + 1) % 3)]}] = {t, k};
  across_.assign(m.tri.size(), {-1, -1, -1});
  for (const auto& [edge, at] : half)
    if (const auto mate = half.find({edge.second, edge.first}); mate != half.end())
      across_[size_t(at.first)][size_t(at.second)] = mate->second.first;
}

OnSkin::Spot OnSkin::spot(const Vec2& figure_mm) const {
  const TriMesh& m = skin_.body().surface;
  const Vec2 p = placement_.mirrored ? Vec2(figure_mm.x(), -figure_mm.y()) : figure_mm;
  double left = p.norm();
  Spot s = origin_;
  if (left == 0) return s;
  Vec3 d = (p.x() * u_ + p.y() * v_) / left;
  int from = -1;  // the triangle just left, so that its edge is not crossed back
  for (size_t step = 0; step < 4 * m.tri.size(); ++step) {
    const Tri& c = m.tri[size_t(s.triangle)];
    const Vec3 n = unit_normal(m, s.triangle);
    double reach = std::numeric_limits<double>::infinity();
    int edge = -1;
    for (int k = 0; k < 3; ++k) {
      if (from >= 0 && across_[size_t(s.triangle)][size_t(k)] == from) continue;
      const Vec3& a = m.X_mm[size_t(c[size_t(k)])];
      const Vec3 out = (m.X_mm[size_t(c[size_t((k + 1) % 3)])] - a).normalized().cross(n);
      const double speed = d.dot(out);
      if (speed <= 1e-12) continue;
      const double t = std::max(0.0, (a - s.X_mm).dot(out) / speed);
      if (t < reach) reach = t, edge = k;
    }
    if (left <= reach) {
      s.X_mm += left * d;
      s.normal = n;
      return s;
    }
    const int next = edge < 0 ? -1 : across_[size_t(s.triangle)][size_t(edge)];
    if (next < 0)
      throw InputError("placement", 0,
                       "the figure's point " + text(figure_mm) +
                           " lies beyond the skin; expected a place with more skin around it, or a smaller figure");
    s.X_mm += reach * d;
    left -= reach;
    // Straight on: the same angle to the edge, in the next triangle's plane.
    const Vec3 e = (m.X_mm[size_t(c[size_t((edge + 1) % 3)])] - m.X_mm[size_t(c[size_t(edge)])]).normalized();
    const Vec3 into = e.cross(unit_normal(m, next));  // e runs with this triangle, against the next one
    const double along = d.dot(e);
    d = (along * e + std::sqrt(std::max(0.0, 1 - along * along)) * into).normalized();
    from = s.triangle;
    s.triangle = next;
  }
  throw InputError(
      "placement", 0,
      "the way to the figure's point " + text(figure_mm) + " does not end; expected a skin without folded triangles");
}

ChartPoint OnSkin::chart(const Vec2& figure_mm) const {
  const Spot s = spot(figure_mm);
  ChartPoint p = skin_.body().to_chart(s.X_mm);
  const auto hit = skin_.at(p);
  if (!hit || (hit->X_mm - s.X_mm).norm() > 0.05)
    throw InputError("placement", 0,
                     "the figure's point " + text(figure_mm) +
                         " is hidden from the chart's direction; expected a place that faces it");
  return p;
}

std::vector<ChartPoint> OnSkin::line(const Vec2& a, const Vec2& b, double within) const {
  std::vector<ChartPoint> out;
  follow(a, chart(a), b, chart(b), within, out);
  return out;
}

void OnSkin::follow(const Vec2& a, const ChartPoint& at_a, const Vec2& b, const ChartPoint& at_b, double within,
                    std::vector<ChartPoint>& out) const {
  const Vec2 e = at_b - at_a;
  bool strays = false;
  for (const double t : {0.5, 0.25, 0.75}) {
    if ((b - a).norm() < 2 || strays) break;
    const Vec2 p = a + t * (b - a);
    // Beside the line's nearest place; how fast it is run through does not matter.
    const double s = std::clamp((chart(p) - at_a).dot(e) / e.squaredNorm(), 0.0, 1.0);
    const auto there = skin_.at(at_a + s * e);
    strays = !there || (there->X_mm - spot(p).X_mm).norm() > within;
  }
  if (!strays) return out.push_back(at_b);
  const Vec2 middle = 0.5 * (a + b);
  const ChartPoint at_middle = chart(middle);
  follow(a, at_a, middle, at_middle, within, out);
  follow(middle, at_middle, b, at_b, within, out);
}

Vec3 OnSkin::above(const Vec2& figure_mm, double height_mm) const {
  const Spot s = spot(figure_mm);
  return s.X_mm + height_mm * s.normal;
}

}  // namespace limberg
