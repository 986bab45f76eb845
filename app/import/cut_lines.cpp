#include "app/import/cut_lines.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>

#include "sim/geometry/triangle.h"

namespace limberg {

CutLines::CutLines(const PeerModel& model)
    : model_(model), step_mm_(std::clamp(0.4 * (model.history_mm > 0 ? model.history_mm : 1), 0.15, 0.5)) {}

SurfaceLine CutLines::between(const SurfaceSpot& a, const SurfaceSpot& b) const {
  SurfaceLine line{a};
  // Once from a to b, and again from where that came to: a chord far below the surface lays its points unevenly.
  for (int pass = 0; pass < 4; ++pass) {
    const Vec3 from = line.back().at_mm;
    const double length = (b.at_mm - from).norm();
    const int n = int(std::ceil(length / step_mm_));
    if (n <= 1) break;
    for (int i = 1; i < n; ++i) {
      const Vec3 to = from + (b.at_mm - from) * (double(i) / n);
      const SurfaceSpot next = walk_to(model_, line.back(), to, 8 * step_mm_);
      const double step = (next.at_mm - line.back().at_mm).norm();
      if (step > 1e-6) line.push_back(next);
    }
  }
  if ((line.back().at_mm - b.at_mm).norm() > 1e-9) line.push_back(b);
  return line;
}

SurfaceLine CutLines::through(const std::vector<SurfaceSpot>& posts) const {
  SurfaceLine all;
  for (size_t i = 0; i + 1 < posts.size(); ++i) {
    const SurfaceLine part = between(posts[i], posts[i + 1]);
    all.insert(all.end(), part.begin() + (i > 0 ? 1 : 0), part.end());
  }
  if (posts.size() == 1) all = {posts[0]};
  return all;
}

void CutLines::add(const SurfaceLine& line, bool blade_through) {
  Line l;
  l.blade_through = blade_through;
  for (const SurfaceSpot& s : line) l.at_mm.push_back(s.at_mm);
  if (!l.at_mm.empty()) line_.push_back(std::move(l));
}

std::optional<CutLines::Near> CutLines::nearest(const Vec3& X, double reach_mm) const {
  std::optional<Near> best;
  double least = reach_mm;
  for (size_t l = 0; l < line_.size(); ++l) {
    const auto& p = line_[l].at_mm;
    for (size_t i = 0; i < p.size(); ++i) {
      Vec3 at = p[i];
      size_t point = i;
      if (i + 1 < p.size()) {
        const Vec3 e = p[i + 1] - p[i];
        const double s = std::clamp((X - p[i]).dot(e) / std::max(e.squaredNorm(), 1e-30), 0.0, 1.0);
        at += s * e;
        if (s > 0.5) point = i + 1;
      }
      if (const double d = (at - X).norm(); d <= least)
        least = d, best = Near{int(l), int(point), at, d, line_[l].blade_through};
    }
  }
  return best;
}

std::vector<Vec3> CutLines::way(const Near& from, const Near& to) const {
  std::vector<size_t> first(line_.size() + 1, 0);
  for (size_t l = 0; l < line_.size(); ++l) first[l + 1] = first[l] + line_[l].at_mm.size();
  const size_t all = first.back();
  std::vector<Vec3> at;
  std::vector<size_t> of;
  for (size_t l = 0; l < line_.size(); ++l)
    for (const Vec3& p : line_[l].at_mm) at.push_back(p), of.push_back(l);
  std::vector<double> length(all, std::numeric_limits<double>::infinity());
  std::vector<size_t> before(all, all);
  using Open = std::pair<double, size_t>;
  std::priority_queue<Open, std::vector<Open>, std::greater<>> open;
  const size_t start = first[size_t(from.line)] + size_t(from.point), goal = first[size_t(to.line)] + size_t(to.point);
  length[start] = 0, open.push({0, start});
  while (!open.empty()) {
    const auto [d, i] = open.top();
    open.pop();
    if (d > length[i]) continue;
    if (i == goal) break;
    const auto relax = [&](size_t k) {
      if (const double next = d + (at[k] - at[i]).norm(); next < length[k])
        length[k] = next, before[k] = i, open.push({next, k});
    };
    if (i > first[of[i]]) relax(i - 1);
    if (i + 1 < first[of[i] + 1]) relax(i + 1);
    for (size_t k = 0; k < all; ++k)
      if ((of[k] != of[i] || k + 3 < i || k > i + 3) && (at[k] - at[i]).norm() <= 2 * step_mm_) relax(k);
  }
  std::vector<Vec3> way;
  if (!std::isfinite(length[goal])) return way;
  for (size_t i = goal; i != all; i = before[i]) way.push_back(at[i]);
  std::reverse(way.begin(), way.end());
  return way;
}

std::optional<CutLines::Crossing> CutLines::crossing(const Vec3& a, const Vec3& b, const Vec3& normal) const {
  int drop = 0;
  normal.cwiseAbs().maxCoeff(&drop);
  const int u = (drop + 1) % 3, v = (drop + 2) % 3;
  const auto turn = [&](const Vec3& p, const Vec3& q, const Vec3& r) {
    return (q[u] - p[u]) * (r[v] - p[v]) - (q[v] - p[v]) * (r[u] - p[u]);
  };
  const double reach = (b - a).norm() + 2 * step_mm_;
  std::optional<Crossing> best;
  for (const Line& l : line_)
    for (size_t i = 0; i + 1 < l.at_mm.size(); ++i) {
      const Vec3 &p = l.at_mm[i], &q = l.at_mm[i + 1];
      if ((p - a).squaredNorm() > reach * reach) continue;
      if (std::abs((p - a).dot(normal)) > 2 * step_mm_) continue;  // of another sheet
      const double s0 = turn(p, q, a), s1 = turn(p, q, b);
      if ((s0 > 0) == (s1 > 0) || (turn(a, b, p) > 0) == (turn(a, b, q) > 0)) continue;
      const double share = s0 / (s0 - s1);
      if (!best || share < best->share) best = Crossing{a + share * (b - a), share, l.blade_through};
    }
  return best;
}

}  // namespace limberg
