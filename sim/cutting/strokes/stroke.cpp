#include "sim/cutting/strokes/stroke.h"

#include <algorithm>
#include <cmath>

namespace limberg {

namespace {

constexpr double kCurl = 1.5;  // a loop of this length is a knot of the hand

constexpr double kTooNear = 0.25;  // passing the beginning so near is crossing it,
constexpr double kCrossAt = 0.5;   // so far from its end
constexpr double kBend = 1.0;      // by a bend of so much to both sides

}  // namespace

bool all_finite(std::span<const Vec2> path) {
  return std::all_of(path.begin(), path.end(), [](const Vec2& p) { return p.allFinite(); });
}

std::vector<Vec2> drop_close(std::span<const Vec2> path, double distance) {
  if (path.size() < 3) return {path.begin(), path.end()};
  std::vector<Vec2> out{path[0]};
  for (size_t i = 1; i + 1 < path.size(); ++i)
    if ((path[i] - out.back()).norm() >= distance && (path[i] - path.back()).norm() >= distance) out.push_back(path[i]);
  out.push_back(path.back());
  return out;
}

Vec2 heading_at_start(std::span<const Vec2> path, double over) {
  double left = over;
  Vec2 from = path.back();
  for (size_t i = 0; i + 1 < path.size(); ++i) {
    const Vec2 d = path[i + 1] - path[i];
    const double l = d.norm();
    if (l >= left && l > 0) {
      from = path[i] + d * (left / l);
      break;
    }
    left -= l;
  }
  return (path[0] - from).normalized();
}

std::optional<Vec2> meets_itself(std::span<const Vec2> path, bool closed) {
  const size_t n = path.size(), segments = closed ? n : n - 1;
  for (size_t i = 0; i < segments; ++i) {
    const Vec2 &a = path[i], &b = path[(i + 1) % n];
    if (i + 1 < segments || closed) {  // folding straight back at a joint
      const Vec2& c = path[(i + 2) % n];
      const Vec2 u = b - a, v = c - b;
      if (u.dot(v) < 0 && std::abs(cross2(u, v)) <= 1e-6 * u.norm() * v.norm()) return b;
    }
    for (size_t j = i + 2; j < segments; ++j) {
      if (closed && i == 0 && j == segments - 1) continue;
      if (const auto s = meet_segments(a, b, path[j], path[(j + 1) % n])) return a + *s * (b - a);
    }
  }
  return std::nullopt;
}

int equal_parts(double length, double spacing) { return std::max(1, int(std::ceil(length / spacing - 1e-9))); }

std::vector<Vec2> resample(std::span<const Vec2> path, double spacing, bool closed) {
  std::vector<Vec2> out;
  const size_t n = path.size(), segments = closed ? n : n - 1;
  for (size_t i = 0; i < segments; ++i) {
    const Vec2 &a = path[i], &b = path[(i + 1) % n];
    const int parts = equal_parts((b - a).norm(), spacing);
    for (int k = 0; k < parts; ++k) out.push_back(a + (b - a) * (double(k) / parts));
  }
  if (!closed) out.push_back(path.back());
  return out;
}

std::vector<SelfCrossing> self_crossings(std::span<const Vec2> path) {
  std::vector<double> arc(path.size(), 0);
  for (size_t i = 0; i + 1 < path.size(); ++i) arc[i + 1] = arc[i] + (path[i + 1] - path[i]).norm();
  std::vector<SelfCrossing> out;
  for (size_t i = 0; i + 1 < path.size(); ++i)
    for (size_t j = i + 2; j + 1 < path.size(); ++j) {
      const auto s = meet_segments(path[i], path[i + 1], path[j], path[j + 1]);
      if (!s) continue;
      const Vec2 at = path[i] + (path[i + 1] - path[i]) * *s;
      out.push_back({arc[i] + (arc[i + 1] - arc[i]) * *s, arc[j] + (at - path[j]).norm()});
    }
  std::sort(out.begin(), out.end(), [](const SelfCrossing& a, const SelfCrossing& b) { return a.second < b.second; });
  return out;
}

std::vector<Vec2> without_curls(std::vector<Vec2> path) {
  for (;;) {
    const auto crossings = self_crossings(path);
    const auto curl = std::find_if(crossings.begin(), crossings.end(),
                                   [](const SelfCrossing& x) { return x.second - x.first < kCurl; });
    if (curl == crossings.end()) return path;
    std::vector<Vec2> rest = part_of(path, 0, curl->first);
    const std::vector<Vec2> after = part_of(path, curl->second, path_length(path));
    rest.insert(rest.end(), after.begin(), after.end());
    rest = drop_close(rest, 1e-6);
    if (rest.size() >= path.size() + 2 || rest.size() < 2) return path;
    path = std::move(rest);
  }
}

std::vector<Vec2> clear_of_start(std::vector<Vec2> path) {
  if (path.size() < 4 || path_length(path) < kFarAlong + kBend) return path;
  const Vec2 start = path[0], first = -heading_at_start(path, 2);
  const double length = path_length(path);
  double arc = 0, best = kTooNear, where = -1;
  Vec2 way = Vec2::Zero();
  for (size_t i = 0; i + 1 < path.size(); ++i) {
    const Vec2 d = path[i + 1] - path[i];
    const double l = d.norm(), t = l > 0 ? std::clamp((start - path[i]).dot(d) / (l * l), 0.0, 1.0) : 0,
                 at = arc + t * l;
    const double distance = (path[i] + t * d - start).norm();
    if (at > kFarAlong && at + kBend <= length && distance <= best) best = distance, where = at, way = d / l;
    arc += l;
  }
  if (where < 0 || std::abs(way.x() * first.y() - way.y() * first.x()) < 0.5) return path;
  std::vector<Vec2> out;
  arc = 0;
  bool bent = false;
  for (size_t i = 0; i < path.size(); ++i) {
    if (i > 0) arc += (path[i] - path[i - 1]).norm();
    if (!bent && arc >= where - kBend) {  // (two points: it crosses between them)
      for (const double side : {-0.6, 0.6}) out.push_back(start + kCrossAt * (first + side * way));
      bent = true;
    }
    if (std::abs(arc - where) >= kBend) out.push_back(path[i]);
  }
  return out;
}

std::vector<Vec2> part_of(std::span<const Vec2> path, double from, double to) {
  std::vector<Vec2> out;
  double arc = 0;
  const auto add = [&](const Vec2& p) {
    if (out.empty() || (p - out.back()).norm() > 1e-9) out.push_back(p);
  };
  for (size_t i = 0; i + 1 < path.size(); ++i) {
    const double l = (path[i + 1] - path[i]).norm();
    if (l > 0 && arc + l >= from && arc <= to) {
      add(path[i] + (path[i + 1] - path[i]) * std::clamp((from - arc) / l, 0.0, 1.0));
      add(path[i] + (path[i + 1] - path[i]) * std::clamp((to - arc) / l, 0.0, 1.0));
    }
    arc += l;
  }
  return out;
}

}  // namespace limberg
