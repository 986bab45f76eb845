// Through and through: a ruled blade from one side of a lip, a lid or an ear to the other.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "sim/body/skin.h"
#include "sim/cutting/arrangement/tri_tests.h"
#include "sim/cutting/strokes/blade_parts.h"
#include "sim/cutting/strokes/free_margin.h"
#include "sim/cutting/strokes/sheet_overlap.h"

namespace limberg {
namespace {

constexpr double kThickest_mm = 40;     // a lip is 8 to 15, a nose or a cheek up to 30: beyond, nobody cuts through
constexpr double kMarginReach_mm = 12;  // so far from the last post a free margin is looked for
constexpr double kMarginStep_mm = 0.75;
constexpr double kBesideCut_mm = 1.0;      // a closed end this near to an earlier cut joins it
constexpr double kOffBed_mm = 3.0;         // a place may lie so far off the bed that it means
constexpr double kShortOfMargin_mm = 3.0;  // a bed may end so far before a post at a free margin
constexpr double kAboveBed_mm = 0.3;       // so far the blade stands out of it, into the flap, which has no seed there

/// One column of the ruled blade.
struct Ruling {
  Vec3 X = Vec3::Zero(), out = Vec3::UnitZ();  // on the skin; unit, away from it
  double through_mm = 0;                       // to the other side
  bool drawn = true;                           // between the posts
};

/// Where the line through X along `out` meets the skin from outside, nearest to X, and how thick the body is there.
std::optional<Ruling> ruling_at(const Skin& skin, const Vec3& X, const Vec3& out, double reach_mm) {
  const auto hits = skin.surface().line(X + reach_mm * out, -out, 0, 2 * reach_mm + kThickest_mm);
  std::optional<Ruling> best;
  double least = 1e300;
  for (size_t i = 0; i < hits.size(); ++i) {
    const double off = std::abs(hits[i].t - reach_mm);
    if (!hits[i].from_outside || off > reach_mm || off >= least) continue;
    const auto exit = std::find_if(hits.begin() + std::ptrdiff_t(i), hits.end(),
                                   [&](const Bvh::LineHit& h) { return !h.from_outside && h.t > hits[i].t + 1e-6; });
    if (exit == hits.end() || exit->t - hits[i].t > kThickest_mm) continue;
    least = off;
    best = Ruling{X + (reach_mm - hits[i].t) * out, out, exit->t - hits[i].t, true};
  }
  return best;
}

/// The same from the bed of a pocket near X.
std::optional<Ruling> ruling_from_bed(const Skin& skin, const PocketMap& pockets, const Vec3& X, const Vec3& out) {
  const auto height = pockets.at(X, out, skin.frame(X).normal, kOffBed_mm);
  if (!height) return std::nullopt;
  const Vec3 bed = X + *height * out;
  for (const Bvh::LineHit& h : skin.surface().line(bed, -out, 0.1, kThickest_mm))
    if (!h.from_outside) return Ruling{bed, out, h.t, true};
  return std::nullopt;
}

/// Where lines along -out, moved on by `step` along `way`, lie within the body: of each the stretches, in mm below the
/// highest point looked at.
struct Section {
  static constexpr double kStep_mm = 0.1;
  double above_mm = 0;
  std::vector<std::vector<std::pair<double, double>>> column;

