#include "sim/cutting/strokes/blade_continue.h"

#include <algorithm>
#include <cmath>

#include "sim/cutting/arrangement/store.h"
#include "sim/cutting/arrangement/tri_tests.h"

namespace limberg {

namespace {

constexpr double kAlong = 0.9;  // cosine between a stroke and the wall that it runs along

}  // namespace

StripSide side_of_wall(Blade& blade, const BladeContext& c, const WallColumn& column, double from, double to,
                       std::vector<std::pair<int32_t, int32_t>>& known) {
  StripSide side;
  const auto add = [&](int32_t point, const Int3& at, double level) {
    side.vertex.push_back(int32_t(blade.vertex.size()));
    side.level.push_back(level);
    blade.shared_point.resize(blade.vertex.size(), -1);
    blade.vertex.push_back(at);
    blade.shared_point.push_back(point);
  };
  double last = from;
  for (const WallPoint& p : column.point) {
    if (p.level < from - 1e-3) continue;
    // Of two known points around the depth asked the nearer one is the foot: no point may lie between known ones.
    if (!side.level.empty() && (last >= to - kSameDepth || (p.level > to + kSameDepth && p.level - to > to - last)))
      break;
    last = p.level;
    const auto it = std::find_if(known.begin(), known.end(), [&](const auto& k) { return k.first == p.point; });
    if (it != known.end()) {
      side.vertex.push_back(it->second);
      side.level.push_back(p.level);
      continue;
    }
    known.push_back({p.point, int32_t(blade.vertex.size())});
    add(p.point, c.arrangement->explicit_point(p.point), p.level);
  }
  const bool at_foot = !column.point.empty() && last >= column.point.back().level;
  if (!at_foot || last >= to - kSameDepth) return side;
  // New points are named by their column, so that both strips beside it have the same.
  const int32_t name = -2 - column.point.back().point;
  const int rows = std::max(1, int(std::ceil((to - last) / kRowHeight)));
  for (int r = 1; r <= rows; ++r) {
    const double level = last + (to - last) * r / rows;
    const auto it =
        r == 1 ? std::find_if(known.begin(), known.end(), [&](const auto& k) { return k.first == name; }) : known.end();
    if (it != known.end()) {
      for (int q = 0; q < rows; ++q) {
        side.vertex.push_back(it->second + q);
        side.level.push_back(last + (to - last) * (q + 1) / rows);
      }
      break;
    }
    if (r == 1) known.push_back({name, int32_t(blade.vertex.size())});
    add(-1, c.body->grid.to_grid(column.X_mm + column.down * level), level);
  }
  return side;
}

void add_between(Blade& blade, const StripSide& left, const StripSide& right, uint8_t seed_other, uint8_t seed_top) {
  size_t i = 0, j = 0;
  while (i + 1 < left.vertex.size() || j + 1 < right.vertex.size()) {
    const bool down_left =
        i + 1 < left.vertex.size() && (j + 1 == right.vertex.size() || left.level[i + 1] <= right.level[j + 1]);
    const auto corner = [&](const StripSide& s, size_t k) {
      return std::pair(s.vertex[k], Eigen::Vector2f(float(s.arc), float(s.level[k])));
    };
    const auto a = corner(left, i), b = down_left ? corner(left, i + 1) : corner(right, j + 1), d = corner(right, j);
    blade.tri.push_back({a.first, b.first, d.first});
    blade.uv_mm.push_back({a.second, b.second, d.second});
    const bool top = i == 0 && j == 0, crosses_skin = a.second.y() <= 0 || d.second.y() <= 0;
    blade.seed.push_back(crosses_skin ? 1 : top ? seed_top : seed_other);
    ++(down_left ? i : j);
  }
}

int32_t join_start(const WallMap& walls, std::vector<Vec2>& path, double level, int32_t not_point) {
  const int32_t end = walls.open_end_near(path[0], kSnap, level, not_point);
  if (end < 0) return -1;
  const Vec2 place = walls.columns()[size_t(end)].chart;
  size_t next = 1;
  while (next + 1 < path.size() && (path[next] - place).norm() < kSnap) ++next;
  std::vector<Vec2> joined(path.begin() + long(next), path.end());
  joined.insert(joined.begin(), place);
  if ((joined[1] - place).norm() < kSnap) return -1;
  if (-heading_at_start(joined, 2).dot(walls.outward(end)) < kDoublesBack) return -1;
  path = std::move(joined);
  return end;
}

namespace {

/// The walls that a stroke has cut so far, to tell whether its next piece runs through them.
class OwnWalls {
 public:
  OwnWalls(const BladeContext& c, int32_t first_operation) {
    if (!c.arrangement) return;
    const ArrangementStore& store = c.arrangement->store();
    if (size_t(first_operation) >= store.op.size()) return;
    for (size_t g = size_t(store.op[size_t(first_operation)].first_orig); g < store.orig.size(); ++g) {
      const OrigTri& o = store.orig[g];
      if (o.live == 0) continue;
      IntTriangle t;
      t.id = o.v;
      for (size_t k = 0; k < 3; ++k) t.p[k] = store.points.integer(o.v[k]);
      wall_.push_back(t);
      box_.push_back(box_around(t.p[0], t.p[1], t.p[2]));
    }
  }
  bool met_by(const Blade& blade) const {
    if (wall_.empty()) return false;
    for (const Tri& tri : blade.tri) {
      IntTriangle t;
      for (size_t k = 0; k < 3; ++k) {
        const int32_t shared = blade.shared_point[size_t(tri[k])];
        t.id[k] = shared >= 0 ? shared : INT32_MAX - tri[k];
        t.p[k] = blade.vertex[size_t(tri[k])];
      }
      const IntBox box = box_around(t.p[0], t.p[1], t.p[2]);
      for (size_t w = 0; w < wall_.size(); ++w)
        if (box.meets(box_[w]) && meet_beyond_shared(t, wall_[w])) return true;
    }
    return false;
  }

