#include "sim/cutting/strokes/blade_parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "sim/base/elementary.h"
#include "sim/cutting/strokes/pull_back.h"
#include "sim/geometry/overrun.h"

namespace limberg {

namespace {

constexpr double kLegTurn = 0.43;     // radians, 25 degrees: what turns less is a curve,
constexpr double kLegStraight = 2.0;  // and so is what turns again within so many mm
constexpr double kLegBend = 0.27;     // by more than 15 degrees in all
constexpr double kLegFold = 0.3;      // of the spacing: how far an edge may run back

std::string text(const ChartPoint& p) { return fmt::format("({:.2f}, {:.2f})", p.x(), p.y()); }

}  // namespace

std::optional<Column> column_at(const BladeContext& c, const ChartPoint& p) {
  const auto hit = c.skin(p);
  if (!hit) return std::nullopt;
  Column k{hit->X_mm, hit->normal};
  if (c.body->is_box) return k;
  Vec3 sum = hit->normal;
  for (const Vec2& d : {Vec2(2, 0), Vec2(-2, 0), Vec2(0, 2), Vec2(0, -2)})
    if (const auto near = c.skin(p + d); near && (near->X_mm - hit->X_mm).norm() < 4) sum += near->normal;
  k.normal = sum.normalized();
  return k;
}

std::string check_stroke(std::span<const ChartPoint> path, double depth_mm) {
  if (!all_finite(path)) return "a point of the stroke is not a finite number";
  if (!(std::isfinite(depth_mm) && depth_mm > 0)) return "the depth must be a positive number of mm";
  return {};
}

std::string columns_at(const BladeContext& c, std::span<const Vec2> path, std::vector<Column>& columns) {
  for (const Vec2& p : path) {
    const auto k = column_at(c, p);
    if (!k) return "the point " + text(p) + " is not on the skin";
    columns.push_back(*k);
  }
  return {};
}

std::string fits_grid(const BladeContext& c, const Blade& blade) {
  constexpr int32_t limit = RestGrid::kMaxCoordinate - 256;
  for (const Int3& p : blade.vertex)
    for (int k = 0; k < 3; ++k)
      if (p[k] > limit || p[k] < -limit) return "the blade leaves the domain of " + c.body->name;
  return {};
}

std::vector<Vec2> closed_outline(std::span<const ChartPoint> outline) {
  std::vector<Vec2> p(outline.begin(), outline.begin() + std::ptrdiff_t(points_to_closing(outline)));
  if (p.size() < outline.size() && p.size() > 3 && (p.front() - p.back()).norm() < kPasses_mm) p.pop_back();
  return p;
}

std::vector<Vec2> clean_outline(std::span<const ChartPoint> outline, std::string& why) {
  std::vector<Vec2> p = closed_outline(outline);
  while (p.size() > 1 && (p.front() - p.back()).norm() < 0.3) p.pop_back();
  if (p.size() >= 3) {
    // Simplify between two points that surely are corners: the first, and the one farthest from it.
    size_t far = 0;
    for (size_t i = 1; i < p.size(); ++i)
      if ((p[i] - p[0]).norm() > (p[far] - p[0]).norm()) far = i;
    std::vector<Vec2> first(p.begin(), p.begin() + long(far) + 1), second(p.begin() + long(far), p.end());
    second.push_back(p[0]);
    first = simplify(first, kSimplify);
    second = simplify(second, kSimplify);
    p = first;
    p.insert(p.end(), second.begin() + 1, second.end());
    p = drop_close(p, kKnot);
    p.pop_back();
  }
  // First: the two halves of a bow tie go round in opposite senses, and together they enclose nothing.
  if (const auto crossing = p.size() > 3 ? meets_itself(p, true) : std::nullopt) {
    why = "the outline crosses itself at " + text(*crossing) + " mm; expected a simple outline";
    return {};
  }
  if (p.size() < 3 || std::abs(signed_area(p)) < 1) {
    why = "the outline encloses less than 1 mm2; expected at least three points around an area";
    return {};
  }
  if (signed_area(p) < 0) std::reverse(p.begin(), p.end());
  return p;
}

std::vector<Column> stiffened(std::span<const Column> columns, double share) {
  Vec3 mean = Vec3::Zero();
  for (const Column& k : columns) mean += k.normal;
  mean.normalize();
  std::vector<Column> out(columns.begin(), columns.end());
  for (Column& k : out) k.normal = ((1 - share) * k.normal + share * mean).normalized();
  return out;
}

double leg_end(std::span<const Vec2> path, double lean, double depth_mm, double after) {
  if (std::abs(lean) < 1e-9) return -1;
  const size_t n = path.size();
  std::vector<double> arc(n, 0), turn(n, 0);  // to the left: radians
  for (size_t i = 1; i < n; ++i) arc[i] = arc[i - 1] + (path[i] - path[i - 1]).norm();
  for (size_t i = 1; i + 1 < n; ++i) {
    const Vec2 d = path[i] - path[i - 1], e = path[i + 1] - path[i];
    turn[i] = elementary::atan2(d.x() * e.y() - d.y() * e.x(), d.dot(e));
  }
  for (size_t i = 1; i + 1 < n; ++i) {
    if (arc[i] - after < kLeastLeg || arc[n - 1] - arc[i] < kLeastLeg) continue;
    // The mitred edge runs back by so much on the inner side of the turn.
    const double back =
        elementary::tan(std::min(std::abs(turn[i]) / 2, 1.57)) * std::abs(lean) * (depth_mm + 2 * kWallExtra);
    if (turn[i] * lean > 0 || std::abs(turn[i]) < kLegTurn || back < kLegFold * kSpacing) continue;
    double beside = 0;  // a curve is no corner
    for (size_t j = 1; j + 1 < n; ++j)
      if (j != i && std::abs(arc[j] - arc[i]) < kLegStraight) beside += std::abs(turn[j]);
    if (beside < kLegBend) return arc[i];
  }
  return -1;
}

std::vector<Vec2> leg_of(std::span<const Vec2> path, double to) {
  std::vector<Vec2> leg = part_of(path, 0, to);
  leg.push_back(leg.back() + (leg.back() - leg[leg.size() - 2]).normalized() * kEndClearance);
  return leg;
}

double wall_extra(const BladeContext& c) {
  return kWallExtra + 0.02 * (2 - (c.arrangement ? c.arrangement->operations() % 5 : 0));
}
double margin_of(const BladeContext& c) {
  return kMargin + 0.01 * (c.arrangement ? c.arrangement->operations() % 7 : 0);
}

double overshoot_of(const BladeContext& c) {
  // On a curved skin neighbouring blades lean differently: what meets at the skin must still meet at depth.
  return c.body->is_box ? kOvershoot : 2.5 * kOvershoot;
}

std::vector<double> leans_at_rest(const BladeContext& c, std::span<const Vec2> path, std::span<const Column> columns,
                                  double lean) {
  const size_t n = columns.size(), segments = n - 1;
  std::vector<double> out(segments, lean);
  if (!c.gradient) return out;
  std::vector<Mat3> F(n, Mat3::Identity());
  bool any = false;
  for (size_t i = 0; i < n; ++i)
    if (const auto hit = c.skin(path[i]); hit && (!c.arrangement || skin_is_live(c, path[i]))) {
      F[i] = c.gradient(*hit);
      any = any || (F[i] - Mat3::Identity()).norm() >= kAsAtRest;
    }
  if (!any) return out;
  std::vector<Vec3> way(segments), middle(segments);
  std::vector<double> raw(segments);
  for (size_t s = 0; s < segments; ++s) {
    const size_t t = s + 1;
    const Vec3 normal = (columns[s].normal + columns[t].normal).normalized(), d = columns[t].X - columns[s].X;
    way[s] = (d - d.dot(normal) * normal).normalized();
    middle[s] = (columns[s].X + columns[t].X) / 2;
    raw[s] = aside_at_rest((F[s] + F[t]) / 2, normal, way[s], lean).dot(way[s].cross(normal));
  }
  for (size_t s = 0; s < segments; ++s) {
    double sum = 0, weight = 0;
    for (size_t t = 0; t < segments; ++t)
      if ((middle[s] - middle[t]).norm() < 3 && way[s].dot(way[t]) > 0.94) sum += raw[t], weight += 1;
    out[s] = sum / weight;
  }
  return out;
}

int add_ring(Blade& blade, const BladeContext& c, std::span<const Column> columns, std::span<const Vec3> direction,
             double depth) {
  const size_t n = columns.size();
  const double margin = margin_of(c), total = depth + margin;
  const int rows = std::max(2, int(std::ceil(total / kRowHeight)));
  std::vector<double> arc(n + 1, 0);
  for (size_t i = 0; i < n; ++i) arc[i + 1] = arc[i] + (columns[(i + 1) % n].X - columns[i].X).norm();
  const auto level = [&](int r) { return total * r / rows - margin; };  // below the skin
  for (size_t i = 0; i < n; ++i)
    for (int r = 0; r <= rows; ++r)
      blade.vertex.push_back(c.body->grid.to_grid(columns[i].X + direction[i] * level(r)));
  const auto id = [&](size_t i, int r) { return int32_t(i % n) * (rows + 1) + r; };
  for (size_t i = 0; i < n; ++i)
    for (int r = 0; r < rows; ++r) {
      const auto uv = [&](size_t k, int q) { return Eigen::Vector2f(float(arc[k]), float(level(q))); };
      const size_t j = i + 1;
      blade.tri.push_back({id(i, r), id(i, r + 1), id(j, r)});
      blade.uv_mm.push_back({uv(i, r), uv(i, r + 1), uv(j, r)});
      blade.tri.push_back({id(i, r + 1), id(j, r + 1), id(j, r)});
      blade.uv_mm.push_back({uv(i, r + 1), uv(j, r + 1), uv(j, r)});
      // A shallow ring has a second row that begins above the skin.
      blade.seed.push_back(level(r) <= 0);
      blade.seed.push_back(level(r) <= 0);
    }
  return rows;
}

}  // namespace limberg
