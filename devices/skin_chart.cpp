#include "devices/skin_chart.h"

#include <algorithm>
#include <cmath>

#include "sim/geometry/triangle.h"

namespace limberg {

namespace {
constexpr int kMaxCells = 512;  // along each side of the grid
}

int SkinChart::cell_x(double x) const {
  return std::clamp(int(std::floor((x - grid_min_.x()) / cell_mm_)), 0, nx_ - 1);
}
int SkinChart::cell_y(double y) const {
  return std::clamp(int(std::floor((y - grid_min_.y()) / cell_mm_)), 0, ny_ - 1);
}

void SkinChart::build(const SurfaceTopology& topology) {
  const SurfaceView& view = topology.view;
  const GroundIndex& skin = topology.index(Ground::skin);
  built_ = true;
  version_ = topology.version;
  std::vector<Vec2> chart(view.X_mm.size(), Vec2::Zero());
  Vec2 low(1e30, 1e30), high(-1e30, -1e30);
  for (int32_t v : skin.vertex) {
    chart[size_t(v)] = topology.to_chart(view.X_mm[size_t(v)]);
    low = low.cwiseMin(chart[size_t(v)]);
    high = high.cwiseMax(chart[size_t(v)]);
  }
  nx_ = ny_ = 0;
  if (skin.vertex.empty()) return;
  grid_min_ = low;
  cell_mm_ = std::max(2.0, (high - low).maxCoeff() / kMaxCells);
  nx_ = std::max(1, int(std::ceil((high.x() - low.x()) / cell_mm_)));
  ny_ = std::max(1, int(std::ceil((high.y() - low.y()) / cell_mm_)));
  auto each_cell = [&](int32_t t, auto&& visit) {
    const Tri& k = view.tri[size_t(t)];
    const Vec2 &a = chart[size_t(k[0])], &b = chart[size_t(k[1])], &c = chart[size_t(k[2])];
    const Vec2 lo = a.cwiseMin(b).cwiseMin(c), hi = a.cwiseMax(b).cwiseMax(c);
    for (int y = cell_y(lo.y()); y <= cell_y(hi.y()); ++y)
      for (int x = cell_x(lo.x()); x <= cell_x(hi.x()); ++x) visit(size_t(y * nx_ + x));
  };
  cell_start_.assign(size_t(nx_ * ny_) + 1, 0);
  for (int32_t t : skin.triangle) each_cell(t, [&](size_t cell) { ++cell_start_[cell + 1]; });
  for (size_t i = 0; i + 1 < cell_start_.size(); ++i) cell_start_[i + 1] += cell_start_[i];
  cell_tri_.resize(size_t(cell_start_.back()));
  std::vector<int32_t> fill(cell_start_.begin(), cell_start_.end() - 1);
  for (int32_t t : skin.triangle) each_cell(t, [&](size_t cell) { cell_tri_[size_t(fill[cell]++)] = t; });
}

SkinTouch SkinChart::at(const Snapshot& s, const ChartPoint& c, double slack_mm) const {
  if (nx_ == 0 || !c.allFinite() || !s.topology->body) return {};
  const SurfaceView& view = s.topology->view;
  const Body& body = *s.topology->body;
  const Vec3 up = body.chart_normal();
  struct {
    int32_t triangle = -1;
    std::array<double, 3> bary{1, 0, 0};
    double distance2 = 1e60;
  } best;
  double best_height = -1e30;
  const int x0 = cell_x(c.x() - slack_mm), x1 = cell_x(c.x() + slack_mm), y0 = cell_y(c.y() - slack_mm),
            y1 = cell_y(c.y() + slack_mm);
  for (int y = y0; y <= y1; ++y) {
    for (int x = x0; x <= x1; ++x) {
      const size_t cell = size_t(y * nx_ + x);
      for (int32_t i = cell_start_[cell]; i < cell_start_[cell + 1]; ++i) {
        const int32_t t = cell_tri_[size_t(i)];
        const Tri& k = view.tri[size_t(t)];
        const std::array<Vec2, 3> q{body.to_chart(view.X_mm[size_t(k[0])]), body.to_chart(view.X_mm[size_t(k[1])]),
                                    body.to_chart(view.X_mm[size_t(k[2])])};
        if (cross2(q[1] - q[0], q[2] - q[0]) <= 0) continue;  // edge-on, or facing away from the chart
        auto flat = [](const Vec2& v) { return Vec3(v.x(), v.y(), 0); };
        const TrianglePoint p = closest_on_triangle(flat(c), flat(q[0]), flat(q[1]), flat(q[2]));
        const double d2 = (p.point - flat(c)).squaredNorm();
        constexpr double kOn2 = 1e-14;  // (1e-7 mm)^2: on the triangle but for rounding
        const bool on = d2 <= kOn2;
        if (!on && d2 > slack_mm * slack_mm) continue;
        double height = 0;
        for (size_t j = 0; j < 3; ++j) height += p.bary[j] * view.X_mm[size_t(k[j])].dot(up);
        const bool best_on = best.distance2 <= kOn2;
        const bool better =
            on ? !best_on || height > best_height + 1e-9 || (height > best_height - 1e-9 && t < best.triangle)
               : !best_on && (d2 < best.distance2 || (d2 == best.distance2 && t < best.triangle));
        if (better) best = {t, p.bary, d2}, best_height = height;
      }
    }
  }
  return touch_at(s, best.triangle, best.bary, std::sqrt(best.distance2));
}

SkinTouch SkinChart::at_rest(const Snapshot& s, const Vec3& X, double reach_mm) {
  return at_rest(s, X, reach_mm, s.topology->index(Ground::skin).triangle);
}

SkinTouch SkinChart::at_rest(const Snapshot& s, const Vec3& X, double reach_mm, std::span<const int32_t> triangles,
                             const Vec3* out) {
  const SurfaceView& v = s.topology->view;
  int32_t triangle = -1;
  std::array<double, 3> bary{1, 0, 0};
  double best = reach_mm * reach_mm;
  for (const int32_t t : triangles) {
    const Tri& k = v.tri[size_t(t)];
    const Vec3 &a = v.X_mm[size_t(k[0])], &b = v.X_mm[size_t(k[1])], &c = v.X_mm[size_t(k[2])];
    const TrianglePoint p = closest_on_triangle(X, a, b, c);
    const double d2 = (p.point - X).squaredNorm();
    if (d2 < best && (!out || (b - a).cross(c - a).dot(*out) > 0)) best = d2, triangle = t, bary = p.bary;
  }
  return touch_at(s, triangle, bary, std::sqrt(best));
}

SkinTouch SkinChart::on_line_at_rest(const Snapshot& s, const Vec3& X, const Vec3& out, double reach_mm) {
  const SurfaceView& v = s.topology->view;
  const Vec3 n = out.normalized(), e1 = n.unitOrthogonal(), e2 = n.cross(e1);
  int32_t triangle = -1;
  std::array<double, 3> bary{1, 0, 0};
  double best = reach_mm;
  for (const int32_t t : s.topology->index(Ground::skin).triangle) {
    const Tri& k = v.tri[size_t(t)];
    Vec3 corner[3];
    Vec2 across[3];
    for (size_t i = 0; i < 3; ++i)
      corner[i] = v.X_mm[size_t(k[i])] - X, across[i] = Vec2(corner[i].dot(e1), corner[i].dot(e2));
    double area[3], sum = 0;
    for (size_t i = 0; i < 3; ++i) sum += area[i] = cross2(across[(i + 1) % 3], across[(i + 2) % 3]);
    if (!(sum > 0) || area[0] < 0 || area[1] < 0 || area[2] < 0) continue;
    double along = 0;
    for (size_t i = 0; i < 3; ++i) along += area[i] / sum * corner[i].dot(n);
    if (std::abs(along) < best)
      best = std::abs(along), triangle = t, bary = {area[0] / sum, area[1] / sum, area[2] / sum};
  }
  return touch_at(s, triangle, bary, best);
}

}  // namespace limberg
