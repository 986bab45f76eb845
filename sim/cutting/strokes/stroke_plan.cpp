#include "sim/cutting/strokes/stroke_plan.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <numbers>

#include "sim/cutting/arrangement/handles.h"
#include "sim/cutting/strokes/blade_continue.h"
#include "sim/cutting/strokes/blade_parts.h"
#include "sim/cutting/strokes/stroke_runs.h"
#include "sim/geometry/blade_angle.h"

namespace limberg {

namespace {

constexpr double kLeastPart = 2.0;  // of a stroke that is divided where its blade would fold
constexpr double kLeastFree = 1.2;  // what is left over between other parts is not a cut of its own
constexpr int kMostDivided = 5;
constexpr double kLeastShare = 0.2;  // of the depth, where the whole of it would fold
constexpr int kMostRounds = 4;       // of deepening through sharp corners

/// A stroke that comes back to its own beginning, as a closed path; else as it was.
std::vector<Vec2> closed_when_meant(std::vector<Vec2> path) {
  const double length = path_length(path);
  if (path.size() < 4 || length < 10 * kSnap) return path;
  // Past its beginning: the last crossing of its first and its last 2 mm.
  for (const SelfCrossing& x : self_crossings(path))
    if (x.first <= 4 * kSnap && x.second >= length - 4 * kSnap) {
      path = part_of(path, x.first, x.second);
      path.back() = path.front();
      return path;
    }
  if ((path.front() - path.back()).norm() <= kSnap) path.back() = path.front();
  return path;
}

/// Arc lengths at which a path is to be divided so that no part crosses itself, nor ends beside itself. Does it begin
/// beside itself?
std::vector<double> divisions(std::span<const Vec2> path, bool& start_touches) {
  const double length = path_length(path);
  std::vector<double> cut;
  const auto separate = [&](double a, double b) {  // a < b: passages of one place
    for (double s : cut)
      if (s > a && s < b) return;
    cut.push_back((a + b) / 2);
  };
  for (const SelfCrossing& x : self_crossings(path)) separate(x.first, x.second);
  const auto near_own_middle = [&](const Vec2& end, bool is_start) -> std::optional<double> {
    double arc = 0, best = kSnap;
    std::optional<double> where;
    for (size_t i = 0; i + 1 < path.size(); ++i) {
      const Vec2 d = path[i + 1] - path[i];
      const double l = d.norm(), t = l > 0 ? std::clamp((end - path[i]).dot(d) / (l * l), 0.0, 1.0) : 0;
      const double here = arc + t * l, way = is_start ? here : length - here, distance = (path[i] + t * d - end).norm();
      if (way > kFarAlong && distance <= best) best = distance, where = here;
      arc += l;
    }
    return where;
  };
  const auto start = near_own_middle(path.front(), true);
  start_touches = start.has_value();
  if (start) separate(0, *start);
  if (const auto a = near_own_middle(path.back(), false)) separate(*a, length);
  std::sort(cut.begin(), cut.end());
  return cut;
}

/// A piece of a stroke, and how often it was divided because its blade would have run through itself.
struct Part {
  StrokePiece piece;
  int divided = 0;
  double share = 1;       // of the depth asked
  bool may_fail = false;  // it only deepens what was made
};

/// A path as its legs.
void add_legs(StrokePlan& plan, std::vector<Vec2> path, bool along, double lean) {
  bool on_leg = false;
  for (;;) {
    const double end = leg_end(path, lean, plan.depth_mm);
    if (end < 0) break;
    plan.piece.push_back({along ? part_of(path, 0, end) : leg_of(path, end), along, on_leg});
    path = part_of(path, end, path_length(path));
    on_leg = true;
  }
  plan.piece.push_back({std::move(path), along, on_leg});
}

/// The sharpest corner of a path that leaves parts of a length on both sides; the middle of what deepens a wall,
/// because walls cross one another anywhere. 0: nowhere.
double where_to_divide(const StrokePiece& piece) {
  const double length = path_length(piece.path);
  if (piece.along) return length > 2 * kLeastAlong ? length / 2 : 0;
  const std::vector<Vec2> path = drop_close(simplify(piece.path, kSimplify), kKnot);
  double arc = 0, best = 0, sharpest = 0.97;  // cosine
  for (size_t i = 1; i + 1 < path.size(); ++i) {
    arc += (path[i] - path[i - 1]).norm();
    const double cosine = (path[i] - path[i - 1]).normalized().dot((path[i + 1] - path[i]).normalized());
    if (cosine < sharpest && arc > kLeastPart && path_length(path) - arc > kLeastPart) sharpest = cosine, best = arc;
  }
  if (best == 0) return 0;
  // The same place on the path as it was drawn.
  const Vec2 corner = part_of(path, 0, best).back();
  double along = 0, nearest = 1e300, where = 0;
  for (size_t i = 0; i < piece.path.size(); ++i) {
    if (i > 0) along += (piece.path[i] - piece.path[i - 1]).norm();
    if ((piece.path[i] - corner).norm() < nearest) nearest = (piece.path[i] - corner).norm(), where = along;
  }
  return where > kLeastPart && where < length - kLeastPart ? where : 0;
}

}  // namespace

StrokePlan plan_stroke(const BladeContext& c, std::span<const ChartPoint> stroke, double depth_mm, double angle_deg,
                       bool spline) {
  StrokePlan plan;
  plan.depth_mm = depth_mm;
  plan.angle_deg = angle_deg;
  plan.reason = check_stroke(stroke, depth_mm);
  if (!plan.reason.empty()) return plan;
  std::vector<Vec2> drawn(stroke.begin(), stroke.end());
  if (spline) drawn = spline_through(drawn, 0.5);
  const WallMap walls(c);
  const std::vector<Vec2> clean = drop_close(simplify(drawn, kSimplify), kKnot);
  const bool simple = clean.size() < 2 || !blade_can_lean(angle_deg);
  const double lean = simple ? 0 : 1 / std::tan(angle_deg * std::numbers::pi / 180);
  std::vector<Run> runs;
  if (!simple && !walls.empty()) runs = runs_along(samples_along(c, walls, clean, lean, depth_mm));
  const bool any_along = std::any_of(runs.begin(), runs.end(), [](const Run& r) { return r.along; });
  const std::vector<Vec2> path = simple || any_along ? clean : closed_when_meant(clear_of_start(without_curls(clean)));
  const auto add_free = [&](const std::vector<Vec2>& part) {
    double from = 0;
    bool start_touches = false;
    std::vector<double> ends = divisions(part, start_touches);
    ends.push_back(path_length(part));
    const size_t first = plan.piece.size();
    size_t second = first;
    for (double to : ends) {
      add_legs(plan, part_of(part, from, to), false, lean);
      if (from == 0) second = plan.piece.size();
      from = to;
    }
    // What the beginning may end on must be there first.
    if (start_touches)
      std::rotate(plan.piece.begin() + long(first), plan.piece.begin() + long(second), plan.piece.end());
  };
  if (!any_along) {
    const bool closed = path.size() > 3 && (path.front() - path.back()).norm() <= 0.1;
    bool start_touches = false;
    if (simple || (closed ? !meets_itself(std::span(path).first(path.size() - 1), true)
                          : divisions(path, start_touches).empty())) {
      if (!closed && leg_end(path, lean, depth_mm) >= 0)
        add_legs(plan, path, false, lean);
      else
        plan.piece.push_back({path == clean ? drawn : path});  // as it was drawn
      return plan;
    }
    add_free(path);
    return plan;
  }
  for (const Run& r : runs)
    if (r.along) add_legs(plan, part_of(path, r.from, r.to), true, lean);
  for (size_t i = 0; i < runs.size(); ++i) {
    if (runs[i].along) continue;
    std::vector<Vec2> part = part_of(path, runs[i].from, runs[i].to);
    // Beyond a wall's end the stroke goes on from that end.
    const auto from_end = [&](Vec2& p) {
      const int32_t end = walls.open_end_near(p, 2 * kSnap + kStep, depth_mm);
      if (end >= 0) p = walls.columns()[size_t(end)].chart;
    };
    if (i > 0) from_end(part.front());
    if (i + 1 < runs.size()) from_end(part.back());
    add_free(part);
  }
  return plan;
}

CutResult carry_out(const StrokePlan& plan, const BladeContext& c, const std::function<CutResult(const Blade&)>& cut,
                    const std::function<void()>& take_back) {
  CutResult all;
  all.reason = plan.reason;
  if (plan.piece.empty()) return all;
  int made = 0, faces = 0, patches = 0, kept = 0;
  double leg_level = 1e300;  // of the foot of what was cut last
  std::string nothing;
  std::deque<Part> parts;
  std::vector<StrokePiece> deepened;
  for (const StrokePiece& piece : plan.piece) {
    parts.push_back({piece});
    if (piece.along) deepened.push_back(piece);
  }
  // Where a deepening was cut in parts, or had to stay shallower at a corner, what is left may go now that this is
  // there. A leaning one may then be led into its own wall and leave a bridge of tissue: what does is taken back.
  const bool upright = std::abs(plan.angle_deg - 90) < 1;
  bool unfinished = false;
  for (int rounds = 0; !parts.empty() || unfinished;) {
    if (parts.empty()) {
      unfinished = false;
      if (++rounds == kMostRounds) break;
      for (const StrokePiece& piece : deepened) parts.push_back({piece, 0, 1, true});
    }
    const Part part = std::move(parts.front());
    const StrokePiece& piece = part.piece;
    parts.pop_front();
    if (!piece.along && (plan.piece.size() > 1 || part.divided > 0) &&
        path_length(drop_close(simplify(piece.path, kSimplify), kKnot)) < kLeastFree)
      continue;
    CutResult r;
    bool folds = false, shallower = false;
    double depth = plan.depth_mm * part.share;
    if (piece.on_leg && !piece.along) depth = std::min(depth, leg_level - kLegStep - wall_extra(c));
    const double level = depth + wall_extra(c);
    for (const Joins joins : {piece.on_leg ? Joins::at_end : Joins::any, Joins::none}) {
      const BladeResult b = piece.along ? build_deepening(c, piece.path, depth + wall_extra(c))
                                        : build_incision(c, piece.path, depth, plan.angle_deg, joins);
      r = CutResult{};
      r.reason = b.reason;
      folds = b.folds;
      shallower = b.blade && !b.reason.empty();
      if (b.nothing) r.status = CutResult::nothing_to_cut;
      // A part of a curve may run through the part before it, too: then it is made shallower first.
      const bool part_of_curve = !piece.along && part.divided > 0 && part.share > kLeastShare;
      const bool may_bridge = b.blade && !upright && (rounds > 0 || part.may_fail || part_of_curve);
      const int64_t chi = may_bridge ? euler_characteristic(*c.arrangement) : 0;
      if (b.blade) r = cut(*b.blade);
      if (may_bridge && r.ok() && euler_characteristic(*c.arrangement) != chi) {
        take_back();
        r = CutResult{};
        r.reason = "the deeper blade would leave a bridge of tissue at a sharp corner";
        folds = part_of_curve;
      }
      if (r.status != CutResult::refused || !b.blade || b.blade->shared_point.empty()) break;
    }
    if ((folds || (piece.along && r.status == CutResult::refused)) && part.divided < kMostDivided)
      if (const double at = where_to_divide(piece); at > 0) {
        const double length = path_length(piece.path);
        parts.push_front({{part_of(piece.path, at, length), piece.along}, part.divided + 1, 1, part.may_fail});
        parts.push_front({{part_of(piece.path, 0, at), piece.along, piece.on_leg}, part.divided + 1, 1, part.may_fail});
        continue;
      }
    if (folds && !piece.along &&
        part.share > kLeastShare) {  // first a shallower cut, then deeper along it where that goes
      parts.push_front({piece, part.divided, part.share / 2});
      continue;
    }
    if (r.status == CutResult::refused && part.may_fail) continue;
    if (r.status == CutResult::refused) {
      for (; made > 0; --made) take_back();
      return r;
    }
    if (r.status == CutResult::nothing_to_cut) {
      nothing = r.reason;
      continue;
    }
    if (part.share < 1 && !piece.along && r.ok()) {
      deepened.push_back({piece.path, true});
      parts.push_front({deepened.back(), kMostDivided, 1, true});
    }
    unfinished = unfinished || (piece.along && (shallower || part.divided > 0));
    ++made;
    leg_level = level;
    faces += r.wall_faces;
    patches += r.patches;
    kept += r.patches_kept;
    all = r;
  }
  if (made == 0) {
    all.status = CutResult::nothing_to_cut;
    all.reason = nothing;
    return all;
  }
  all.wall_faces = faces;
  all.patches = patches;
  all.patches_kept = kept;
  return all;
}

CutResult incise(Arrangement& a, BladeContext c, std::span<const ChartPoint> path, double depth_mm, double angle_deg,
                 uint64_t seed, bool spline, int* cuts) {
  c.arrangement = &a;
  int made = 0;
  const CutResult r = carry_out(
      plan_stroke(c, path, depth_mm, angle_deg, spline), c,
      [&](const Blade& b) {
        CutResult one = a.cut(b, seed + uint64_t(made));
        made += one.ok();
        return one;
      },
      [&] {
        a.undo();
        --made;
      });
  if (cuts) *cuts = made;
  return r;
}

}  // namespace limberg
