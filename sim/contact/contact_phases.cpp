// Broad and narrow phase of a place (contact_finder.h).
#include <algorithm>
#include <cmath>

#include "sim/contact/contact_constants.h"
#include "sim/contact/contact_finder.h"

namespace limberg {

namespace constant = contact_constants;

namespace {

constexpr double kSurface_mm = 0.1;  // nearer than this to the surface a place is as good as on it
constexpr double kFloor_mm = 0.02;   // added to depths that are compared: below it they are all the same
constexpr double kOwn_mm = 1e-3;     // a point of the own tissue is found again within this
constexpr double kSelf_mm = 2;       // so near on its own sheet a place has neighbours

/// 0 up to `from`, 1 after `to`; value and slope are continuous.
double smooth_step(double x, double from, double to) {
  const double t = std::clamp((x - from) / (to - from), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

}  // namespace

Vec3 ContactFinder::carried_normal(int32_t t, const std::array<double, 3>& bary, const Vec3& N) const {
  const size_t c = size_t(carrier_[size_t(t)]);
  return cells_.carried_normal(c, (surface_->rest_mm(t, bary) - tissue_.low_mm(c)).cwiseQuotient(tissue_.size_mm(c)),
                               N);
}

// What copies are to those of a group, in a list with a zero for each: made when it is first wanted, mostly never.
// Adjacent copies count only for the walls of other sheets that they carry.
enum : uint8_t { kApart = 0, kAdjacent = 1, kExcluded = 2 };

void ContactFinder::mark_adjacent(const Group& g, bool marked, std::vector<uint8_t>& relation) const {
  relation.resize(tissue_.size(), kApart);
  for (int32_t c : tissue_.adjacent(g.own))
    relation[size_t(c)] = !marked ? kApart : tissue_.has_other_wall(size_t(c), g.sheet) ? kAdjacent : kExcluded;
  relation[g.own] = marked ? kExcluded : kApart;
}

// Who carries what a copy's places have pairs with: the beginning of its list.
void ContactFinder::begin_list(Group& g, std::span<const Pair> pairs) const {
  g.around.clear();
  for (const Pair& pair : pairs) {
    const size_t c = size_t(carrier_[size_t(pair.held.triangle)]);
    if (c != g.own && !tissue_.is_empty(c) && (!tissue_.adjacent(g.own, c) || tissue_.has_other_wall(c, g.sheet)))
      g.around.push_back(int32_t(c));
  }
  g.far_mm = 0, g.listed = false;
}

// And the copies that were around it at the last search, whose boxes are still there. Some may be named twice.
void ContactFinder::complete_list(Group& g, std::vector<uint8_t>& relation) const {
  mark_adjacent(g, true, relation);
  cells_.near(g.own, MovingCells::kAhead_mm + float(constant::margin_mm), [&](size_t c) {
    if (relation[c] != kExcluded) g.around.push_back(int32_t(c));
  });
  mark_adjacent(g, false, relation);
  g.listed = true;
}

// The copies that may hold one of these places of a group.
void ContactFinder::broad_phase(const Group& g, std::span<const Point> points, std::vector<Around>& around,
                                std::vector<uint8_t>& relation) const {
  Vec3f lo = points[0].p, hi = lo;
  for (const Point& p : points) lo = lo.cwiseMin(p.p), hi = hi.cwiseMax(p.p);
  around.clear();
  mark_adjacent(g, true, relation);
  cells_.around(lo, hi, [&](size_t c) {
    if (relation[c] != kExcluded) around.push_back({int32_t(c), relation[c] == kAdjacent});
  });
  mark_adjacent(g, false, relation);
  std::sort(around.begin(), around.end());
}

// Which of the copies around hold it, and where. What the neighbours
// of a copy that holds it say from without, it knows itself.
void ContactFinder::locate(const Point& point, std::span<const Around> around, std::vector<Located>& located) const {
  const Vec3f& p = point.p;
  const int32_t sheet = surface_->sheets.of[size_t(surface_->place[point.place].triangle)];
  const size_t first = located.size();
  for (const Around& a : around) {
    const size_t c = size_t(a.copy);
    if (!cells_.may_hold(c, p, !a.adjacent) || (a.adjacent && !tissue_.has_other_wall(c, sheet))) continue;
    Vec3 at;
    if (!cells_.invert(c, p, a.adjacent ? 0 : float(RestTissue::kBeyond), at)) continue;
    const bool in = (at.array() >= 0).all() && (at.array() <= 1).all();
    located.push_back({int32_t(point.place), a.copy, a.adjacent, in, tissue_.part(c, at), at});
  }
  size_t kept = first;
  for (size_t k = first; k < located.size(); ++k) {
    const Located& h = located[k];
    bool told = false;
    for (size_t j = first; !h.in && !told && j < located.size(); ++j)
      told = located[j].in && tissue_.adjacent(size_t(located[j].copy), size_t(h.copy));
    if (!told) located[kept++] = h;
  }
  located.resize(kept);
}

// What the answers of these copies make of it: at most one pair for each sheet.
void ContactFinder::narrow_phase(size_t i, std::span<const Located> located, std::vector<HeldContact>& found) const {
  const ContactSurface& s = *surface_;
  const ContactPlace& place = s.place[i];
  const int32_t own_sheet = s.sheets.of[size_t(place.triangle)];
  Vec3 own = Vec3::Zero(), shown = Vec3::Zero();
  RestTissue::Answer a;
  for (const Located& in : located) {
    const size_t c = size_t(in.copy);
    if (in.adjacent && (tissue_.rest_mm(c, in.at) - place.X_mm).squaredNorm() < kOwn_mm * kOwn_mm &&
        s.lattice->cells[size_t(tissue_.copy(c))].cell != s.lattice->cells[size_t(place.copy)].cell)
      continue;  // on the common square
    tissue_.ask(c, in.at, in.part, a);
    if (a.count == 0) continue;
    size_t first = 0;
    for (size_t k = 1; k < a.count; ++k)
      if (a.foot[k].distance_mm < a.foot[first].distance_mm) first = k;
    const auto itself = [&](const RestTissue::Foot& f) {
      return f.sheet == own_sheet && (s.rest_mm(f.triangle, f.bary) - place.X_mm).squaredNorm() < kSelf_mm * kSelf_mm;
    };
    if (itself(a.foot[first])) continue;
    // Inside, only what the place is behind leads out; outside, only what it is in front of can be entered. The way out
    // is through a sheet that faces the place: its depth is taken along the place's own normal.
    std::array<double, RestTissue::kFeet> depth{}, facing{};
    std::array<Vec3, RestTissue::kFeet> normal;
    double least = 1e30;
    for (size_t k = 0; k < a.count; ++k) {
      const RestTissue::Foot& f = a.foot[k];
      depth[k] = -1;
      if (a.inside ? f.height_mm >= 0 : f.distance_mm > constant::guard_mm || f.height_mm < -RestTissue::kOn_mm)
        continue;
      if (itself(f)) continue;
      if (own.isZero(0))
        own = carried_normal(place.triangle, place.bary, normal_[i]), shown = shown_mm(place.triangle, place.bary);
      normal[k] = carried_normal(f.triangle, f.bary, tissue_.smooth_normal(f.triangle, f.bary));
      facing[k] = -own.dot(normal[k]);
      if (normal[k].isZero(0) || facing[k] <= constant::facing_none) continue;
      depth[k] = (f.distance_mm + kFloor_mm) / facing[k];
      least = std::min(least, depth[k]);
    }
    for (size_t k = 0; k < a.count; ++k) {
      if (depth[k] < 0) continue;
      const RestTissue::Foot& f = a.foot[k];
      HeldContact h;
      h.place = int32_t(i), h.sheet = f.sheet, h.triangle = f.triangle, h.bary = f.bary;
      h.normal = h.facet = normal[k];
      const double s_mm = h.normal.dot(shown - shown_mm(f.triangle, f.bary));
      h.gap_mm = -s_mm;  // for the time being: it needs to know how the cells carry both (merge)
      h.depth_tested = a.inside || f.distance_mm < kSurface_mm;
      h.weight = 1;
      if (h.depth_tested) {
        h.weight = (1 - smooth_step(depth[k] / least, constant::other_full, constant::other_none)) *
                   smooth_step(facing[k], constant::facing_none, constant::facing_full);
        h.weight *= 1 - smooth_step(f.distance_mm, constant::deep_full_mm, constant::deep_none_mm);
        if (-s_mm > constant::most_mm) h.weight *= constant::most_mm / -s_mm;
      } else if (s_mm < 0 || facing[k] < constant::facing_full) {
        continue;
      }
      if (h.weight < kNothing) continue;
      // Several copies may tell of one sheet: one that the place is inside of knows best, then the nearest.
      const auto same =
          std::find_if(found.begin(), found.end(), [&](const HeldContact& other) { return other.sheet == h.sheet; });
      if (same == found.end())
        found.push_back(h);
      else if (std::pair(h.depth_tested, -std::abs(h.gap_mm)) > std::pair(same->depth_tested, -std::abs(same->gap_mm)))
        *same = h;
    }
  }
  std::sort(found.begin(), found.end(),
            [](const HeldContact& one, const HeldContact& two) { return one.sheet < two.sheet; });
}

}  // namespace limberg
