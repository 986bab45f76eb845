#include "sim/cutting/arrangement/wall_map.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "sim/cutting/arrangement/store.h"

namespace limberg {

namespace {

constexpr double kUnseen_mm = 1e9;

}  // namespace

WallMap::WallMap(const BladeContext& context, int32_t end) : context_(context) {
  if (!context.arrangement) return;
  const Arrangement& a = *context.arrangement;
  const ArrangementStore& s = a.store();
  std::map<int32_t, int32_t> column_of;                // explicit point -> column
  std::map<std::array<int32_t, 2>, int32_t> strip_of;  // columns ascending -> strip
  for (size_t op = 1; op < s.op.size() && int32_t(op) < end; ++op) {
    if (!s.op[op].strip || s.op[op].uv.empty()) continue;
    const int32_t first = s.op[op].first_orig,
                  last = op + 1 < s.op.size() ? s.op[op + 1].first_orig : int32_t(s.orig.size());
    // New points by their place along the stroke; a column that holds a known point is the known column.
    std::map<float, std::vector<WallPoint>> by_arc;
    for (int32_t o = first; o < last; ++o)
      for (size_t k = 0; k < 3; ++k) {
        const Eigen::Vector2f& uv = s.op[op].uv[size_t(o - first)][k];
        by_arc[uv.x()].push_back({s.orig[o].v[k], double(uv.y())});
        const int32_t p = s.orig[o].v[k], q = s.orig[o].v[(k + 1) % 3];
        edge_.push_back({std::min(p, q), std::max(p, q), o});
      }
    std::map<int32_t, double> level_of;
    for (auto& [arc, points] : by_arc) {
      int32_t known = -1;
      for (const WallPoint& p : points)
        if (const auto it = column_of.find(p.point); it != column_of.end()) known = it->second;
      if (known < 0) known = int32_t(column_.size()), column_.emplace_back();
      for (const WallPoint& p : points) {
        level_of[p.point] = p.level;
        if (column_of.emplace(p.point, known).second) column_[size_t(known)].point.push_back(p);
      }
    }
    for (int32_t o = first; o < last; ++o)
      for (size_t k = 0; k < 3; ++k) {
        const int32_t p = s.orig[o].v[k], q = s.orig[o].v[(k + 1) % 3];
        int32_t cp = column_of[p], cq = column_of[q];
        if (cp == cq) continue;
        const bool turned = cp > cq;
        if (turned) std::swap(cp, cq);
        const auto [it, is_new] = strip_of.emplace(std::array<int32_t, 2>{cp, cq}, int32_t(strip_.size()));
        if (is_new) {
          strip_.push_back({{cp, cq}, {-1, -1}, -1e300, false});
          for (int32_t c : {cp, cq})
            for (int32_t& slot : column_[size_t(c)].strip)
              if (slot < 0) {
                slot = it->second;
                break;
              }
        }
        WallStrip& strip = strip_[size_t(it->second)];
        const double sum = level_of[p] + level_of[q];
        if (strip.front[0] >= 0 && sum <= level_of[strip.front[0]] + level_of[strip.front[1]]) continue;
        strip.front = {turned ? q : p, turned ? p : q};
        strip.level = std::min(level_of[p], level_of[q]);
      }
  }
  std::sort(edge_.begin(), edge_.end());
  edge_.erase(std::unique(edge_.begin(), edge_.end()), edge_.end());
  for (WallColumn& c : column_) {
    std::sort(c.point.begin(), c.point.end(), [](const WallPoint& x, const WallPoint& y) { return x.level < y.level; });
    const WallPoint &top = c.point.front(), &foot = c.point.back();
    const Vec3 x = a.point_mm(top.point);
    if (foot.level > top.level) c.down = (a.point_mm(foot.point) - x) / (foot.level - top.level);
    c.X_mm = x - c.down * top.level;
    // One that is not seen lies nowhere near.
    c.chart = context.shows(c.X_mm, -c.down) ? context.chart().to_chart(c.X_mm) : Vec2(kUnseen_mm, kUnseen_mm);
  }
  for (WallStrip& t : strip_) {
    t.live = is_front(t.front[0], t.front[1]);
    line_.push_back({column_[size_t(t.column[0])].chart, column_[size_t(t.column[1])].chart});
  }
}

bool WallMap::is_front(int32_t a, int32_t b) const {
  const ArrangementStore& s = context_.arrangement->store();
  const int32_t lo = std::min(a, b), hi = std::max(a, b);
  const auto on_line = [&](int32_t p) {
    if (p == lo || p == hi) return true;
    const PointKey key = s.points.key(p);
    return key.kind == PointKey::line_plane && key.id[0] == lo && key.id[1] == hi;
  };
  for (auto it = std::lower_bound(edge_.begin(), edge_.end(), std::array<int32_t, 3>{lo, hi, -1});
       it != edge_.end() && (*it)[0] == lo && (*it)[1] == hi; ++it)
    for (int32_t f : s.faces_of((*it)[2])) {
      if (!s.face[f].live()) continue;
      for (size_t k = 0; k < 3; ++k) {
        const int32_t p = s.face[f].v[k], q = s.face[f].v[(k + 1) % 3];
        if (!on_line(p) || !on_line(q)) continue;
        const int32_t h = s.edges.first(p, q);
        if (h >= 0 && s.edges.next(h) < 0) return true;
      }
    }
  return false;
}

int32_t WallMap::open_end_near(const Vec2& p, double reach, double level, int32_t not_point) const {
  int32_t best = -1;
  for (int32_t i = 0; i < int32_t(column_.size()); ++i) {
    const WallColumn& c = column_[size_t(i)];
    const double distance = (c.chart - p).norm();
    if (!c.is_end() || distance > reach || (best >= 0 && distance >= (column_[size_t(best)].chart - p).norm()))
      continue;
    bool open = c.point.size() > 1 &&
                std::none_of(c.point.begin(), c.point.end(), [&](const WallPoint& w) { return w.point == not_point; });
    for (size_t k = 0; k + 1 < c.point.size() && open; ++k) {
      if (c.point[k + 1].level <= 0 || c.point[k].level >= level) continue;
      open = is_front(c.point[k].point, c.point[k + 1].point);
    }
    if (open) best = i;
  }
  return best;
}

Vec2 WallMap::outward(int32_t end_column) const {
  const WallColumn& c = column_[size_t(end_column)];
  const WallStrip& t = strip_[size_t(c.strip[0])];
  const Vec2 d = c.chart - column_[size_t(t.column[0] == end_column ? t.column[1] : t.column[0])].chart;
  return d.norm() > 0 ? Vec2(d.normalized()) : Vec2::UnitX();
}

WallMap::Along WallMap::nearest(const Vec2& p, double reach) const {
  Along best;
  double least = reach;
  for (int32_t i = 0; i < int32_t(strip_.size()); ++i) {
    const auto& [a, b] = line_[size_t(i)];
    const double near = least + 1e-9;  // farther along one axis: nearly all are
    if (std::min(a.x(), b.x()) - p.x() > near || p.x() - std::max(a.x(), b.x()) > near ||
        std::min(a.y(), b.y()) - p.y() > near || p.y() - std::max(a.y(), b.y()) > near)
      continue;
    const Vec2 d = b - a;
    const double l = d.norm();
    if (l < 1e-9) continue;
    const double t = std::clamp((p - a).dot(d) / (l * l), 0.0, 1.0), distance = (p - a - t * d).norm();
    if (distance > least) continue;
    least = distance;
    const Vec2 u = d / l;
    best = {i, t, u.x() * (p - a).y() - u.y() * (p - a).x(), u};
  }
  return best;
}

}  // namespace limberg
