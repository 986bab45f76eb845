#include "sim/cutting/blade_build.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/cutting/sheet_mesh.h"
#include "sim/cutting/sheet_overlap.h"
#include "sim/cutting/stroke.h"
#include "sim/cutting/tri_tests.h"
#include "sim/cutting/wound.h"

namespace limberg {

namespace {

constexpr double kPocketReach = 0.4; // two sheets nearer than this are one pocket
constexpr double kSimplify = 0.1;    // tremor and tracker noise; corners are much larger
constexpr double kRowHeight = 2.5;   // along the blade's depth
constexpr double kKnot = 0.5;        // points of a stroke nearer than this are one
constexpr double kShortest = 1.0;    // of a stroke
constexpr double kSeesWound = 1.5;   // an outline runs along an earlier cut when it stays this near
constexpr double kSheetBeyond = 1.0; // and is then widened so far past its wall (walls reach deeper, so nothing else is cut)
constexpr double kEndClearance = 0.4;  // from the free end of an earlier cut, when joining it

std::string text(const ChartPoint& p) {
  char buffer[80];
  std::snprintf(buffer, sizeof buffer, "(%.2f, %.2f)", p.x(), p.y());
  return buffer;
}

/// A skin point with a normal smoothed over 2 mm: what a held blade follows.
struct Column {
  Vec3 X = Vec3::Zero(), normal = Vec3::UnitZ();
};

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

BladeResult refuse(std::string why) { return {std::nullopt, std::move(why)}; }

/// How far an incision reaches below the depth asked, and how far blades stick out. Both vary a little from operation to
/// operation: two walls of one nominal depth then join with a clean end instead of a coincidence.
double wall_extra(const BladeContext& c) { return kWallExtra + 0.02 * (2 - (c.arrangement ? c.arrangement->operations() % 5 : 0)); }
double margin_of(const BladeContext& c) { return kMargin + 0.01 * (c.arrangement ? c.arrangement->operations() % 7 : 0); }

/// Drops a repeated last point. Empty with a reason when there is no simple outline.
std::vector<Vec2> clean_outline(std::span<const ChartPoint> outline, std::string& why) {
  std::vector<Vec2> p(outline.begin(), outline.end());
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
  if (p.size() < 3 || std::abs(signed_area(p)) < 1) {
    why = "the outline encloses less than 1 mm2; expected at least three points around an area";
    return {};
  }
  if (meets_itself(p, true)) {
    why = "the outline crosses itself; expected a simple outline";
    return {};
  }
  if (signed_area(p) < 0) std::reverse(p.begin(), p.end());
  return p;
}

/// Lets a stroke's first point end on an earlier cut when it was meant to. True when path[0] now lies past a wall.
bool attach_start(const BladeContext& c, const WoundMap& wounds, std::vector<Vec2>& path, double overshoot) {
  if (wounds.empty()) return false;
  const bool live = skin_is_live(c, path[0]);
  std::optional<Vec2> wall;  // where the stroke is to pass through a wall
  size_t next = 0;           // the first point of the stroke that stays
  // Already past a wall: over a hole (any length of it), or across a cut by less than kSnap.
  double walked = 0;
  for (size_t i = 0; i + 1 < path.size() && !wall; ++i) {
    const double length = (path[i + 1] - path[i]).norm();
    const auto s = wounds.first_meeting(path[i], path[i + 1]);
    if (s && (!live || walked + *s * length <= kSnap)) wall = path[i] + (path[i + 1] - path[i]) * *s, next = i + 1;
    walked += length;
    if (live && walked > kSnap) break;
  }
  if (!wall && !live) return false;
  // Short of a wall: straight on, or to the nearest place.
  if (!wall) {
    const Vec2 ahead = heading_at_start(path, 2) * (2 * kSnap);
    if (const auto s = wounds.first_meeting(path[0], path[0] + ahead)) wall = path[0] + ahead * *s, next = 1;
  }
  if (!wall) {
    const WoundMap::Near near = wounds.nearest(path[0]);
    if (near.distance > kSnap) return false;
    wall = near.point;
  }
  wall = wounds.clear_of_ends(*wall, kEndClearance);
  // A point right beside the wall would turn the blade along it.
  while (next + 1 < path.size() && (path[next] - *wall).norm() < 1.5 * kEndClearance) ++next;
  const Vec2 d = (*wall - path[next]).normalized(), along = wounds.nearest(*wall).along;
  const double sine = std::abs(d.x() * along.y() - d.y() * along.x());
  path.erase(path.begin(), path.begin() + long(next));
  path.insert(path.begin(), *wall + d * (overshoot / std::clamp(sine, 0.2, 1.0)));
  return true;
}

/// Which way a blade runs into the tissue at every column. To the right of the path by `lean` per mm of depth; at a corner
/// mitred, so that both sides keep the angle. With upright_corners the blade turns upright towards sharp corners:
/// leaning into a sharp bend it would run through itself.
std::vector<Vec3> lean_directions(std::span<const Column> columns, double lean, double depth, bool closed, bool upright_corners) {
  const size_t n = columns.size();
  std::vector<Vec3> before(n), after(n), direction(n);
  std::vector<double> arc(n + 1, 0), sharp;
  for (size_t i = 0; i < n; ++i) {
    const auto right_of = [&](size_t a, size_t b) { return (columns[b].X - columns[a].X).cross(columns[i].normal).normalized(); };
    const bool has_before = closed || i > 0, has_after = closed || i + 1 < n;
    before[i] = has_before ? right_of((i + n - 1) % n, i) : right_of(i, i + 1);
    after[i] = has_after ? right_of(i, (i + 1) % n) : before[i];
    arc[i + 1] = arc[i] + (columns[(i + 1) % n].X - columns[i].X).norm();
    if (before[i].dot(after[i]) < 0.94) sharp.push_back(arc[i]);
  }
  const double reach = 3 * (depth + kMargin) * std::abs(lean);
  for (size_t i = 0; i < n; ++i) {
    double share = 1;
    for (double s : sharp) {
      double d = std::abs(arc[i] - s);
      if (closed) d = std::min(d, arc[n] - d);
      if (upright_corners) share = std::min(share, d / reach);
    }
    direction[i] = -columns[i].normal + (before[i] + after[i]) / std::max(1 + before[i].dot(after[i]), 0.25) * (lean * share);
  }
  return direction;
}

/// Columns -> strip. direction[i] points into the tissue and has length 1 per mm of perpendicular depth.
void add_strip(Blade& blade, const BladeContext& c, std::span<const Column> columns, std::span<const Vec3> direction,
               double depth, bool closed, int& rows) {
  const size_t n = columns.size();
  const double margin = margin_of(c), total = depth + margin;
  rows = std::max(2, int(std::ceil(total / kRowHeight)));
  std::vector<double> arc(n + 1, 0);
  for (size_t i = 0; i < n; ++i) arc[i + 1] = arc[i] + (columns[(i + 1) % n].X - columns[i].X).norm();
  const auto level = [&](int r) { return total * r / rows - margin; };  // below the skin
  for (size_t i = 0; i < n; ++i)
    for (int r = 0; r <= rows; ++r) blade.vertex.push_back(c.body->grid.to_grid(columns[i].X + direction[i] * level(r)));
  const auto id = [&](size_t i, int r) { return int32_t(i % n) * (rows + 1) + r; };
  for (size_t i = 0; i + (closed ? 0 : 1) < n; ++i)
    for (int r = 0; r < rows; ++r) {
      const auto uv = [&](size_t k, int q) { return Eigen::Vector2f(float(arc[k]), float(level(q))); };
      // Diagonals rise away from both ends: no triangle then has all three corners on the blade's free border.
      const size_t j = i + 1;
      if (2 * j > n) {
        blade.tri.push_back({id(i, r), id(i, r + 1), id(j, r + 1)});
        blade.uv_mm.push_back({uv(i, r), uv(i, r + 1), uv(j, r + 1)});
        blade.tri.push_back({id(i, r), id(j, r + 1), id(j, r)});
        blade.uv_mm.push_back({uv(i, r), uv(j, r + 1), uv(j, r)});
      } else {
        blade.tri.push_back({id(i, r), id(i, r + 1), id(j, r)});
        blade.uv_mm.push_back({uv(i, r), uv(i, r + 1), uv(j, r)});
        blade.tri.push_back({id(i, r + 1), id(j, r + 1), id(j, r)});
        blade.uv_mm.push_back({uv(i, r + 1), uv(j, r + 1), uv(j, r)});
      }
      blade.seed.push_back(r == 0);
      blade.seed.push_back(r == 0);
    }
}

std::string columns_of(const BladeContext& c, std::span<const Vec2> path, std::vector<Column>& columns) {
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

double overshoot_of(const BladeContext& c) {
  // On a curved skin neighbouring blades lean differently: what meets at the skin must still meet at depth.
  return c.body->is_box ? kOvershoot : 2.5 * kOvershoot;
}

}  // namespace

BladeResult build_incision(const BladeContext& c, std::span<const ChartPoint> stroke, double depth_mm, double angle_deg) {
  if (std::string why = check_stroke(stroke, depth_mm); !why.empty()) return refuse(why);
  if (!(angle_deg >= 20 && angle_deg <= 160)) return refuse("the angle between blade and skin must be 20 to 160 degrees");
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
  bool past_start = false, past_end = false;
  if (!closed && c.arrangement) {
    const WoundMap wounds(c);
    past_start = attach_start(c, wounds, path, overshoot_of(c));
    std::reverse(path.begin(), path.end());
    past_end = attach_start(c, wounds, path, overshoot_of(c));
    std::reverse(path.begin(), path.end());
    if (path.size() < 2 || meets_itself(path, false)) return refuse("nothing of the stroke lies on uncut skin");
  }
  path = resample(path, kSpacing, closed);
  if (!closed && path.size() == 2 && (past_start || past_end)) path.insert(path.begin() + 1, (path[0] + path[1]) / 2);

  std::vector<Column> columns;
  if (why = columns_of(c, path, columns); !why.empty()) return refuse(why);
  const double angle = angle_deg * std::numbers::pi / 180, lean = std::cos(angle) / std::sin(angle);
  Blade blade;
  int rows = 0;
  for (const bool upright_corners : {false, true}) {
    blade = Blade{};
    add_strip(blade, c, columns, lean_directions(columns, lean, depth_mm, closed, upright_corners), depth_mm + wall_extra(c), closed, rows);
    if (lean == 0 || check_embedded(blade.vertex, blade.tri).empty()) break;
  }
  const size_t per_quad_column = size_t(rows) * 2;
  for (size_t i = 0; i < per_quad_column && past_start; ++i) blade.seed[i] = 0;
  for (size_t i = 0; i < per_quad_column && past_end; ++i) blade.seed[blade.seed.size() - 1 - i] = 0;
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
  std::vector<Column> columns;
  if (why = columns_of(c, path, columns); !why.empty()) return refuse(why);
  std::vector<Vec3> direction;
  for (const Column& k : columns) direction.push_back(-k.normal);
  Blade blade;
  int rows = 0;
  add_strip(blade, c, columns, direction, depth_mm, true, rows);
  std::vector<int32_t> id;
  for (size_t i = 0; i < floor->vertex.size(); ++i) {
    if (i < path.size()) {
      id.push_back(int32_t(i) * (rows + 1) + rows);  // the foot of a column
      continue;
    }
    const auto k = column_at(c, floor->vertex[i]);
    if (!k) return refuse("the point " + text(floor->vertex[i]) + " within the outline is not on the skin");
    id.push_back(int32_t(blade.vertex.size()));
    blade.vertex.push_back(c.body->grid.to_grid(k->X - k->normal * depth_mm));
  }
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

namespace {

/// Moves the edges of a counter-clockwise outline that run along earlier cuts outwards, just beyond the walls. Tells for
/// every edge of the result whether it was.
std::vector<Vec2> widen(const WoundMap& wounds, std::span<const Vec2> p, double beyond, std::vector<uint8_t>& along) {
  const size_t n = p.size();
  std::vector<double> shift(n, 0);
  std::vector<Vec2> out_normal(n);
  along.assign(n, 0);
  for (size_t i = 0; i < n; ++i) {
    const Vec2 a = p[i], d = p[(i + 1) % n] - a;
    out_normal[i] = Vec2(d.y(), -d.x()).normalized();
    const int samples = std::max(3, int(d.norm() / 0.5));
    int near = 0;
    for (int k = 0; k < samples; ++k) {
      const Vec2 q = a + d * ((k + 0.5) / samples);
      const WoundMap::Near w = wounds.nearest(q);
      if (w.distance > kSeesWound) continue;
      ++near;
      shift[i] = std::max(shift[i], (w.point - q).dot(out_normal[i]) + beyond);
    }
    if (near * 5 < samples * 3) shift[i] = 0;  // less than three fifths of it
    else along[i] = 1;
  }
  std::vector<Vec2> q(n);
  for (size_t i = 0; i < n; ++i) {
    // Corner i lies between edges i - 1 and i: where the two shifted lines meet, unless they are nearly parallel.
    const size_t h = (i + n - 1) % n;
    const Vec2 &u = out_normal[h], &v = out_normal[i];
    const double det = u.x() * v.y() - u.y() * v.x();
    if (std::abs(det) < 0.3) {
      q[i] = p[i] + (u + v).normalized() * std::max(shift[h], shift[i]);
    } else {
      q[i] = p[i] + Vec2(shift[h] * v.y() - shift[i] * u.y(), shift[i] * u.x() - shift[h] * v.x()) / det;
    }
  }
  return q;
}

}  // namespace

BladeResult build_undermining(const BladeContext& c, std::span<const ChartPoint> outline, double depth_mm) {
  std::string why = check_stroke(outline, depth_mm);
  if (!why.empty()) return refuse(why);
  std::vector<Vec2> path = clean_outline(outline, why);
  if (path.empty()) return refuse(why);
  std::vector<uint8_t> along(path.size(), 0);
  if (c.arrangement) {
    const WoundMap wounds(c);
    std::vector<Vec2> wider = widen(wounds, path, kSheetBeyond, along);
    if (!meets_itself(wider, true)) path = std::move(wider);
  }
  // Resample edge by edge, so that each boundary vertex knows whether it lies past a wall.
  std::vector<Vec2> boundary;
  std::vector<uint8_t> past;
  for (size_t i = 0; i < path.size(); ++i) {
    const std::array<Vec2, 2> edge{path[i], path[(i + 1) % path.size()]};
    const std::vector<Vec2> points = resample(edge, kSheetSpacing, false);
    for (size_t k = 0; k + 1 < points.size(); ++k) {
      boundary.push_back(points[k]);
      past.push_back(along[i] || (k == 0 && along[(i + path.size() - 1) % path.size()]));
    }
  }
  const auto mesh = mesh_polygon(boundary, kSheetSpacing);
  if (!mesh) return refuse("the outline cannot be filled; expected a simple outline");
  // Two sheets of one nominal depth must not coincide where they overlap.
  const double raise = kSheetRaise + 0.04 * (c.arrangement ? c.arrangement->operations() % 3 : 0);
  const double depth = std::max(depth_mm - raise, 0.5 * depth_mm);
  const PocketMap pockets(c.arrangement);
  const auto pocket_height = [&](const Vec2& p) -> std::optional<double> {
    const auto k = column_at(c, p);
    return k ? pockets.height(k->X - k->normal * depth, k->normal, kPocketReach) : std::nullopt;
  };
  std::vector<SheetVertex> sheet;
  for (const Vec2& p : mesh->vertex) {
    const auto k = column_at(c, p);
    if (!k) return refuse("the point " + text(p) + " within the outline is not on the skin");
    SheetVertex v{k->X - k->normal * depth, k->normal};
    if (const auto h = pockets.height(v.X_mm, v.normal, kPocketReach)) {
      v.covered = v.deep = true;
      v.height = *h;
      for (int i = 0; i < 8 && v.deep; ++i) {
        const double w = i * std::numbers::pi / 4;
        v.deep = pocket_height(p + 1.1 * kSheetSpacing * Vec2(std::cos(w), std::sin(w))).has_value();
      }
    }
    sheet.push_back(v);
  }
  const bool overlaps = run_into_pockets(sheet);
  Blade blade;
  for (const SheetVertex& v : sheet) blade.vertex.push_back(c.body->grid.to_grid(v.X_mm));
  bool any_seed = false;
  for (const Tri& t : mesh->tri) {
    blade.tri.push_back(t);
    std::array<Eigen::Vector2f, 3> uv;
    bool extension = false, uncovered = false;
    for (size_t k = 0; k < 3; ++k) {
      uv[k] = mesh->vertex[size_t(t[k])].cast<float>();
      extension = extension || (size_t(t[k]) < past.size() && past[size_t(t[k])]) || sheet[size_t(t[k])].deep;
      uncovered = uncovered || !sheet[size_t(t[k])].covered;
    }
    extension = extension || !uncovered;
    blade.uv_mm.push_back(uv);
    blade.seed.push_back(extension ? 0 : 2);
    any_seed = any_seed || !extension;
  }
  if (!any_seed && overlaps) return refuse("this is undermined already");
  if (!any_seed) blade.seed.assign(blade.seed.size(), 2);
  if (why = fits_grid(c, blade); !why.empty()) return refuse(why);
  return {std::move(blade), {}};
}

}  // namespace limberg