 private:
  std::vector<IntTriangle> wall_;
  std::vector<IntBox> box_;
};

}  // namespace

BladeResult build_deepening(const BladeContext& c, std::span<const Vec2> path, double to, int32_t clear_of) {
  const WallMap walls(c);
  // The strips that the path runs along: those whose middle it passes.
  std::vector<int32_t> strips;
  bool any = false;
  for (size_t i = 0; i < walls.strips().size(); ++i) {
    const WallStrip& t = walls.strips()[i];
    const Vec2 &a = walls.columns()[size_t(t.column[0])].chart, &b = walls.columns()[size_t(t.column[1])].chart;
    const Vec2 along = (b - a).normalized();
    bool runs_along = false;
    for (size_t k = 0; k + 1 < path.size() && !runs_along; ++k)
      runs_along = distance_to_segment((a + b) / 2, path[k], path[k + 1]) <= 1.5 * kSnap &&
                   std::abs((path[k + 1] - path[k]).normalized().dot(along)) >= kAlong;
    if (!runs_along) continue;
    any = true;
    if (t.live && t.level < to - kSameDepth) strips.push_back(int32_t(i));
  }
  if (!any) return refuse("no earlier cut runs along the stroke");
  if (strips.empty()) return {.blade = {}, .reason = "this is cut already", .nothing = true};
  const auto level_at = [&](int32_t column, int32_t point) {
    for (const WallPoint& p : walls.columns()[size_t(column)].point)
      if (p.point == point) return p.level;
    return 0.0;
  };
  std::vector<double> foot(walls.columns().size(), to);  // per column: how deep it is to be
  const auto assemble = [&](std::span<const int32_t> some) {
    Blade blade;
    blade.strip = true;
    std::vector<std::pair<int32_t, int32_t>> known;
    for (int32_t i : some) {
      const WallStrip& t = walls.strips()[size_t(i)];
      std::array<StripSide, 2> side;
      for (size_t k = 0; k < 2; ++k) {
        const int32_t column = t.column[k];
        side[k] = side_of_wall(blade, c, walls.columns()[size_t(column)], level_at(column, t.front[k]),
                               foot[size_t(column)], known);
        side[k].arc = kSpacing * column;  // the same for the strips on both sides of a column
      }
      add_between(blade, side[0], side[1], 0, 3);
    }
    blade.shared_point.resize(blade.vertex.size(), -1);
    return blade;
  };
  Blade blade = assemble(strips);
  std::string shallower;
  if (blade.tri.empty()) return {.blade = {}, .reason = "this is cut already", .nothing = true};
  const OwnWalls own(c, clear_of);
  const auto is_sound = [&](const Blade& b) { return check_embedded(b.vertex, b.tri).empty() && !own.met_by(b); };
  if (!is_sound(blade)) {
    // Columns that lean towards each other meet at some depth:
    // there it stays shallower. Strip by strip, as deep as goes.
    std::vector<int32_t> fitting;
    std::vector<uint8_t> placed(walls.columns().size(), 0);
    const auto fits = [&] {
      const Blade b = assemble(fitting);
      return b.tri.empty() || is_sound(b);
    };
    for (int32_t i : strips) {
      const WallStrip& t = walls.strips()[size_t(i)];
      fitting.push_back(i);
      bool ok = fits();
      for (const double share : {0.6, 0.3, 0.0}) {
        if (ok) break;
        for (size_t k = 0; k < 2; ++k) {
          const double from = level_at(t.column[k], t.front[k]);
          if (!placed[size_t(t.column[k])]) foot[size_t(t.column[k])] = from + share * (to - from);
        }
        ok = fits();
      }
      if (ok) {
        for (int32_t k : t.column) placed[size_t(k)] = 1;
        continue;
      }
      fitting.pop_back();
      for (int32_t k : t.column)
        if (!placed[size_t(k)]) foot[size_t(k)] = to;
    }
    blade = assemble(fitting);
    shallower = "at a sharp corner it stays shallower: there it would run through itself";
    if (blade.tri.empty())
      return {.blade = {},
              .reason = "the deeper blade would run through itself; expected less depth or a straighter path",
              .folds = true};
  }
  if (std::string why = fits_grid(c, blade); !why.empty()) return refuse(why);
  return {std::move(blade), std::move(shallower)};
}

}  // namespace limberg
