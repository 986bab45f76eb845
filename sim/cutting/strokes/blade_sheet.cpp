// Undermining: a sheet under an outline, widened where the outline runs along earlier cuts.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>

#include "sim/base/elementary.h"
#include "sim/body/skin.h"
#include "sim/cutting/arrangement/tri_tests.h"
#include "sim/cutting/strokes/blade_parts.h"
#include "sim/cutting/strokes/sheet_mesh.h"
#include "sim/cutting/strokes/sheet_overlap.h"

namespace limberg {

namespace {

constexpr double kPocketReach = 0.4;  // two sheets nearer than this are one pocket
constexpr double kSeesWound = 1.5;    // an outline runs along an earlier cut when it stays this near
constexpr double kSeesRim = 1.2;      // a pocket that begins so near beyond the outline is meant to be joined
constexpr double kIntoPocket = 1.2;   // ... by reaching so far into it: there the sheets cross
constexpr double kCornerPast = 0.5;   // a corner that points at a wall is pushed so far through it
constexpr double kBeforeEnd = 0.5;    // from the free end of a wall, where a sheet's border crosses it
// and is then widened so far past its wall (walls reach deeper, so nothing else is cut)
constexpr double kSheetBeyond = 1.0;

constexpr double kOnWound = 0.6;       // a hand that follows a cut stays this near to it
constexpr double kLeastOnWound = 5.0;  // ... for at least so long; what crosses it at 15 degrees or more stays for less
constexpr double kSheetStep = 0.5;
constexpr double kSlope = 0.7;  // of a sheet that comes off what is held, mm a mm: 35 degrees

using Covered = std::function<bool(const Vec2&)>;  // is there an earlier pocket at the sheet's depth?

/// How far an edge a-b must move along `out` to reach well into
/// a pocket whose rim lies beside it: 0 when there is none.
double shift_into_pocket(const Covered& covered, const Vec2& a, const Vec2& b, const Vec2& out) {
  const int samples = std::max(3, int((b - a).norm()));
  int near = 0;
  double shift = 0;
  for (int k = 0; k < samples; ++k) {
    const Vec2 q = a + (b - a) * ((k + 0.5) / samples);
    if (covered(q)) {
      if (covered(q - kIntoPocket * out)) continue;  // far in already
      ++near;
      shift = std::max(shift, kIntoPocket);
      continue;
    }
    for (double d = 0.3; d <= kSeesRim; d += 0.3)
      if (covered(q + d * out)) {
        ++near;
        shift = std::max(shift, d + kIntoPocket);
        break;
      }
  }
  return near * 5 < samples * 3 ? 0 : shift;
}

/// An outline whose edges that run along a cut for a part of their length only have corners where that part begins and
/// ends: a border in the plane of a wall would meet it here and miss it there, and leave bridges.
std::vector<Vec2> divided_at_wounds(const WoundMap& wounds, std::span<const Vec2> p) {
  std::vector<Vec2> out;
  for (size_t i = 0; i < p.size(); ++i) {
    out.push_back(p[i]);
    const Vec2 a = p[i], d = p[(i + 1) % p.size()] - a;
    const double length = d.norm();
    const int samples = std::max(3, int(length / kSheetStep));
    int near = 0, first = -1;
    std::vector<std::pair<int, int>> run;  // samples from, to (not included)
    for (int k = 0; k <= samples; ++k) {
      const double distance = k == samples ? 1e300 : wounds.nearest(a + d * ((k + 0.5) / samples)).distance;
      near += distance <= kSeesWound;
      if (distance <= kOnWound && first < 0) first = k;
      if (distance <= kOnWound || first < 0) continue;
      if ((k - first) * length / samples >= kLeastOnWound) run.push_back({first, k});
      first = -1;
    }
    if (near * 5 >= samples * 3) continue;  // widen() takes all of it
    for (const auto& [from, to] : run) {
      if (from * length / samples > kOnWound) out.push_back(a + d * (double(from) / samples));
      if ((samples - to) * length / samples > kOnWound) out.push_back(a + d * (double(to) / samples));
    }
  }
  return out;
}

/// Moves the edges of a counter-clockwise outline that run along earlier cuts
/// outwards, just beyond the walls, and those that run along the rim of an earlier
/// pocket into it. Tells for every edge of the result whether it lies past a wall.
std::vector<Vec2> widen(const WoundMap& wounds, const Covered& covered, std::span<const Vec2> p, double beyond,
                        std::vector<uint8_t>& along) {
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
    if (near * 5 >= samples * 3)
      along[i] = 1;
    else  // less than three fifths of it
      shift[i] = shift_into_pocket(covered, a, p[(i + 1) % n], out_normal[i]);
  }
  std::vector<Vec2> q;
  std::vector<uint8_t> edge_along;  // of the edge that begins at each point of q
  for (size_t i = 0; i < n; ++i) {
    // Corner i lies between edges i - 1 and i: where the two shifted lines meet, unless they are nearly parallel.
    const size_t h = (i + n - 1) % n;
    const Vec2 &u = out_normal[h], &v = out_normal[i];
    const auto end = along[h] != along[i] ? wounds.free_end_near(p[i], kSeesWound) : std::nullopt;
    if (end && (p[i] - end->at).dot(end->inward) < 2 * kBeforeEnd) {
      // A wall ends here: the border crosses it just before its end. Around the end the sheet would run on outside.
      const size_t wall = along[i] ? i : h;
      const Vec2 foot = end->at + kBeforeEnd * end->inward, inside = foot - kBeforeEnd * out_normal[wall],
                 outside = foot + beyond * out_normal[wall];
      q.push_back(along[i] ? inside : outside);
      edge_along.push_back(1);
      q.push_back(along[i] ? outside : inside);
      edge_along.push_back(along[i]);
      continue;
    }
    // A border that leaves a wall where walls meet (a flap's tip) passes that place on the outside: exactly through it,
    // the sheet would part the tip at some places and leave bridges at others.
    const bool at_tip = along[h] != along[i] && wounds.nearest(p[i]).distance <= kSnap;
    const double before = at_tip && !along[h] ? std::max(shift[h], kCornerPast) : shift[h];
    const double after = at_tip && !along[i] ? std::max(shift[i], kCornerPast) : shift[i];
    const double det = u.x() * v.y() - u.y() * v.x();
    if (std::abs(det) < 0.3) {
      q.push_back(p[i] + (u + v).normalized() * std::max(before, after));
    } else {
      q.push_back(p[i] + Vec2(before * v.y() - after * u.y(), after * u.x() - before * v.x()) / det);
    }
    edge_along.push_back(along[i]);
  }
  along = std::move(edge_along);
  return q;
}

/// How deep the sheet lies below a column.
struct SheetDepth {
  double depth_mm = 0;
  AlongHeld held{};