  Section(const Skin& skin, const Ruling& last, const Vec3& way, double reach_mm) : above_mm(reach_mm) {
    const int n = int(std::ceil(reach_mm / kStep_mm));
    for (int i = 0; i <= n; ++i) {
      column.emplace_back();
      const Vec3 from = last.X + i * kStep_mm * way + above_mm * last.out;
      double in = -1;
      for (const Bvh::LineHit& h : skin.surface().line(from, -last.out, 0, above_mm + kThickest_mm)) {
        if (h.from_outside && in < 0) in = h.t;
        if (h.from_outside || in < 0) continue;
        column.back().push_back({in, h.t});
        in = -1;
      }
      if (in >= 0) column.back().push_back({in, above_mm + kThickest_mm});
    }
  }
};

/// Rulings beyond an end, as the last one moved on along `way`, to where the part of the body ends that the last one
/// goes through; empty when it goes on. Another part may lie close behind its margin, the other lip or the other lid:
/// what hangs together with the last ruling in their common plane is followed, and what else the blade meets there has
/// no seed.
/// `on_bed`: the blade stays below where the last ruling begins.
std::vector<Ruling> over_margin(const Skin& skin, const Ruling& last, const Vec3& way, double margin, bool on_bed,
                                double reach_mm = kMarginReach_mm) {
  const Section section(skin, last, way, reach_mm);
  using Stretch = std::pair<double, double>;
  std::vector<std::vector<char>> part;  // of each column, which stretches belong to it
  for (const auto& c : section.column) part.emplace_back(c.size(), char(0));
  std::vector<std::pair<size_t, size_t>> open;
  const auto reach = [&](size_t i, const Stretch& from) {
    for (size_t k = 0; k < part[i].size(); ++k) {
      const Stretch& s = section.column[i][k];
      if (part[i][k] || std::min(s.second, from.second) <= std::max(s.first, from.first)) continue;
      part[i][k] = 1;
      open.push_back({i, k});
    }
  };
  reach(0, {section.above_mm, section.above_mm + last.through_mm});
  size_t end = 0;
  while (!open.empty()) {
    const auto [i, k] = open.back();
    open.pop_back();
    if (i + 1 == part.size()) return {};
    end = std::max(end, i);
    const Stretch here = section.column[i][k];
    if (i > 0) reach(i - 1, here);
    reach(i + 1, here);
  }
  const auto ruling = [&](double s) {
    // As high and as deep as the part is there: a margin may stand out over both sides.
    double top = section.above_mm, foot = section.above_mm + last.through_mm;
    const size_t at = std::min(end, size_t(s / Section::kStep_mm));
    for (size_t i = at > 4 ? at - 4 : 0; i <= std::min(end, at + 4); ++i)
      for (size_t k = 0; k < part[i].size(); ++k)
        if (part[i][k])
          top = std::min(top, section.column[i][k].first), foot = std::max(foot, section.column[i][k].second);
    Ruling r = last;
    r.drawn = false;
    // Below the bed from its first beyond the pocket: what stands out of the bed is then parted by it from the rest.
    if (on_bed) top = section.above_mm + 2 * kAboveBed_mm;
    r.X += s * way + (section.above_mm - top) * last.out;
    r.through_mm = foot - top;
    return r;
  };
  std::vector<Ruling> out;
  const double beyond = (double(end) + 1) * Section::kStep_mm;
  for (double s = kMarginStep_mm; s < beyond; s += kMarginStep_mm) out.push_back(ruling(s));
  out.push_back(ruling(beyond));
  out.push_back(ruling(beyond + margin));
  return out;
}

/// `above`: how far the blade stands out over where its rulings begin. From a bed, what lies below it is drawn.
Blade strip_of(const BladeContext& c, std::span<const Ruling> rulings, double margin, double above, bool on_bed) {
  const size_t n = rulings.size();
  // As deep as the deepest neighbour, so that the foot of a column between two thicker places is out as well.
  std::vector<double> depth(n);
  double deepest = 0;
  for (size_t i = 0; i < n; ++i) {
    depth[i] = rulings[i].through_mm;
    for (const size_t k : {i > 0 ? i - 1 : i, i + 1 < n ? i + 1 : i})
      depth[i] = std::max(depth[i], std::min(rulings[k].through_mm, 1.5 * rulings[i].through_mm + margin));
    depth[i] += margin;
    deepest = std::max(deepest, depth[i] + above);
  }
  const int rows = std::max(2, int(std::ceil(deepest / kRowHeight)));
  Blade blade;
  // From a bed the first row is as deep below it as it stands out above: it alone crosses the bed.
  const auto level = [&](size_t i, int r) {
    if (!on_bed) return (depth[i] + above) * r / rows - above;
    return r == 0 ? -above : above + (depth[i] - above) * (r - 1) / (rows - 1);
  };
  std::vector<double> arc(n, 0);
  for (size_t i = 0; i < n; ++i) {
    if (i > 0) arc[i] = arc[i - 1] + (rulings[i].X - rulings[i - 1].X).norm();
    for (int r = 0; r <= rows; ++r)
      blade.vertex.push_back(c.body->grid.to_grid(rulings[i].X - rulings[i].out * level(i, r)));
  }
  const auto id = [&](size_t i, int r) { return int32_t(i) * (rows + 1) + r; };
  const auto uv = [&](size_t i, int r) { return Eigen::Vector2f(float(arc[i]), float(level(i, r))); };
  for (size_t i = 0; i + 1 < n; ++i)
    for (int r = 0; r < rows; ++r) {
      const size_t j = i + 1;
      blade.tri.push_back({id(i, r), id(i, r + 1), id(j, r)});
      blade.uv_mm.push_back({uv(i, r), uv(i, r + 1), uv(j, r)});
      blade.tri.push_back({id(i, r + 1), id(j, r + 1), id(j, r)});
      blade.uv_mm.push_back({uv(i, r + 1), uv(j, r + 1), uv(j, r)});
      const bool drawn = rulings[i].drawn && rulings[j].drawn;
      const uint8_t seed = on_bed ? (drawn && r > 0 ? 2 : 0) : drawn && std::min(level(i, r), level(j, r)) <= 0;
      blade.seed.push_back(seed);
      blade.seed.push_back(seed);
    }
  return blade;
}

/// Rulings turned towards their common mean, as stiffened() does with columns.
std::vector<Vec3> directions(std::span<const Ruling> rulings, double share) {
  std::vector<Column> columns;
  for (const Ruling& r : rulings) columns.push_back({r.X, r.out});
  std::vector<Vec3> out;
  for (const Column& k : stiffened(columns, share)) out.push_back(k.normal);
  return out;
}

}  // namespace

BladeResult build_through(const BladeContext& c, const Skin& skin, const ThroughCut& cut) {
  const SkinView& view = *c.view;
  if (view.place.size() < 2) return refuse("a cut right through with less than two posts; expected at least two");
  const bool on_bed = !cut.on_bed.empty();
  const PocketMap pockets(c.arrangement);
  std::vector<Ruling> drawn;
  double length = 0;
  for (size_t i = 0; i < view.place.size(); ++i) {
    const Vec3 X = on_bed ? cut.on_bed[i] : view.place[i];
    const Vec3 out = cut.normals.empty() ? skin.frame(X).normal : cut.normals[i].normalized();
    if (!drawn.empty()) {
      const Ruling from = drawn.back();
      const double way = (X - from.X).norm();
      length += way;
      const int parts = equal_parts(way, kSpacing);
      for (int k = 1; k < parts; ++k) {
        const double t = double(k) / parts;
        drawn.push_back({(1 - t) * from.X + t * X, ((1 - t) * from.out + t * out).normalized(), 0, true});
      }
    }
    drawn.push_back({X, out, 0, true});
  }
  if (length < kShortest)
    return refuse(fmt::format("a cut right through of {:.2f} mm; expected at least {:g}", length, kShortest));
  const double margin = margin_of(c);
  std::string why;
  for (const double stiffness : kStiffness) {
    const std::vector<Vec3> out = directions(drawn, stiffness);
    std::vector<Ruling> rulings;
    why.clear();
    size_t begin = 0, end_of = drawn.size();
    std::vector<std::optional<Ruling>> found;
    for (size_t i = 0; i < drawn.size(); ++i)  // chords of a curved skin run below it, or over a hollow
      found.push_back(on_bed ? ruling_from_bed(skin, pockets, drawn[i].X, out[i])
                             : ruling_at(skin, drawn[i].X, out[i], 0.5 * length + kOffSkin_mm));
    // A pocket ends short of a free margin: over an open end the blade goes on from where there is a bed.
    const auto short_of = [&](size_t a, size_t b) { return (drawn[a].X - drawn[b].X).norm() <= kShortOfMargin_mm; };
    while (on_bed && cut.open_end && end_of > 2 && !found[end_of - 1] && short_of(end_of - 1, drawn.size() - 1))
      --end_of;
    while (on_bed && cut.open_start && begin + 2 < end_of && !found[begin] && short_of(begin, 0)) ++begin;
    for (size_t i = begin; i < end_of && why.empty(); ++i) {
      if (found[i])
        rulings.push_back(*found[i]);
      else if (on_bed)
        why = fmt::format(
            "at {} there is no bed within {:g} mm with a free side within {:g} mm below; a place on what was "
            "undermined was expected",
            at_text(drawn[i].X), kOffBed_mm, kThickest_mm);
      else
        why = fmt::format(
            "at {} the blade does not come out on the other side within {:g} mm; a part of the body with "
            "two free sides was expected",
            at_text(drawn[i].X), kThickest_mm);
    }
    if (!why.empty()) continue;
    std::vector<Ruling> all;
    const auto end = [&](bool open, const Ruling& last, const Ruling& before, const char* name) {
      std::vector<Ruling> beyond;
      Vec3 way = last.X - before.X;
      way = (way - way.dot(last.out) * last.out).normalized();
      if (open) beyond = over_margin(skin, last, way, margin, on_bed);
      if (!beyond.empty()) return beyond;
      // An open end may also run into an earlier cut, whose banks are free.
      if (const WoundMap wounds(c); !wounds.empty()) {
        const double near = wounds.nearest(view.chart.to_chart(last.X)).distance;
        Ruling on = last;
        on.X += (near + overshoot_of(c)) * way, on.drawn = false;
        if (near <= (open ? kShortOfMargin_mm : kBesideCut_mm)) beyond.push_back(on);
      }
      if (open && beyond.empty())
        why = fmt::format("\"{}\": no free margin within {:g} mm of {}; a post nearer to the margin was expected", name,
                          kMarginReach_mm, at_text(last.X));
      return beyond;
    };
    std::vector<Ruling> before = end(cut.open_start, rulings[0], rulings[1], "open_start");
    const std::vector<Ruling> after = end(cut.open_end, rulings.back(), rulings[rulings.size() - 2], "open_end");
    if (!why.empty()) return refuse(why);
    std::reverse(before.begin(), before.end());
    all = before;
    all.insert(all.end(), rulings.begin(), rulings.end());
    all.insert(all.end(), after.begin(), after.end());
    Blade blade = strip_of(c, all, margin, on_bed ? kAboveBed_mm : margin, on_bed);
    if (!check_embedded(blade.vertex, blade.tri).empty()) {
      why = "the blade would run through itself; expected directions that turn less between the posts";
      continue;
    }
    if (const std::string off = fits_grid(c, blade); !off.empty()) return refuse(off);
    return {std::move(blade), {}};
  }
  return refuse(why);
}

bool margin_beyond(const Skin& skin, const Vec3& X_mm, const Vec3& out, const Vec3& way, double reach_mm) {
  const auto from = ruling_at(skin, X_mm, out, kOffSkin_mm);
  return from && !over_margin(skin, *from, way, 0, false, reach_mm).empty();
}

}  // namespace limberg
