#include "sim/cutting/strokes/drawn_stroke.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "sim/cutting/arrangement/store.h"
#include "sim/cutting/arrangement/tri_tests.h"
#include "sim/geometry/blade_angle.h"

namespace limberg {

namespace {

constexpr double kSettled = kCorner + double(kWindow) * kStep;  // behind this much more path a sample's kind is final
constexpr double kLeastWay = 1.0;                               // shorter free ways beside a run are none
constexpr double kPastStart = 4 * kSnap;  // an end goes so far past the beginning that it closes on
constexpr double kStub = 0.05;            // a crossing so near to an end may miss it at depth
constexpr double kShortestLoop = 10 * kSnap;

Vec2 point_at(std::span<const Vec2> path, double arc) {
  const std::vector<Vec2> p = part_of(path, std::clamp(arc, 0.0, path_length(path)), path_length(path));
  return p.empty() ? path.back() : p.front();
}

/// Where a path comes nearest to a point between two of its arc lengths, if within kSnap.
struct Passage {
  double arc = 0, distance = kSnap;
  Vec2 foot = Vec2::Zero();
};
std::optional<Passage> passage_by(std::span<const Vec2> path, const Vec2& point, double from, double to) {
  std::optional<Passage> best;
  double arc = 0;
  for (size_t i = 0; i + 1 < path.size(); ++i) {
    const Vec2 d = path[i + 1] - path[i];
    const double l = d.norm(), t = l > 0 ? std::clamp((point - path[i]).dot(d) / (l * l), 0.0, 1.0) : 0;
    const Vec2 foot = path[i] + t * d;
    const double here = arc + t * l, distance = (foot - point).norm();
    if (here > from && here < to && distance <= (best ? best->distance : kSnap)) best = {here, distance, foot};
    arc += l;
  }
  return best;
}

}  // namespace

std::string DrawnStroke::draw(const BladeContext& c, std::span<const ChartPoint> points) {
  if (std::string why = check_stroke(points, depth_); !why.empty()) return why;
  if (!blade_can_lean(angle_deg_)) return kBladeAngles;
  std::vector<Vec2> path = path_;
  Vec2 end = end_;
  for (const ChartPoint& p : points) {
    end = p;
    if (!path.empty() && (p - path.back()).norm() < kKnot) continue;
    if (!column_at(c, p)) {
      return fmt::format("the point ({:.2f}, {:.2f}) is not on the skin", p.x(), p.y());
    }
    path.push_back(p);
  }
  path_ = clear_of_start(without_curls(std::move(path)));
  end_ = end;
  return {};
}

/// A way along a wall begins where kLeastAlong of it are seen, and ends where the wall or the likeness does; until that
/// is clear the free way waits before it.
DrawnStroke::Stretch DrawnStroke::stretch(const BladeContext& c, const WallMap& walls, bool last) const {
  const double length = length_mm();
  if (walls.empty()) return {length, last};
  const AlongSamples s = samples_along(c, walls, path_, blade_lean(angle_deg_), depth_);
  const size_t n = s.along.size();
  const double settled = last ? length : length - kSettled;
  size_t i = std::min(n - 1, size_t(std::ceil(from_ / kStep - 1e-9)));
  if (along_) {
    const size_t first = i;
    for (; i < n; ++i) {
      const bool drifted = s.arc(i) - s.arc(first) >= kLeastAlong && s.drifts(first, i);
      if (s.along[i] && !drifted) continue;
      if (s.arc(i) > settled && !drifted) break;
      return {std::max(from_, s.arc(i > 0 ? i - 1 : 0)), true};
    }
    return {std::max(from_, std::min(settled, length)), last};
  }
  for (size_t j = i; i < n; i = j) {
    j = s.block_end(i);
    if (!s.along[i]) continue;
    const double from = s.arc(i), to = s.arc(j - 1), l = to - from;
    if ((l >= kLeastAlong || (last && l >= 0.8 * length)) && !s.drifts(i, j - 1)) return {std::max(from, from_), true};
    if (!last && to >= settled && l < kLeastAlong) return {std::max(from, from_), false};
  }
  if (last) return {length, true};
  // Near the end of the path the kind of a sample is not known yet where a wall is near.
  for (double at = std::max(settled, from_); at < length; at += kStep)
    if (walls.nearest(point_at(path_, at), kSnap).strip >= 0) return {at, false};
  return {length, false};
}

void DrawnStroke::begin_way(const BladeContext& c, double from, bool is_along) {
  from_ = from;
  along_ = is_along;
  along_from_ = from, along_limit_ = 1e300;
  if (is_along) return;
  free_ = DrawnIncision(depth_, angle_deg_);
  start_is_led_ = true;  // (the stroke's own beginning is another)
  start_ = point_at(path_, from);
  // Beyond a wall's end the stroke goes on from that end.
  const WallMap walls(c);
  const int32_t end = walls.open_end_near(start_, 2 * kSnap + kStep, depth_);
  if (end >= 0) start_ = walls.columns()[size_t(end)].chart;
}

/// After a part of a way along a wall could not be cut: half
/// of it is tried next; what is too short for that stays as
/// it is. False: it was all that there is to try now.
bool DrawnStroke::narrow() {
  const double to = std::min(offered_to_, along_limit_);
  if (to - along_from_ >= 2 * kLeastAlong) {
    along_limit_ = (along_from_ + to) / 2;
    return true;
  }
  along_from_ = to;
  along_limit_ = 1e300;
  return along_from_ < offered_to_ - 1e-9;
}

BladeResult DrawnStroke::deepen(const BladeContext& c, const Stretch& s) {
  offered_to_ = s.to;
  // Behind a sharp corner a leaning blade runs into what it has cut before the corner, and stays shallower there; an
  // upright one only crosses where the path does.
  const int32_t clear_of = angle_deg_ == 90 || !self_crossings(path_).empty() ? INT32_MAX : operations_before_;
  while (along_from_ < s.to - 1e-9) {
    BladeResult b = build_deepening(c, part_of(path_, along_from_, std::min(s.to, along_limit_)), level_, clear_of);
    if (b.blade) return b;
    if (b.folds) {
      if (!narrow()) break;
      continue;
    }
    if (along_limit_ >= s.to) break;
    along_from_ = along_limit_, along_limit_ = 1e300;  // nothing to cut in that half: the other one
  }
  return {};
}

/// The end is where it was drawn. One that was drawn past the stroke's own beginning ends there: across its first part,
/// or by it within kSnap.
void DrawnStroke::settle_end(const BladeContext& c) {
  while (path_.size() > 1 && (path_.back() - end_).norm() < kKnot) path_.pop_back();
  if (path_.back() != end_ && column_at(c, end_)) path_.push_back(end_);
  const double length = length_mm();
  if (path_.size() <= 3 || length < kShortestLoop) return;
  for (const SelfCrossing& x : self_crossings(path_))
    if (x.first <= kPastStart && x.second >= length - kPastStart) {
      path_ = part_of(path_, any_cut_ ? 0 : x.first, x.second);
      if (!any_cut_) start_ = path_.back() = path_[0];
      return;
    }
  if (const auto by = passage_by(path_, path_[0], length - kPastStart, length)) path_ = part_of(path_, 0, by->arc);
}

BladeResult DrawnStroke::next(const BladeContext& c, bool last) {
  offered_ = none;
  if (path_.empty()) return last ? refuse("the stroke has no points") : BladeResult{};
  if (operations_before_ < 0) {
    operations_before_ = c.arrangement ? int32_t(c.arrangement->store().op.size()) : 0;
    level_ = depth_ + wall_extra(c);
    start_ = path_[0];
  }
  if (last && !over_) {
    over_ = true;
    settle_end(c);
  }
  if (!earlier_) earlier_ = std::make_shared<const WallMap>(c, operations_before_);
  const WallMap& walls = *earlier_;
  for (int ways = 0; ways < 1000; ++ways) {
    const Stretch s = stretch(c, walls, last);
    if (along_) {
      BladeResult b = s.to > std::max(from_, nothing_to_) ? deepen(c, s) : BladeResult{};
      if (b.blade || !b.reason.empty()) {
        offered_ = along;
        return b;
      }
    } else {
      if (auto blade = lead_start_through(c)) {
        offered_ = start_wall;
        return {std::move(blade), {}};
      }
      std::vector<Vec2> way{start_};
      double arc = 0;
      for (size_t i = 1; i < path_.size(); ++i) {
        arc += (path_[i] - path_[i - 1]).norm();
        const bool leaves_start = from_ > 0 && way.size() == 1 && (path_[i] - start_).norm() < kSnap;
        if (arc > from_ + 1e-9 && arc <= s.to + 1e-9 && !leaves_start) way.push_back(path_[i]);
      }
      const bool to_wall = s.ends && s.to < length_mm() - 1e-9;
      if (to_wall) {  // up to where a wall begins
        Vec2 p = point_at(path_, s.to);
        const WallMap all(c);
        const int32_t end = all.open_end_near(p, 2 * kSnap + kStep, depth_);
        if (end >= 0) p = all.columns()[size_t(end)].chart;
        while (way.size() > 1 && (way.back() - p).norm() < kSnap) way.pop_back();
        way.push_back(p);
      }
      const bool too_short = (from_ > 0 || to_wall) && path_length(way) < kLeastWay;
      if (!too_short || !s.ends) {
        free_.follow(std::move(way));
        BladeResult b = free_.next(c, s.ends);
        if (b.blade || !b.reason.empty()) {
          offered_ = free_way;
          any_free_ = true;
          return b;
        }
      }
    }
    if (!s.ends || s.to >= length_mm() - 1e-9) return {};
    begin_way(c, s.to, !along_);
  }
  return refuse("the stroke changes between free and earlier cuts too often");
}

/// When the stroke has passed its own beginning within kSnap without crossing it: a blade from there through that wall.
std::optional<Blade> DrawnStroke::lead_start_through(const BladeContext& c) {
  if (start_is_led_ || !c.arrangement || free_.start_point() < 0) return std::nullopt;
  const double ahead = free_.left_mm(), reached = length_mm() - (ahead > 0 ? ahead + 1 : 0);
  const auto by = passage_by(path_, start_, kFarAlong, reached);
  if (!by) return std::nullopt;
  start_is_led_ = true;
  for (const SelfCrossing& x : self_crossings(path_))
    if (x.first > kStub && x.first < kPastStart && std::abs(x.second - by->arc) < kPastStart)
      return std::nullopt;  // it crosses there
  const WallMap walls(c);
  const WallColumn* column = nullptr;
  for (const WallColumn& k : walls.columns())
    for (const WallPoint& p : k.point)
      if (p.point == free_.start_point() && k.is_end()) column = &k;
  if (!column) return std::nullopt;
  const Vec2 way = by->distance > kStub ? Vec2((by->foot - start_).normalized())
                                        : walls.outward(int32_t(column - walls.columns().data()));
  const Vec2 beyond = by->foot + way * overshoot_of(c);
  Blade blade;
  blade.strip = true;
  const double level = free_.level_mm(), margin = margin_of(c);
  std::vector<std::pair<int32_t, int32_t>> known;
  StripSide left = side_of_wall(blade, c, *column, -1e300, level, known);
  left.arc = 0;
  for (const double share : {0.5, 1.0}) {  // only the first half is a seed
    const Vec2 at = column->chart + share * (beyond - column->chart);
    const auto k = column_at(c, at);
    if (!k) return std::nullopt;
    StripSide right;
    const int rows = std::max(2, int(std::ceil((level + margin) / kRowHeight)));
    for (int r = 0; r <= rows; ++r) {
      right.vertex.push_back(int32_t(blade.vertex.size()));
      right.level.push_back((level + margin) * r / rows - margin);
      blade.vertex.push_back(c.body->grid.to_grid(k->X + column->down * right.level.back()));
    }
    right.arc = share * (beyond - column->chart).norm();
    const size_t before = blade.seed.size();
    add_between(blade, left, right, 0, 0);
    if (share == 1) std::fill(blade.seed.begin() + long(before), blade.seed.end(), uint8_t(0));
    left = right;
  }
  blade.shared_point.resize(blade.vertex.size(), -1);
  if (!check_embedded(blade.vertex, blade.tri).empty() || !fits_grid(c, blade).empty()) return std::nullopt;
  return blade;
}

void DrawnStroke::was_cut(const CutResult& result) {
  any_cut_ = true;
  if (offered_ == free_way) free_.was_cut(result);
  if (offered_ == along && along_limit_ < offered_to_) along_from_ = along_limit_, along_limit_ = 1e300;
}

void DrawnStroke::was_nothing(const BladeContext& c) {
  if (offered_ == free_way) free_.was_nothing(c);
  if (offered_ != along) return;
  if (along_limit_ < offered_to_)
    along_from_ = along_limit_, along_limit_ = 1e300;
  else
    nothing_to_ = offered_to_;
}

bool DrawnStroke::was_refused() {
  if (offered_ == along) return narrow() || (nothing_to_ = offered_to_, true);
  return offered_ == start_wall || (offered_ == free_way && free_.was_refused());
}

CutResult DrawnStroke::cut(const BladeContext& c, bool last, const MakeCut& make_cut) {
  constexpr int kMostBlades = 4000;  // of one call: far more than a path of 2000 points needs
  CutResult all;
  all.status = CutResult::nothing_to_cut;
  const auto refused = [&](std::string why) {
    CutResult r;
    r.reason = std::move(why);
    return r;
  };
  for (int blades = 0;; ++blades) {
    if (blades == kMostBlades)
      return refused("one piece of a stroke makes too many cuts; shorter pieces were expected");
    const BladeResult blade = next(c, last);
    if (!blade.blade && !blade.reason.empty()) return refused(blade.reason);
    if (!blade.blade) break;
    CutResult one = make_cut(*blade.blade);
    if (one.ok()) {
      was_cut(one);
      one.wall_faces += all.wall_faces, one.patches += all.patches, one.patches_kept += all.patches_kept;
      all = std::move(one);
    } else if (one.status == CutResult::nothing_to_cut) {
      was_nothing(c);  // over a hole, or along an earlier cut
    } else if (!was_refused()) {
      return one;
    }
  }
  if (last && !all.ok()) all.reason = any_free_ ? "nothing of the stroke lies on uncut skin" : "this is cut already";
  return all;
}

CutResult cut_whole(const BladeContext& c, std::span<const ChartPoint> path, double depth_mm, double angle_deg,
                    bool spline, const MakeCut& make_cut) {
  CutResult r;
  if (r.reason = check_stroke(path, depth_mm); !r.reason.empty()) return r;
  std::vector<Vec2> drawn(path.begin(), path.end());
  if (spline) drawn = spline_through(drawn, 0.5);
  drawn = drop_close(simplify(drawn, kSimplify), kKnot);
  DrawnStroke stroke(depth_mm, angle_deg);
  if (r.reason = stroke.draw(c, drawn); !r.reason.empty()) return r;
  return stroke.cut(c, true, make_cut);
}

CutResult incise(Arrangement& a, BladeContext c, std::span<const ChartPoint> path, double depth_mm, double angle_deg,
                 uint64_t seed, bool spline, int* cuts) {
  c.arrangement = &a;
  int made = 0;
  CutResult r = cut_whole(c, path, depth_mm, angle_deg, spline, [&](const Blade& b) {
    CutResult one = a.cut(b, seed + uint64_t(made));
    made += one.ok();
    return one;
  });
  for (; !r.ok() && made > 0; --made) a.undo();
  if (cuts) *cuts = made;
  return r;
}

}  // namespace limberg