  /// Where what is held lies no deeper than the sheet would: so far above it, half way where the tissue is thinner.
  std::optional<double> above_held(const Column& k) const {
    if (!held.skin) return std::nullopt;
    const TriMesh& surface = held.skin->body().surface;
    std::array<Bvh::LineHit, 16> hit;
    const int n = std::min(
        held.skin->surface().line(k.X + kMargin * k.normal, -k.normal, 0, depth_mm + held.above_mm + kMargin, hit),
        int(hit.size()));
    for (int i = 0; i < n; ++i) {
      const double thick = hit[size_t(i)].t - kMargin;
      if (hit[size_t(i)].from_outside || thick <= 0.1) continue;
      if (surface.tag.empty() || surface.tag[size_t(hit[size_t(i)].triangle)] != SurfaceTag::fixed) return std::nullopt;
      return std::max(thick - held.above_mm, 0.5 * thick);
    }
    return std::nullopt;
  }
  double at(const Column& k) const { return std::min(depth_mm, above_held(k).value_or(depth_mm)); }
};

/// The depths at the vertices of a sheet, none deeper than a neighbour's by more than kSlope times their distance:
/// where bone ends the sheet falls off as a knife does that is led along it.
std::vector<double> sheet_depths(const SheetDepth& depth, std::span<const Column> columns, const PlaneMesh& mesh) {
  std::vector<double> d;
  for (const Column& k : columns) d.push_back(depth.at(k));
  if (!depth.held.skin) return d;
  for (bool lower = true; lower;) {
    lower = false;
    for (const Tri& t : mesh.tri)
      for (int k = 0; k < 3; ++k)
        for (const auto& [from, to] : {std::pair(t[k], t[(k + 1) % 3]), std::pair(t[(k + 1) % 3], t[k])}) {
          const double most = d[size_t(from)] + kSlope * (columns[size_t(from)].X - columns[size_t(to)].X).norm();
          if (d[size_t(to)] <= most + 1e-9) continue;
          d[size_t(to)] = most, lower = true;
        }
  }
  return d;
}

}  // namespace

