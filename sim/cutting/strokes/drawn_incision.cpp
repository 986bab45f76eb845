#include "sim/cutting/strokes/drawn_incision.h"

#include <algorithm>
#include <cmath>

#include "sim/base/hash.h"
#include "sim/cutting/arrangement/tri_tests.h"
#include "sim/cutting/strokes/blade_parts.h"
#include "sim/cutting/strokes/stroke.h"
#include "sim/geometry/blade_angle.h"

namespace limberg {

namespace {

constexpr double kBeforeLeg = 2.0;  // mm: so much of a leg is left for its last piece
constexpr double kFold = 0.7;       // of a quad's length: how far its edge may run back
constexpr int kAsideUnits = 64;     // of the even grid: 8 micrometres

/// A vertex is moved a little, by its place alone: so a stroke hits the body's own vertices and edges hardly ever, and
/// the redrawing of a piece that does, which another division of the path would not see, is rare.
Int3 aside(Int3 p) {
  Hash64 h;
  h.add(p.x), h.add(p.y), h.add(p.z);
  const uint64_t r = h.value();
  const auto shift = [&](int bits) {
    return 2 * (int32_t((r >> bits & 0xfffff) % (2 * kAsideUnits + 1)) - kAsideUnits);
  };
  return {p.x + shift(0), p.y + shift(21), p.z + shift(42)};
}

}  // namespace

void DrawnIncision::follow(std::vector<Vec2> path) {
  for (Start* s : {&start_, &start_before_})
    if (s->kept != kAll) s->kept += path.size() - drawn_.size();
  drawn_ = std::move(path);
  start_at(start_);
}

void DrawnIncision::start_at(const Start& s) {
  start_ = s;
  path_ = drawn_;
  if (s.kept == kAll) return;
  path_.erase(path_.begin(), path_.end() - long(std::min(s.kept, path_.size())));
  path_.insert(path_.begin(), s.at);
}

double DrawnIncision::left_mm() const { return finished_ ? 0 : path_length(path_) - (committed_ > 0 ? last_arc_ : 0); }

double DrawnIncision::lean() const { return blade_lean(angle_deg_); }

/// Columns on every corner of the path and between, equally far apart on a segment, at most kSpacing.
/// A column depends on what lies before it and less than a hold after it. `corner_arc`: corners at which the blade
/// turns upright, those before the path going in and those of the path coming out.
std::vector<DrawnIncision::Place> DrawnIncision::places(std::span<const Vec2> path, double arc,
                                                        std::vector<double>& corner_arc) const {
  std::vector<Place> out{{path[0], arc, 1}};
  double way = 0, leg = leg_end(path, lean(), depth_), back_before = 0;
  for (size_t i = 1; i < path.size(); ++i) {
    const Vec2 d = path[i] - path[i - 1];
    const double length = d.norm();
    const int quads = equal_parts(length, kSpacing);
    for (int k = 1; k < quads; ++k) out.push_back({path[i - 1] + d * (double(k) / quads), arc + length * k / quads, 1});
    arc += length;
    way += length;
    out.push_back({path[i], arc, 1});
    if (i + 1 == path.size()) break;
    if (way == leg) {
      leg = leg_end(path, lean(), depth_, way);
      back_before = 0;
      continue;
    }
    // A mitred blade folds at a short quad beside a corner: on the inner side of the turn its edge would run backwards.
    const Vec2 e = path[i + 1] - path[i], a = d / length, b = e.normalized();
    const double sine = a.x() * b.y() - a.y() * b.x(), cosine = a.dot(b);  // sine > 0: to the left
    const double inside = sine * lean() < 0 ? depth_ + 2 * kWallExtra : 1.1 * kMargin;
    const double back = std::abs(sine) / std::max(1 + cosine, 0.1) * std::abs(lean()) * inside;
    const double last = length / quads, next = e.norm() / equal_parts(e.norm(), kSpacing);
    // On a curve it runs back at both ends of one quad.
    const bool folds = quads == 1 && back + back_before > length;
    if (folds || back > kFold * std::min(last, next)) corner_arc.push_back(arc);
    back_before = back;
  }
  const double reach = 3 * (depth_ + kMargin) * std::abs(lean()), ahead = std::min(reach, kHold - 0.1);
  for (Place& p : out)
    for (const double c : corner_arc)
      p.share = std::min(p.share, p.arc < c ? (c - p.arc) / ahead : (p.arc - c) / reach);
  return out;
}

bool DrawnIncision::begin(const BladeContext& c, bool last) {
  if (begun_) return true;
  const double length = path_length(path_);
  if (path_.size() < 2 || length < (last ? kShortest : hold_mm())) return false;
  if (rows_ == 0) {
    margin_ = margin_of(c);
    extra_ = wall_extra(c);
    rows_ = std::max(2, int(std::ceil((depth_ + extra_ + margin_) / kRowHeight)));
  }
  start_before_ = start_;
  if (c.arrangement) {
    if (!last) {  // over a hole: it begins where it comes out
      size_t out = 0;
      while (out < path_.size() && !skin_is_live(c, path_[out])) ++out;
      if (out == path_.size() || path_length(std::span(path_).subspan(out)) < kHold) return false;
    }
    overshoot_ = overshoot_of(c);
    start_wall_.reset();
    const WallMap walls(c);
    const int32_t join = may_join_start_ && may_go_back_ ? join_start(walls, path_, depth_ + extra_) : -1;
    if (join >= 0)
      start_wall_ = walls.columns()[size_t(join)], past_start_ = false;
    else
      past_start_ = may_go_back_ && attach_start(c, WoundMap(c), path_, overshoot_);
  }
  start_ = {path_[0], path_.size() - 1};
  return begun_ = path_.size() >= 2;
}

/// The path from a place on it becomes a blade of its own.
void DrawnIncision::begin_again(const Vec2& at, double arc) {
  Start start{at, 0};
  double here = 0;
  for (size_t i = 1; i < path_.size(); ++i) {
    here += (path_[i] - path_[i - 1]).norm();
    start.kept += here > arc + 1e-9;
  }
  start_at(start);
  begun_ = past_start_ = false;
  start_wall_.reset();
  committed_ = 0;
  column_.clear(), arc_mm_.clear(), end_point_.clear();
}

/// How many of the columns [first, count) a piece can have that does not cross or touch itself.
size_t DrawnIncision::uncrossed(std::span<const Place> place, size_t first, size_t count) const {
  std::vector<Vec2> way;
  for (size_t i = first; i < count; ++i) way.push_back(place[i].at);
  double limit = 1e300;  // along the piece
  for (const SelfCrossing& x : self_crossings(way)) limit = std::min(limit, (x.first + x.second) / 2);
  // An end that comes near the piece's own middle ends on it, once that is there.
  const double length = path_length(way);
  double arc = 0, best = kSnap;
  for (size_t i = 0; i + 1 < way.size(); ++i) {
    const double l = (way[i + 1] - way[i]).norm();
    if (const double d = distance_to_segment(way.back(), way[i], way[i + 1]); length - arc - l > kHold && d <= best)
      best = d, limit = std::min(limit, (arc + l + length) / 2);
    arc += l;
  }
  if (limit > length) return count;
  size_t end = first;
  arc = 0;
  while (end + 1 < count && arc + (place[end + 1].at - place[end].at).norm() <= limit) {
    arc += (place[end + 1].at - place[end].at).norm();
    ++end;
  }
  return std::max(end + 1, first + 2);
}

/// The end of the path is settled on the part behind column `hold`, the same one however the path was divided: it goes
/// on from an earlier wall's end, or is pushed through a wall, or stays.
void DrawnIncision::settle_end(const BladeContext& c, std::span<const Vec2> path, size_t hold,
                               std::vector<double>& corner, Way& way) const {
  std::vector<Vec2> tail{way.place[hold].at};
  const double from = way.place[hold].arc;
  double arc = 0;
  for (size_t i = 1; i < path.size(); ++i) {
    arc += (path[i] - path[i - 1]).norm();
    if (arc > from + 1e-9) tail.push_back(path[i]);
  }
  if (tail.size() > 1 && c.arrangement) {
    std::reverse(tail.begin(), tail.end());
    const WallMap walls(c);
    const int32_t own_end = end_point_.empty() ? -1 : end_point_[0];
    const int32_t join = may_join_end_ ? join_start(walls, tail, depth_ + extra_, own_end) : -1;
    if (join >= 0 && !(start_wall_ && start_wall_->point[0].point == walls.columns()[size_t(join)].point[0].point))
      way.end_wall = walls.columns()[size_t(join)];
    else
      way.past_end = attach_start(c, WoundMap(c), tail, overshoot_);
    std::reverse(tail.begin(), tail.end());
  }
  if (tail.size() > 1) {
    std::erase_if(corner, [&](double at) { return at > from; });
    const std::vector<Place> rest = places(tail, from, corner);
    way.place.resize(hold);
    way.place.insert(way.place.end(), rest.begin(), rest.end());
  }
  // A quad that is pushed through a wall is no seed, and one between two walls' ends has no column of its own: at
  // least one other is needed.
  const size_t free_ends =
      (committed_ == 0 && past_start_) + size_t(way.past_end) + (way.end_wall && committed_ == 0 && start_wall_);
  while (way.place.size() >= 2 && way.place.size() - 1 - way.first < 1 + free_ends) {
    Place middle;
    middle.at = (way.place[way.place.size() - 2].at + way.place.back().at) / 2;
    middle.arc = (way.place[way.place.size() - 2].arc + way.place.back().arc) / 2;
    way.place.insert(way.place.end() - 1, middle);
  }
  way.count = way.place.size();
}

/// The columns of the next piece; count 0: none can be cut yet.
DrawnIncision::Way DrawnIncision::way_ahead(const BladeContext& c, bool last) const {
  Way way;
  // Where the stroke leans into a sharp corner the leg ends, as soon as that is settled.
  std::vector<Vec2> path = path_;
  way.leg = leg_end(path_, lean(), depth_);
  const double before_leg = way.leg < 0 ? 1e300 : way.leg - kBeforeLeg;
  if (way.leg >= 0 && !last && path_length(path_) < way.leg + hold_mm()) way.leg = -1;
  if (way.leg >= 0) path = leg_of(path_, way.leg), last = true;
  std::vector<double> corner;
  way.place = places(path, 0, corner);
  way.first = committed_ > 0 ? committed_ - 1 : 0;
  // The last column that may be final: a hold before the end, and before a hole that the path has not come out of.
  size_t end = way.place.size() - 1;
  while (c.arrangement && end > committed_ && !skin_is_live(c, way.place[end].at)) --end;
  size_t hold = end;
  while (hold > 0 && way.place[hold].arc > way.place[end].arc - hold_mm()) --hold;
  hold = std::max(hold, way.first);
  while (!last && hold > way.first && way.place[hold].arc > before_leg) --hold;
  way.count = last ? way.place.size() : hold + 1;
  const size_t simple = uncrossed(way.place, way.first, way.count);
  const bool turns_back = simple < way.count;
  way.closing = last && !turns_back;
  if (turns_back) way.count = simple;
  if (way.closing) settle_end(c, path, hold, corner, way);
  if (way.count < way.first + (way.closing || turns_back ? 2 : 3)) way.count = 0;
  return way;
}

/// The blade over the columns of `way`, as near to what is asked as goes: a leaning piece that cannot be divided any
/// more turns upright, under a strongly curved skin its columns turn parallel. Nothing: it would run through itself.
std::optional<Blade> DrawnIncision::embedded(const BladeContext& c, const Way& way) {
  const bool may_turn_upright = lean() != 0 && way.count <= way.first + 3;
  for (const double most_share : {1.0, 0.5, 0.0}) {
    if (most_share < 1 && !may_turn_upright) break;
    std::vector<Place> upright = way.place;
    for (size_t i = way.first + 1; i < upright.size(); ++i) upright[i].share = std::min(upright[i].share, most_share);
    for (const double stiffness : kStiffness) {
      std::vector<Column> held = offered_.column;
      const std::vector<Column> stiff = stiffened(std::span(held).subspan(way.first), stiffness);
      std::copy(stiff.begin(), stiff.end(), held.begin() + long(way.first));
      Blade blade = strip(c, std::span(held).first(way.count), directions(c, held, upright, way.first), way);
      if (check_embedded(blade.vertex, blade.tri).empty()) return blade;
    }
  }
  return std::nullopt;
}

BladeResult DrawnIncision::next(const BladeContext& c, bool last) {
  if (finished_) return {};
  if (!begin(c, last))
    return last ? refuse("nothing of the stroke lies on uncut skin, or it is shorter than 1 mm") : BladeResult{};
  Way way = way_ahead(c, last);
  if (way.count == 0) return {};
  std::optional<Blade> blade;
  for (;;) {
    // A few columns more than are cut give the last ones their direction.
    offered_ = Piece{};
    offered_.column = column_;
    offered_.arc_mm = arc_mm_;
    for (size_t i = column_.size(); i < way.place.size() && i < way.count + 3; ++i) {
      const auto k = column_at(c, way.place[i].at);
      if (!k && i > way.count) break;
      if (!k) return refuse("the stroke leaves the skin");
      offered_.arc_mm.push_back(i == 0 ? 0 : offered_.arc_mm.back() + (k->X - offered_.column.back().X).norm());
      offered_.column.push_back(*k);
    }
    blade = embedded(c, way);
    if (blade || way.count <= way.first + 3) break;
    // What runs through itself is divided: the first half of it may not, and the second half crosses a wall then.
    way.count = way.first + std::max<size_t>(2, (way.count - way.first) / 2);
    way.closing = way.past_end = false;
    way.end_wall.reset();
  }
  offered_.joins_start = way.first == 0 && start_wall_.has_value();
  offered_.joins_end = way.closing && way.end_wall.has_value();
  if (!blade) {
    if (was_refused()) return next(c, last);
    return refuse("the blade would run through itself; expected a straighter path or less depth");
  }
  const size_t per_column = size_t(rows_) * 2;
  for (size_t i = 0; i < per_column && way.first == 0 && past_start_; ++i) blade->seed[i] = 0;
  for (size_t i = 0; i < per_column && way.past_end; ++i) blade->seed[blade->seed.size() - 1 - i] = 0;
  if (std::string why = fits_grid(c, *blade); !why.empty()) return refuse(why);
  offered_.end = way.count;
  offered_.end_at = way.place[way.count - 1].at;
  offered_.end_arc = way.place[way.count - 1].arc;
  offered_.closing = way.closing;
  if (way.closing) offered_.leg = way.leg;
  offered_.column.resize(way.count);
  offered_.arc_mm.resize(way.count);
  return {std::move(blade), {}};
}

/// Into the tissue, per column from `first` on: leaning to the right of the path, mitred at corners.
std::vector<Vec3> DrawnIncision::directions(const BladeContext& c, std::span<const Column> column,
                                            std::span<const Place> place, size_t first) const {
  const size_t n = column.size();
  // The tissue's state is looked at 4.5 mm around: that of the whole path would cost more with every piece.
  size_t from = first;
  while (from > 0 && place[first].arc - place[from].arc < 4.5) --from;
  std::vector<double> leans(n - 1, lean());
  if (c.gradient) {
    std::vector<Vec2> way;
    for (size_t i = from; i < n; ++i) way.push_back(place[i].at);
    const std::vector<double> near = leans_at_rest(c, way, column.subspan(from), lean());
    std::copy(near.begin(), near.end(), leans.begin() + long(from));
  }
  const auto right_of = [&](size_t a, size_t b, size_t i) {
    return (column[b].X - column[a].X).cross(column[i].normal).normalized();
  };
  std::vector<Vec3> out;
  for (size_t i = first; i < n; ++i) {
    const Vec3 before = i > 0 ? right_of(i - 1, i, i) : right_of(0, 1, 0);
    const Vec3 after = i + 1 < n ? right_of(i, i + 1, i) : before;
    const double lb = leans[i == 0 ? 0 : i - 1], la = leans[std::min(i, n - 2)];
    out.push_back(-column[i].normal +
                  (before + after) / std::max(1 + before.dot(after), 0.25) * ((la + lb) / 2 * place[i].share));
  }
  return out;
}

/// Columns x rows of quads, from above the skin down; the first column is that of the committed blade if there is one,
/// the first and the last may be those of earlier walls. `closing`: the diagonals of the last quads rise towards the
/// blade's end, so that no triangle lies wholly on its free border.
Blade DrawnIncision::strip(const BladeContext& c, std::span<const Column> column, std::span<const Vec3> direction,
                           const Way& way) {
  const size_t first = way.first;
  const bool closing = way.closing;
  const WallColumn* const end = closing && way.end_wall ? &*way.end_wall : nullptr;
  Blade blade;
  blade.strip = true;
  const double total = depth_ + extra_ + margin_;
  const auto level = [&](int r) { return total * r / rows_ - margin_; };  // below the skin
  const bool continues = first + 1 == committed_ && !end_point_.empty();
  const bool joins_start = first == 0 && start_wall_;
  const size_t own = first + joins_start, own_end = column.size() - (end != nullptr);
  for (size_t i = own; i < own_end; ++i)
    for (int r = 0; r <= rows_; ++r) {
      const int32_t shared = continues && i == first ? end_point_[size_t(r)] : -1;
      blade.shared_point.push_back(shared);
      blade.vertex.push_back(shared >= 0 ? c.arrangement->explicit_point(shared)
                                         : aside(c.body->grid.to_grid(column[i].X + direction[i - first] * level(r))));
    }
  offered_.end_vertex = int32_t(blade.vertex.size()) - (rows_ + 1);
  const auto id = [&](size_t i, int r) { return int32_t(i - own) * (rows_ + 1) + r; };
  const auto side = [&](size_t i) {
    StripSide s;
    for (int r = 0; r <= rows_; ++r) s.vertex.push_back(id(i, r)), s.level.push_back(level(r));
    s.arc = offered_.arc_mm[i];
    return s;
  };
  std::vector<std::pair<int32_t, int32_t>> known;
  const auto side_of = [&](const WallColumn& wall, size_t i) {
    StripSide s = side_of_wall(blade, c, wall, -1e300, depth_ + extra_, known);
    s.arc = offered_.arc_mm[i];
    return s;
  };
  const auto uv = [&](size_t i, int r) { return Eigen::Vector2f(float(offered_.arc_mm[i]), float(level(r))); };
  const auto add = [&](std::array<std::pair<size_t, int>, 3> v) {
    blade.tri.push_back({id(v[0].first, v[0].second), id(v[1].first, v[1].second), id(v[2].first, v[2].second)});
    blade.uv_mm.push_back({uv(v[0].first, v[0].second), uv(v[1].first, v[1].second), uv(v[2].first, v[2].second)});
  };
  if (joins_start) add_between(blade, side_of(*start_wall_, 0), side(own), 0, 0);
  for (size_t i = own; i + 1 < own_end; ++i)
    for (int r = 0; r < rows_; ++r) {
      const size_t j = i + 1;
      if (closing && j + 1 == column.size()) {
        add({{{i, r}, {i, r + 1}, {j, r + 1}}});
        add({{{i, r}, {j, r + 1}, {j, r}}});
      } else {
        add({{{i, r}, {i, r + 1}, {j, r}}});
        add({{{i, r + 1}, {j, r + 1}, {j, r}}});
      }
      blade.seed.push_back(level(r) <= 0);
      blade.seed.push_back(level(r) <= 0);
    }
  if (end) add_between(blade, side(own_end - 1), side_of(*end, own_end), 0, 0);
  blade.shared_point.resize(blade.vertex.size(), -1);
  return blade;
}

/// The next leg begins on the wall of this one.
void DrawnIncision::end_leg() {
  begin_again(part_of(path_, 0, offered_.leg).back(), offered_.leg);
  later_leg_ = true;
  may_join_start_ = false;
  extra_ = std::max(extra_ - kLegStep, 0.0);
}

void DrawnIncision::was_cut(const CutResult& result) {
  may_go_back_ = true, nothing_at_ = -1;
  if (committed_ == 0 && !offered_.joins_start && !past_start_ && !later_leg_) start_point_ = result.blade_point[0];
  if (offered_.closing && offered_.leg >= 0) return end_leg();
  if (offered_.closing) finished_ = true;
  column_ = std::move(offered_.column);
  arc_mm_ = std::move(offered_.arc_mm);
  committed_ = offered_.end;
  last_at_ = offered_.end_at, last_arc_ = offered_.end_arc;
  if (finished_) return;
  const auto top = result.blade_point.begin() + offered_.end_vertex;
  end_point_.assign(top, top + (rows_ + 1));
}

void DrawnIncision::was_nothing(const BladeContext& c) {
  if (offered_.closing && offered_.leg >= 0) return end_leg();
  if (offered_.closing) {
    finished_ = true;
    return;
  }
  if (!skin_is_live(c, offered_.end_at)) {  // over a hole: on with the same columns, and a blade of its own
    column_ = std::move(offered_.column);
    arc_mm_ = std::move(offered_.arc_mm);
    committed_ = offered_.end;
    last_at_ = offered_.end_at, last_arc_ = offered_.end_arc;
    end_point_.clear();
    return;
  }
  // Along an earlier cut: what comes next begins on whatever lies before it. Where a hand has turned back on its own
  // way that led back to where this piece began; then the next one begins where this one ended.
  begin_again(offered_.end_at, offered_.end_arc);
  const double at = path_length(drawn_) - path_length(path_);
  may_go_back_ = at > nothing_at_ + kKnot;
  nothing_at_ = std::max(nothing_at_, at);
}

bool DrawnIncision::was_refused() {
  if (offered_.joins_end && may_join_end_) {
    may_join_end_ = false;
    return true;
  }
  if (offered_.joins_start) {
    may_join_start_ = begun_ = false;
    start_wall_.reset();
    start_at(start_before_);
    return true;
  }
  if (!end_point_.empty()) {
    may_join_start_ = false;
    begin_again(last_at_, last_arc_);
    return true;
  }
  return false;
}

}  // namespace limberg
