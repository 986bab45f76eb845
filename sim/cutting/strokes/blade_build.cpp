#include "sim/cutting/strokes/blade_build.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/cutting/arrangement/tri_tests.h"
#include "sim/cutting/strokes/blade_continue.h"
#include "sim/cutting/strokes/blade_parts.h"
#include "sim/cutting/strokes/pull_back.h"
#include "sim/cutting/strokes/sheet_mesh.h"
#include "sim/geometry/blade_angle.h"

namespace limberg {

namespace {

/// Which way a blade runs into the tissue at every column: to the right of the path by its segments' leans per mm of
/// depth; at a corner mitred, so that both sides keep theirs. With upright_corners the blade turns upright towards
/// sharp corners: leaning into a sharp bend it would run through itself.
std::vector<Vec3> lean_directions(std::span<const Column> columns, std::span<const double> lean, double depth,
                                  bool closed, bool upright_corners) {
  const size_t n = columns.size();
  std::vector<Vec3> before(n), after(n), direction(n);
  std::vector<double> arc(n + 1, 0), sharp;
  double most = 0;
  for (double l : lean) most = std::max(most, std::abs(l));
  for (size_t i = 0; i < n; ++i) {
    const auto right_of = [&](size_t a, size_t b) {
      return (columns[b].X - columns[a].X).cross(columns[i].normal).normalized();
    };
    const bool has_before = closed || i > 0, has_after = closed || i + 1 < n;
    before[i] = has_before ? right_of((i + n - 1) % n, i) : right_of(i, i + 1);
    after[i] = has_after ? right_of(i, (i + 1) % n) : before[i];
    arc[i + 1] = arc[i] + (columns[(i + 1) % n].X - columns[i].X).norm();
    if (before[i].dot(after[i]) < 0.94) sharp.push_back(arc[i]);
  }
  const double reach = 3 * (depth + kMargin) * most;
  for (size_t i = 0; i < n; ++i) {
    double share = 1;
    for (double s : sharp) {
      double d = std::abs(arc[i] - s);
      if (closed) d = std::min(d, arc[n] - d);
      if (upright_corners) share = std::min(share, d / reach);
    }
    // The vector with these two components to the right of either
    // segment: their mean along the bisector, their difference across it.
    const size_t last = lean.size() - 1;
    const double lb = lean[closed ? (i + last) % (last + 1) : i == 0 ? 0 : i - 1], la = lean[std::min(i, last)];
    const double k = before[i].dot(after[i]), mean = lb == la ? la : (la + lb) / 2;
    direction[i] = -columns[i].normal + (before[i] + after[i]) / std::max(1 + k, 0.25) * (mean * share);
    if (la != lb && k < 0.94) direction[i] += (before[i] - after[i]) / (1 - k) * ((lb - la) / 2 * share);
  }
  return direction;
}

}  // namespace

std::vector<double> leans_at_rest(const BladeContext& c, std::span<const Vec2> path, std::span<const Column> columns,
                                  double lean, bool closed) {
  const size_t n = columns.size(), segments = closed ? n : n - 1;
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
    const size_t t = (s + 1) % n;
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

BladeResult build_incision(const BladeContext& c, std::span<const ChartPoint> stroke, double depth_mm, double angle_deg,
                           Joins joins) {
  if (std::string why = check_stroke(stroke, depth_mm); !why.empty()) return refuse(why);
  if (!blade_can_lean(angle_deg)) return refuse(kBladeAngles);
  if (stroke.size() < 2) return refuse("an incision needs at least two points");
  const bool closed = stroke.size() > 3 && (stroke.front() - stroke.back()).norm() <= 0.1;
  std::vector<Vec2> path;
  std::string why;
  if (closed) {
    path = clean_outline(stroke, why);
    if (path.empty()) return refuse(why);
  } else {
    path = drop_close(simplify(stroke, kSimplify), kKnot);
    if (path_length(path) < kShortest) return refuse("the stroke is shorter than 1 mm");
    if (meets_itself(path, false)) return refuse("the stroke crosses itself; expected a path without crossings");
  }
  // An end is pushed through an earlier wall, or goes on where one ends.
  bool past_start = false, past_end = false;
  int32_t join_at_start = -1, join_at_end = -1;
  const WallMap walls(c);
  if (!closed && c.arrangement) {
    const WoundMap wounds(c);
    const double level = depth_mm + wall_extra(c);
    const auto attach = [&](int32_t& join, bool& past, bool may_join) {
      join = may_join ? join_start(walls, path, level) : -1;
      if (join < 0) past = attach_start(c, wounds, path, overshoot_of(c));
    };
    attach(join_at_start, past_start, joins == Joins::any);
    std::reverse(path.begin(), path.end());
    attach(join_at_end, past_end, joins != Joins::none);
    std::reverse(path.begin(), path.end());
    if (join_at_end >= 0 && join_at_end == join_at_start) return refuse("both ends of the stroke meet at one place");
    if (path.size() < 2 || meets_itself(path, false))
      return {.blade = {}, .reason = "nothing of the stroke lies on uncut skin", .nothing = true};
  }
  path = resample(path, kSpacing, closed);
  const bool attached = past_start || past_end || join_at_start >= 0 || join_at_end >= 0;
  if (!closed && path.size() == 2 && attached) path.insert(path.begin() + 1, (path[0] + path[1]) / 2);

  std::vector<Column> columns;
  if (why = columns_at(c, path, columns); !why.empty()) return refuse(why);
  const double angle = angle_deg * std::numbers::pi / 180, lean = std::cos(angle) / std::sin(angle);
  Blade blade;
  std::vector<double> leans = leans_at_rest(c, path, columns, lean, closed);
  const auto build = [&](double stiffness, bool upright_corners) {
    const std::vector<Column> held = stiffened(columns, stiffness);
    const std::vector<Vec3> direction = lean_directions(held, leans, depth_mm, closed, upright_corners);
    const size_t first = join_at_start >= 0, own = held.size() - first - (join_at_end >= 0);
    const double depth = depth_mm + wall_extra(c);
    blade = Blade{};
    blade.strip = true;
    const int rows = add_strip(blade, c, std::span(held).subspan(first, own), std::span(direction).subspan(first, own),
                               depth, closed);
    const size_t per_column = std::min(size_t(rows) * 2, blade.seed.size());
    if (past_start) std::fill_n(blade.seed.begin(), per_column, uint8_t(0));
    if (past_end) std::fill_n(blade.seed.rbegin(), per_column, uint8_t(0));
    std::vector<std::pair<int32_t, int32_t>> known;
    const auto own_side = [&](size_t i) {  // of the strip's own columns
      StripSide side;
      for (int r = 0; r <= rows; ++r) {
        side.vertex.push_back(int32_t(i) * (rows + 1) + r);
        side.level.push_back((depth + margin_of(c)) * r / rows - margin_of(c));
      }
      for (size_t k = first; k < first + i; ++k) side.arc += (held[k + 1].X - held[k].X).norm();
      return side;
    };
    const auto wall_side = [&](int32_t column, double arc) {
      StripSide side = side_of_wall(blade, c, walls.columns()[size_t(column)], -1e300, depth, known);
      side.arc = arc;
      return side;
    };
    if (join_at_start >= 0) {
      const StripSide side = own_side(0);
      add_between(blade, wall_side(join_at_start, -(held[1].X - held[0].X).norm()), side, 0, 0);
    }
    if (join_at_end >= 0) {
      const StripSide side = own_side(own - 1);
      add_between(blade, side,
                  wall_side(join_at_end, side.arc + (held[first + own].X - held[first + own - 1].X).norm()), 0, 0);
    }
    if (!known.empty()) blade.shared_point.resize(blade.vertex.size(), -1);
    return check_embedded(blade.vertex, blade.tri).empty();
  };
  const auto try_all = [&] {
    const bool leaning = std::any_of(leans.begin(), leans.end(), [](double l) { return l != 0; });
    for (const double stiffness : kStiffness)
      for (const bool upright_corners : {false, true})
        if ((!upright_corners || leaning) && build(stiffness, upright_corners)) return true;
    return false;
  };
  bool embedded = try_all();
  if (!embedded && c.gradient) {  // strongly uneven tissue: as if it lay at rest
    leans.assign(leans.size(), lean);
    embedded = try_all();
  }
  if (!embedded && (join_at_start >= 0 || join_at_end >= 0))
    return build_incision(c, stroke, depth_mm, angle_deg, Joins::none);
  if (!embedded)
    return {.blade = {},
            .reason = "the blade would run through itself; expected a straighter path or less depth",
            .folds = true};
  if (why = fits_grid(c, blade); !why.empty()) return refuse(why);
  return {std::move(blade), {}};
}

BladeResult build_plug(const BladeContext& c, std::span<const ChartPoint> outline, double depth_mm) {
  std::string why = check_stroke(outline, depth_mm);
  if (!why.empty()) return refuse(why);
  std::vector<Vec2> path = clean_outline(outline, why);
  if (path.empty()) return refuse(why);
  path = resample(path, kSpacing, true);
  const auto floor = mesh_polygon(path, kSheetSpacing);
  if (!floor) return refuse("the outline cannot be filled; expected a simple outline");
  std::vector<Column> columns;  // of the outline, then of the floor's inside
  if (why = columns_at(c, floor->vertex, columns); !why.empty()) return refuse(why);
  Blade blade;
  std::vector<int32_t> id;
  bool embedded = false;
  for (const double stiffness : kStiffness) {
    if (embedded) break;
    const std::vector<Column> held = stiffened(columns, stiffness);
    std::vector<Vec3> direction;
    for (size_t i = 0; i < path.size(); ++i) direction.push_back(-held[i].normal);
    blade = Blade{};
    id.clear();
    const int rows = add_strip(blade, c, std::span(held).first(path.size()), direction, depth_mm, true);
    for (size_t i = 0; i < held.size(); ++i) {
      if (i < path.size()) {
        id.push_back(int32_t(i) * (rows + 1) + rows);  // the foot of a column
        continue;
      }
      id.push_back(int32_t(blade.vertex.size()));
      blade.vertex.push_back(c.body->grid.to_grid(held[i].X - held[i].normal * depth_mm));
    }
    std::vector<Tri> all = blade.tri;
    for (const Tri& t : floor->tri) all.push_back({id[size_t(t[0])], id[size_t(t[1])], id[size_t(t[2])]});
    embedded = check_embedded(blade.vertex, all).empty();
  }
  if (!embedded)
    return refuse("the plug's walls would run through one another; expected less depth or a wider outline");
  for (const Tri& t : floor->tri) {
    blade.tri.push_back({id[size_t(t[0])], id[size_t(t[1])], id[size_t(t[2])]});
    std::array<Eigen::Vector2f, 3> uv;
    for (size_t k = 0; k < 3; ++k) uv[k] = floor->vertex[size_t(t[k])].cast<float>();
    blade.uv_mm.push_back(uv);
  }
  blade.seed.assign(blade.tri.size(), 2);
  if (why = fits_grid(c, blade); !why.empty()) return refuse(why);
  return {std::move(blade), {}};
}

}  // namespace limberg