BladeResult build_undermining(const BladeContext& c, std::span<const ChartPoint> outline, double depth_mm,
                              const AlongHeld& along_held) {
  std::string why = check_stroke(outline, depth_mm);
  if (!why.empty()) return refuse(why);
  std::vector<Vec2> path = clean_outline(outline, why);
  if (path.empty()) return refuse(why);
  // Two sheets of one nominal depth must not coincide where they overlap.
  const double raise = kSheetRaise + 0.04 * (c.arrangement ? c.arrangement->operations() % 3 : 0);
  const SheetDepth depth{std::max(depth_mm - raise, 0.5 * depth_mm), along_held};
  const PocketMap pockets(c.arrangement);
  const auto pocket_height = [&](const Vec2& p) -> std::optional<double> {
    const auto k = column_at(c, p);
    return k ? pockets.height(k->X - k->normal * depth.at(*k), k->normal, kPocketReach) : std::nullopt;
  };
  std::vector<uint8_t> along, past_corner;
  if (c.arrangement) {
    const WoundMap wounds(c);
    path = divided_at_wounds(wounds, path);
    std::vector<Vec2> wider = widen(
        wounds, [&](const Vec2& p) { return pocket_height(p).has_value(); }, path, kSheetBeyond, along);
    if (meets_itself(wider, true))
      along.assign(path.size(), 0);
    else
      path = std::move(wider);
    // A corner that points at a wall and does not quite reach it does.
    past_corner.assign(path.size(), 0);
    std::vector<Vec2> reaching = path;
    for (size_t i = 0; i < path.size(); ++i) {
      const WoundMap::Near w = wounds.nearest(path[i]);
      const Vec2 d = w.point - path[i];
      if (along[i] || along[(i + path.size() - 1) % path.size()] || w.distance > kSnap || w.distance < 1e-6) continue;
      if (inside_polygon(path, w.point)) continue;
      reaching[i] = w.point + kCornerPast * d.normalized();
      past_corner[i] = 1;
    }
    if (meets_itself(reaching, true))
      past_corner.assign(path.size(), 0);
    else
      path = std::move(reaching);
  }
  along.resize(path.size(), 0), past_corner.resize(path.size(), 0);
  // Resample edge by edge, so that each boundary vertex knows whether it lies past a wall.
  std::vector<Vec2> boundary;
  std::vector<uint8_t> past;
  for (size_t i = 0; i < path.size(); ++i) {
    const std::array<Vec2, 2> edge{path[i], path[(i + 1) % path.size()]};
    const std::vector<Vec2> points = resample(edge, kSheetSpacing, false);
    for (size_t k = 0; k + 1 < points.size(); ++k) {
      boundary.push_back(points[k]);
      past.push_back(along[i] || (k == 0 && (past_corner[i] || along[(i + path.size() - 1) % path.size()])));
    }
  }
  const auto mesh = mesh_polygon(boundary, kSheetSpacing);
  if (!mesh) return refuse("the outline cannot be filled; expected a simple outline");
  std::vector<Column> columns;
  if (why = columns_at(c, mesh->vertex, columns); !why.empty()) return refuse(why);
  if (along_held.skin &&
      std::none_of(columns.begin(), columns.end(), [&](const Column& k) { return depth.above_held(k).has_value(); }))
    return refuse(fmt::format(
        "nothing is held within {:.3g} mm below the outline; expected a place over bone, or no above_held_mm",
        depth_mm));
  std::vector<SheetVertex> sheet;
  bool overlaps = false, embedded = false;
  for (const double stiffness : kStiffness) {
    if (embedded) break;
    const std::vector<Column> held = stiffened(columns, stiffness);
    const std::vector<double> deep = sheet_depths(depth, held, *mesh);
    sheet.clear();
    for (size_t i = 0; i < held.size(); ++i) {
      SheetVertex v{held[i].X - held[i].normal * deep[i], held[i].normal};
      if (const auto h = pockets.height(v.X_mm, v.normal, kPocketReach)) {
        v.covered = v.deep = true;
        v.height = *h;
        for (int k = 0; k < 8 && v.deep; ++k) {
          const double w = k * std::numbers::pi / 4;
          v.deep =
              pocket_height(mesh->vertex[i] + kDeepReach * Vec2(elementary::cos(w), elementary::sin(w))).has_value();
        }
      }
      sheet.push_back(v);
    }
    overlaps = run_into_pockets(sheet);
    std::vector<Int3> vertex;
    for (const SheetVertex& v : sheet) vertex.push_back(c.body->grid.to_grid(v.X_mm));
    embedded = check_embedded(vertex, mesh->tri).empty();
  }
  if (!embedded) return refuse("the sheet would run through itself; expected less depth or a smaller outline");
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
  if (!any_seed && overlaps) return {.blade = {}, .reason = "this is undermined already", .nothing = true};
  if (!any_seed) blade.seed.assign(blade.seed.size(), 2);
  if (why = fits_grid(c, blade); !why.empty()) return refuse(why);
  return {std::move(blade), {}};
}

}  // namespace limberg
