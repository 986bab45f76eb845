#include "devices/surface_index.h"

#include <algorithm>
#include <cmath>

#include "sim/geometry/triangle.h"

namespace limberg {

namespace {

constexpr int kMaxCells = 512;  // along each side of the chart grid
constexpr int kMaxWalk = 2000;

const Vec3f& float_at(const Snapshot& s, int32_t v) { return s.x_mm[size_t(v)]; }

}  // namespace

int SurfaceIndex::cell_x(double x) const {
  return std::clamp(int(std::floor((x - grid_min_.x()) / cell_mm_)), 0, nx_ - 1);
}
int SurfaceIndex::cell_y(double y) const {
  return std::clamp(int(std::floor((y - grid_min_.y()) / cell_mm_)), 0, ny_ - 1);
}

void SurfaceIndex::build(const SurfaceTopology& topology, Ground ground) {
  const SurfaceView& view = topology.view;
  built_ = true;
  version_ = topology.version;
  skin_tri_.clear();
  skin_vertex_.clear();

  // Skin triangles, and the stars of their vertices by counting.
  star_start_.assign(view.X_mm.size() + 1, 0);
  for (size_t t = 0; t < view.tri.size(); ++t) {
    if (!topology.is_ground(t, ground)) continue;
    skin_tri_.push_back(int32_t(t));
    for (int32_t v : view.tri[t]) ++star_start_[size_t(v) + 1];
  }
  for (size_t v = 0; v < view.X_mm.size(); ++v) {
    if (star_start_[v + 1] > 0) skin_vertex_.push_back(int32_t(v));
    star_start_[v + 1] += star_start_[v];
  }
  mark_.assign(view.X_mm.size(), 0);
  marked_.clear();
  marked_.reserve(skin_vertex_.size());
  star_.resize(3 * skin_tri_.size());
  std::vector<int32_t> fill(star_start_.begin(), star_start_.end() - 1);
  for (int32_t t : skin_tri_)
    for (int32_t v : view.tri[size_t(t)]) star_[size_t(fill[size_t(v)]++)] = t;

  // The chart grid, by counting as well.
  std::vector<Vec2> chart(view.X_mm.size(), Vec2::Zero());
  Vec2 low(1e30, 1e30), high(-1e30, -1e30);
  for (int32_t v : skin_vertex_) {
    chart[size_t(v)] = topology.to_chart(view.X_mm[size_t(v)]);
    low = low.cwiseMin(chart[size_t(v)]);
    high = high.cwiseMax(chart[size_t(v)]);
  }
  nx_ = ny_ = 0;
  if (skin_vertex_.empty()) return;
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
  for (int32_t t : skin_tri_) each_cell(t, [&](size_t cell) { ++cell_start_[cell + 1]; });
  for (size_t i = 0; i + 1 < cell_start_.size(); ++i) cell_start_[i + 1] += cell_start_[i];
  cell_tri_.resize(size_t(cell_start_.back()));
  fill.assign(cell_start_.begin(), cell_start_.end() - 1);
  for (int32_t t : skin_tri_) each_cell(t, [&](size_t cell) { cell_tri_[size_t(fill[cell]++)] = t; });
}

SkinTouch SurfaceIndex::touch(const Snapshot& s, const Place& place) const {
  SkinTouch out;
  if (place.triangle < 0) return out;
  const SurfaceView& view = s.topology->view;
  const Tri& k = view.tri[size_t(place.triangle)];
  const Vec3 a = float_at(s, k[0]).cast<double>(), b = float_at(s, k[1]).cast<double>(),
             c = float_at(s, k[2]).cast<double>();
  out.triangle = place.triangle;
  out.bary = place.bary;
  out.x_mm = place.bary[0] * a + place.bary[1] * b + place.bary[2] * c;
  out.X_mm = Vec3::Zero();
  for (size_t i = 0; i < 3; ++i) out.X_mm += place.bary[i] * view.X_mm[size_t(k[i])];
  out.chart = s.topology->to_chart(out.X_mm);
  const Vec3 n = area_vector2(a, b, c);
  if (n.norm() > 0) out.normal = n.normalized();
  out.distance_mm = std::sqrt(place.distance2);
  return out;
}

int32_t SurfaceIndex::nearest_vertex(const Snapshot& s, const Vec3& p_mm, bool unmarked_only) const {
  const Vec3f p = p_mm.cast<float>();
  int32_t best = -1;
  float best2 = 1e30f;
  for (int32_t v : skin_vertex_) {
    const float d2 = (float_at(s, v) - p).squaredNorm();
    if (d2 < best2 && !(unmarked_only && mark_[size_t(v)])) best2 = d2, best = v;
  }
  return best;
}

void SurfaceIndex::mark_sheet(const Snapshot& s, const SkinTouch& middle) {
  const SurfaceView& view = s.topology->view;
  size_t next = marked_.size();
  const auto mark = [&](int32_t v) {
    if (mark_[size_t(v)]) return;
    mark_[size_t(v)] = 1;
    marked_.push_back(v);
  };
  for (int32_t v : view.tri[size_t(middle.triangle)]) mark(v);
  for (; next < marked_.size(); ++next) {
    const size_t v = size_t(marked_[next]);
    if ((view.X_mm[v] - middle.X_mm).norm() > kSheetRadius_mm) continue;
    for (int32_t i = star_start_[v]; i < star_start_[v + 1]; ++i)
      for (int32_t w : view.tri[size_t(star_[size_t(i)])]) mark(w);
  }
}

size_t SurfaceIndex::sheets_near(const Snapshot& s, const Vec3& p_mm, double among_mm, std::span<SkinTouch> out) {
  size_t n = 0;
  while (n < out.size()) {
    const int32_t v = nearest_vertex(s, p_mm, n > 0);
    if (v < 0) break;
    out[n] = touch(s, walk(s, p_mm, star_[size_t(star_start_[size_t(v)])]));
    // The walk may run back over the border of a sheet that is known: then this was a part of it.
    const bool known = [&] {
      for (int32_t w : s.topology->view.tri[size_t(out[n].triangle)])
        if (mark_[size_t(w)]) return true;
      return false;
    }();
    if (n > 0 && (known || out[n].distance_mm > out[0].distance_mm + among_mm)) break;
    mark_sheet(s, out[n]);
    ++n;
  }
  for (int32_t v : marked_) mark_[size_t(v)] = 0;
  marked_.clear();
  return n;
}

SkinTouch SurfaceIndex::closest_apart(const Snapshot& s, const Vec3& p_mm, const SkinTouch& other, double reach_mm) {
  if (other.triangle < 0) return {};
  mark_sheet(s, other);
  SkinTouch found;
  if (const int32_t v = nearest_vertex(s, p_mm, true); v >= 0) {
    found = touch(s, walk(s, p_mm, star_[size_t(star_start_[size_t(v)])]));
    bool same = found.distance_mm > reach_mm;
    for (int32_t w : s.topology->view.tri[size_t(found.triangle)]) same = same || mark_[size_t(w)];
    if (same) found = {};
  }
  for (int32_t v : marked_) mark_[size_t(v)] = 0;
  marked_.clear();
  return found;
}

SurfaceIndex::Place SurfaceIndex::walk(const Snapshot& s, const Vec3& p_mm, int32_t triangle) const {
  const SharedArray<Tri>& tri = s.topology->view.tri;
  Place best;
  auto look_at = [&](int32_t t) {
    const Tri& k = tri[size_t(t)];
    const TrianglePoint c = closest_on_triangle(p_mm, float_at(s, k[0]).cast<double>(),
                                                float_at(s, k[1]).cast<double>(), float_at(s, k[2]).cast<double>());
    const double d2 = (c.point - p_mm).squaredNorm();
    // Equal distances (a shared edge or corner) go to the lower number, so that the way here does not matter.
    if (d2 < best.distance2 || (d2 == best.distance2 && t < best.triangle)) best = {t, c.bary, d2};
  };
  look_at(triangle);
  for (int step = 0, from = -1; step < kMaxWalk && best.triangle >= 0 && best.triangle != from; ++step) {
    from = best.triangle;
    for (int32_t v : tri[size_t(from)])
      for (int32_t i = star_start_[size_t(v)]; i < star_start_[size_t(v) + 1]; ++i) look_at(star_[size_t(i)]);
  }
  return best;
}

SkinTouch SurfaceIndex::closest(const Snapshot& s, const Vec3& p_mm, int32_t hint) const {
  if (hint >= 0) return touch(s, walk(s, p_mm, hint));
  const int32_t v = nearest_vertex(s, p_mm, false);
  if (v < 0) return {};
  return touch(s, walk(s, p_mm, star_[size_t(star_start_[size_t(v)])]));
}

int SurfaceIndex::facets_around(const Snapshot& s, const SkinTouch& place, double reach_mm,
                                std::span<std::array<Vec3, 3>> out) const {
  constexpr size_t kMost = 128;
  std::array<int32_t, kMost> found;
  size_t n = 0;
  const size_t most = std::min(kMost, out.size());
  if (place.triangle < 0 || most == 0) return 0;
  const SharedArray<Tri>& tri = s.topology->view.tri;
  found[n++] = place.triangle;
  for (size_t next = 0; next < n && n < most; ++next)
    for (const int32_t v : tri[size_t(found[next])]) {
      if ((float_at(s, v).cast<double>() - place.x_mm).norm() > reach_mm) continue;
      for (int32_t i = star_start_[size_t(v)]; i < star_start_[size_t(v) + 1] && n < most; ++i)
        if (std::find(found.begin(), found.begin() + long(n), star_[size_t(i)]) == found.begin() + long(n))
          found[n++] = star_[size_t(i)];
    }
  for (size_t i = 0; i < n; ++i)
    for (size_t k = 0; k < 3; ++k) out[i][k] = float_at(s, tri[size_t(found[i])][k]).cast<double>();
  return int(n);
}

SkinTouch SurfaceIndex::at_chart(const Snapshot& s, const ChartPoint& c, double slack_mm) const {
  if (nx_ == 0 || !c.allFinite() || !s.topology->body) return {};
  const SurfaceView& view = s.topology->view;
  const Body& body = *s.topology->body;
  const Vec3 up = body.chart_normal();
  Place best;
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
  return touch(s, best);
}

}  // namespace limberg
