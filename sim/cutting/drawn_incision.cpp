#include "sim/cutting/drawn_incision.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/cutting/tri_tests.h"
#include "sim/hash.h"

namespace limberg {

namespace {

constexpr double kRowHeight = 2.5;  // along the blade's depth
constexpr double kShortest = 1.0;   // of a stroke
constexpr double kLeast = 0.3;      // of a quad, in shares of kSpacing
constexpr double kFold = 0.7;       // of a quad's length: how far its edge may run back
constexpr int kAsideUnits = 64;     // of the even grid: 8 micrometres

/// A vertex is moved a little, by its place alone: so a stroke hits the body's own vertices and edges hardly ever, and the
/// redrawing of a piece that does, which another division of the path would not see, is rare.
Int3 aside(Int3 p) {
  Hash64 h;
  h.add(p.x), h.add(p.y), h.add(p.z);
  const uint64_t r = h.value();
  const auto shift = [&](int bits) { return 2 * (int32_t((r >> bits & 0xfffff) % (2 * kAsideUnits + 1)) - kAsideUnits); };
  return {p.x + shift(0), p.y + shift(21), p.z + shift(42)};
}

}  // namespace

double DrawnIncision::length_mm() const { return path_length(path_); }

std::string DrawnIncision::draw(const BladeContext& c, std::span<const ChartPoint> points) {
  if (std::string why = check_stroke(points, depth_); !why.empty()) return why;
  if (!(angle_deg_ >= 20 && angle_deg_ <= 160)) return "the angle between blade and skin must be 20 to 160 degrees";
  std::vector<Vec2> path = path_;
  for (const ChartPoint& p : points) {
    if (!path.empty() && (p - path.back()).norm() < kKnot) continue;
    if (!column_at(c, p)) {
      char text[80];
      std::snprintf(text, sizeof text, "the point (%.2f, %.2f) is not on the skin", p.x(), p.y());
      return text;
    }
    path.push_back(p);
  }
  path_ = std::move(path);
  return {};
}

double DrawnIncision::lean() const {
  const double angle = angle_deg_ * std::numbers::pi / 180;
  return std::cos(angle) / std::sin(angle);
}

/// Columns on every corner of the path and every kSpacing between; no quad is shorter than kLeast unless an edge is.
/// A column depends on what lies before it and less than a hold after it. `corner_arc`: corners at which the blade turns
/// upright, those before the path going in and those of the path coming out.
std::vector<DrawnIncision::Place> DrawnIncision::places(std::span<const Vec2> path, double arc, std::vector<double>& corner_arc) const {
  std::vector<Place> out{{path[0], arc, 1}};
  for (size_t i = 1; i < path.size(); ++i) {
    const Vec2 d = path[i] - path[i - 1];
    const double length = d.norm();
    for (int k = 1; length - k * kSpacing >= kLeast * kSpacing; ++k)
      out.push_back({path[i - 1] + d * (k * kSpacing / length), arc + k * kSpacing, 1});
    arc += length;
    out.push_back({path[i], arc, 1});
    if (i + 1 == path.size()) break;
    // A mitred blade folds at a short quad beside a corner: on the inner side of the turn its edge would run backwards.
    const Vec2 e = path[i + 1] - path[i], a = d / length, b = e.normalized();
    const double sine = a.x() * b.y() - a.y() * b.x(), cosine = a.dot(b);  // sine > 0: to the left
    const double inside = sine * lean() < 0 ? depth_ + 2 * kWallExtra : 1.1 * kMargin;
    const double back = std::abs(sine) / std::max(1 + cosine, 0.1) * std::abs(lean()) * inside;
    const double last = arc - out[out.size() - 2].arc, next = e.norm() < (1 + kLeast) * kSpacing ? e.norm() : kSpacing;
    if (back > kFold * std::min(last, next)) corner_arc.push_back(arc);
  }
  const double reach = 3 * (depth_ + kMargin) * std::abs(lean()), ahead = std::min(reach, kHold - 0.1);
  for (Place& p : out)
    for (const double c : corner_arc) p.share = std::min(p.share, p.arc < c ? (c - p.arc) / ahead : (p.arc - c) / reach);
  return out;
}

bool DrawnIncision::begin(const BladeContext& c, bool last) {
  if (begun_) return true;
  if (path_.size() < 2 || length_mm() < (last ? kShortest : hold_mm())) return false;
  if (c.arrangement) {
    if (!last) {  // over a hole: it begins where it comes out
      size_t out = 0;
      while (out < path_.size() && !skin_is_live(c, path_[out])) ++out;
      if (out == path_.size() || path_length(std::span(path_).subspan(out)) < kHold) return false;
    }
    overshoot_ = overshoot_of(c);
    past_start_ = attach_start(c, WoundMap(c), path_, overshoot_);
  }
  if (rows_ == 0) {
    margin_ = margin_of(c);
    extra_ = wall_extra(c);
    rows_ = std::max(2, int(std::ceil((depth_ + extra_ + margin_) / kRowHeight)));
  }
  return begun_ = path_.size() >= 2;
}

BladeResult DrawnIncision::next(const BladeContext& c, bool last) {
  if (!begin(c, last)) return last ? refuse("nothing of the stroke lies on uncut skin, or it is shorter than 1 mm") : BladeResult{};
  std::vector<double> corner;
  std::vector<Place> place = places(path_, 0, corner);
  // The last column that may be final: a hold before the end, and before a hole that the path has not come out of.
  size_t end = place.size() - 1;
  while (c.arrangement && end > committed_ && !skin_is_live(c, place[end].at)) --end;
  size_t hold = end;
  while (hold > 0 && place[hold].arc > place[end].arc - hold_mm()) --hold;
  bool past_end = false;
  if (last) {
    // The end is settled on the part behind `hold`, the same one however the path was divided.
    std::vector<Vec2> tail{place[hold].at};
    double arc = 0;
    for (size_t i = 1; i < path_.size(); ++i) {
      arc += (path_[i] - path_[i - 1]).norm();
      if (arc > place[hold].arc + 1e-9) tail.push_back(path_[i]);
    }
    if (tail.size() > 1 && c.arrangement) {
      std::reverse(tail.begin(), tail.end());
      past_end = attach_start(c, WoundMap(c), tail, overshoot_);
      std::reverse(tail.begin(), tail.end());
    }
    if (tail.size() > 1) {
      std::erase_if(corner, [&](double at) { return at > place[hold].arc; });
      const std::vector<Place> rest = places(tail, place[hold].arc, corner);
      place.resize(hold);
      place.insert(place.end(), rest.begin(), rest.end());
    }
    // A quad that is pushed through a wall is no seed: at least one other is needed.
    const size_t free_ends = (committed_ == 0 && past_start_) + size_t(past_end);
    while (place.size() >= 2 && place.size() - 1 - (committed_ > 0 ? committed_ - 1 : 0) < 1 + free_ends) {
      Place middle;
      middle.at = (place[place.size() - 2].at + place.back().at) / 2;
      middle.arc = (place[place.size() - 2].arc + place.back().arc) / 2;
      place.insert(place.end() - 1, middle);
    }
  }
  const size_t count = last ? place.size() : hold + 1;  // columns to be cut by now
  const size_t first = committed_ > 0 ? committed_ - 1 : 0;
  if (count < first + (last ? 2 : 3)) return {};

  // One column more than is cut gives the last one its direction.
  offered_column_ = column_;
  offered_arc_mm_ = arc_mm_;
  for (size_t i = column_.size(); i < std::min(place.size(), count + 1); ++i) {
    const auto k = column_at(c, place[i].at);
    if (!k) return refuse("the stroke leaves the skin");
    offered_arc_mm_.push_back(i == 0 ? 0 : offered_arc_mm_.back() + (k->X - offered_column_.back().X).norm());
    offered_column_.push_back(*k);
  }
  Blade blade;
  bool embedded = false;
  for (const double stiffness : kStiffness) {
    if (embedded) break;
    std::vector<Column> held = offered_column_;
    const std::vector<Column> stiff = stiffened(std::span(offered_column_).subspan(first), stiffness);
    std::copy(stiff.begin(), stiff.end(), held.begin() + long(first));
    blade = strip(c, std::span(held).first(count), directions(held, place, first), first, last);
    embedded = check_embedded(blade.vertex, blade.tri).empty();
  }
  if (!embedded) return refuse("the blade would run through itself; expected a straighter path or less depth");
  const size_t per_column = size_t(rows_) * 2;
  for (size_t i = 0; i < per_column && first == 0 && past_start_; ++i) blade.seed[i] = 0;
  for (size_t i = 0; i < per_column && past_end; ++i) blade.seed[blade.seed.size() - 1 - i] = 0;
  if (std::string why = fits_grid(c, blade); !why.empty()) return refuse(why);
  offered_ = count;
  offered_column_.resize(count);
  offered_arc_mm_.resize(count);
  return {std::move(blade), {}};
}

/// Into the tissue, per column from `first` on: leaning to the right of the path, mitred at corners.
std::vector<Vec3> DrawnIncision::directions(std::span<const Column> column, std::span<const Place> place, size_t first) const {
  const size_t n = column.size();
  const auto right_of = [&](size_t a, size_t b, size_t i) {
    return (column[b].X - column[a].X).cross(column[i].normal).normalized();
  };
  std::vector<Vec3> out;
  for (size_t i = first; i < n; ++i) {
    const Vec3 before = i > 0 ? right_of(i - 1, i, i) : right_of(0, 1, 0);
    const Vec3 after = i + 1 < n ? right_of(i, i + 1, i) : before;
    out.push_back(-column[i].normal + (before + after) / std::max(1 + before.dot(after), 0.25) * (lean() * place[i].share));
  }
  return out;
}

/// Columns x rows of quads, as in add_strip; the first column is that of the committed blade if there is one. `closing`:
/// the diagonals of the last quads rise towards the blade's end, so that no triangle lies wholly on its free border.
Blade DrawnIncision::strip(const BladeContext& c, std::span<const Column> column, std::span<const Vec3> direction, size_t first,
                           bool closing) {
  Blade blade;
  blade.strip = true;
  const double total = depth_ + extra_ + margin_;
  const auto level = [&](int r) { return total * r / rows_ - margin_; };  // below the skin
  const bool continues = first + 1 == committed_ && !end_point_.empty();
  for (size_t i = first; i < column.size(); ++i)
    for (int r = 0; r <= rows_; ++r) {
      const int32_t shared = continues && i == first ? end_point_[size_t(r)] : -1;
      blade.shared_point.push_back(shared);
      blade.vertex.push_back(shared >= 0 ? c.arrangement->explicit_point(shared)
                                         : aside(c.body->grid.to_grid(column[i].X + direction[i - first] * level(r))));
    }
  const auto id = [&](size_t i, int r) { return int32_t(i - first) * (rows_ + 1) + r; };
  const auto uv = [&](size_t i, int r) { return Eigen::Vector2f(float(offered_arc_mm_[i]), float(level(r))); };
  const auto add = [&](std::array<std::pair<size_t, int>, 3> v) {
    blade.tri.push_back({id(v[0].first, v[0].second), id(v[1].first, v[1].second), id(v[2].first, v[2].second)});
    blade.uv_mm.push_back({uv(v[0].first, v[0].second), uv(v[1].first, v[1].second), uv(v[2].first, v[2].second)});
  };
  for (size_t i = first; i + 1 < column.size(); ++i)
    for (int r = 0; r < rows_; ++r) {
      const size_t j = i + 1;
      if (closing && j + 1 == column.size()) {
        add({{{i, r}, {i, r + 1}, {j, r + 1}}});
        add({{{i, r}, {j, r + 1}, {j, r}}});
      } else {
        add({{{i, r}, {i, r + 1}, {j, r}}});
        add({{{i, r + 1}, {j, r + 1}, {j, r}}});
      }
      blade.seed.push_back(r == 0);
      blade.seed.push_back(r == 0);
    }
  return blade;
}

void DrawnIncision::was_cut(const CutResult& result) {
  column_ = std::move(offered_column_);
  arc_mm_ = std::move(offered_arc_mm_);
  committed_ = offered_;
  end_point_.assign(result.blade_point.end() - (rows_ + 1), result.blade_point.end());
}

void DrawnIncision::was_nothing(const BladeContext& c) {
  if (offered_ == 0) return;
  std::vector<double> corner;
  const std::vector<Place> place = places(path_, 0, corner);
  if (offered_ > place.size()) return;
  if (!skin_is_live(c, place[offered_ - 1].at)) {  // over a hole: on with the same columns, and a blade of its own
    column_ = std::move(offered_column_);
    arc_mm_ = std::move(offered_arc_mm_);
    committed_ = offered_;
    end_point_.clear();
    return;
  }
  // Along an earlier cut: what comes next begins on whatever lies before it.
  std::vector<Vec2> rest{place[offered_ - 1].at};
  double arc = 0;
  for (size_t i = 1; i < path_.size(); ++i) {
    arc += (path_[i] - path_[i - 1]).norm();
    if (arc > place[offered_ - 1].arc + 1e-9) rest.push_back(path_[i]);
  }
  path_ = std::move(rest);
  begun_ = past_start_ = false;
  committed_ = 0;
  column_.clear(), arc_mm_.clear(), end_point_.clear();
}

}  // namespace limberg
