// Hooks and stitches: finding their place, adding, moving and removing them.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "sim/lattice/embedding.h"
#include "sim/world/operating_table.h"

namespace limberg {
namespace {

constexpr double kMissing_mm = 1.5;    // a point this near to living skin still means that skin (tracker noise at a rim)
constexpr double kRimReach_mm = 2.0;   // a stitch placed this near to a wound's edge goes through the edge
constexpr double kSamePlace_mm = 0.5;  // two stitches nearer than this at both ends are one

std::string at_text(const ChartPoint& p) {
  char text[64];
  std::snprintf(text, sizeof text, "(%.2f, %.2f) mm", p.x(), p.y());
  return text;
}

}  // namespace

std::optional<SurfacePoint> OperatingTable::find_skin(const ChartPoint& p, std::string& reason) const {
  if (!p.allFinite()) return reason = "the point is not a number; two finite coordinates in mm were expected", std::nullopt;
  const auto hit = skin_.at(p);
  if (!hit) return reason = "point " + at_text(p) + " lies off the skin; a point on the skin was expected", std::nullopt;
  auto point = version_.index->locate(hit->X_mm, hit->triangle, 1e-2);
  if (!point) point = version_.index->nearest_skin(hit->X_mm, kMissing_mm);
  if (!point) reason = "the skin at " + at_text(p) + " has been removed; a point on remaining skin was expected";
  return point;
}

std::optional<Anchor> OperatingTable::find_anchor(const ChartPoint& p, bool on_rim, std::string& reason) const {
  auto point = find_skin(p, reason);
  if (!point) return std::nullopt;
  if (on_rim)
    if (const auto rim = version_.index->snap_to_rim(*point, kRimReach_mm)) point = rim;
  Anchor anchor = make_anchor(version_.surface->view, *version_.index, *point);
  anchor.embedded = embed(anchor);
  return anchor;
}

EmbeddedPoint OperatingTable::embed(const Anchor& anchor) const {
  return embed_point(*version_.lattice, version_.surface->view, anchor.at.triangle,
                     {anchor.at.bary.x(), anchor.at.bary.y(), anchor.at.bary.z()});
}

bool OperatingTable::same_place(const Anchor& a, const Anchor& b) const {
  return (a.X_mm - b.X_mm).norm() < kSamePlace_mm && (position_mm(a.embedded) - position_mm(b.embedded)).norm() < kSamePlace_mm;
}

bool OperatingTable::joins(const Stitch& s, const Anchor& a, const Anchor& b) const {
  return (same_place(s.a, a) && same_place(s.b, b)) || (same_place(s.a, b) && same_place(s.b, a));
}

bool OperatingTable::carry_anchors() {
  bool lost = false;
  const auto carry = [&](Anchor& a) {
    const auto next = carry_anchor(a, version_.surface->view, *version_.index);
    if (!next) return false;
    a = *next;
    a.embedded = embed(a);
    return true;
  };
  std::erase_if(hooks_, [&](Hook& h) { return !carry(h.anchor) && (lost = true); });
  std::erase_if(stitches_, [&](Stitch& s) { return !(carry(s.a) && carry(s.b)) && (lost = true); });
  return lost;
}

void OperatingTable::publish_springs() {
  std::vector<Spring> springs;
  for (const Hook& h : hooks_) {
    Spring s;
    s.id = h.spring, s.a = h.anchor.embedded, s.to_world = true, s.target_mm = h.handle_mm, s.k_N_per_mm = spec_.hook_k_N_per_mm;
    springs.push_back(s);
  }
  for (const Stitch& t : stitches_) {
    Spring s;
    s.id = t.spring, s.a = t.a.embedded, s.b = t.b.embedded, s.target_mm = t.slack_mm, s.k_N_per_mm = spec_.suture_k_N_per_mm;
    springs.push_back(s);
  }
  solver_->set_springs(springs);
}

Outcome OperatingTable::act(const SetHook& c) {
  std::string reason;
  if (c.id <= 0) return {false, "hook id " + std::to_string(c.id) + "; a positive number was expected"};
  if (std::any_of(hooks_.begin(), hooks_.end(), [&](const Hook& h) { return h.id == c.id; }))
    return {false, "hook " + std::to_string(c.id) + " is set already; release it first or use another id"};
  const auto anchor = find_anchor(c.at, false, reason);
  if (!anchor) return {false, reason};
  undone_.clear();
  Hook hook{c.id, next_spring_++, *anchor, position_mm(anchor->embedded)};
  hooks_.push_back(hook);
  publish_springs();
  return {true, {}};
}

Outcome OperatingTable::act(const MoveHook& c) {
  if (!c.to_mm.allFinite()) return {false, "the hook's target is not a number; three finite coordinates in mm were expected"};
  for (Hook& h : hooks_)
    if (h.id == c.id) {
      h.handle_mm = c.to_mm;
      publish_springs();
      return {true, {}};
    }
  return {false, "there is no hook " + std::to_string(c.id) + "; the id of a hook that is set was expected"};
}

Outcome OperatingTable::act(const ReleaseHook& c) {
  if (std::erase_if(hooks_, [&](const Hook& h) { return h.id == c.id; }) == 0)
    return {false, "there is no hook " + std::to_string(c.id) + "; the id of a hook that is set was expected"};
  undone_.clear();
  publish_springs();
  return {true, {}};
}

Outcome OperatingTable::act(const Suture& c) {
  std::string reason;
  const auto a = find_anchor(c.a, true, reason);
  if (!a) return {false, reason};
  const auto b = find_anchor(c.b, true, reason);
  if (!b) return {false, reason};
  if (same_place(*a, *b)) return {false, "both ends of the stitch are at " + at_text(c.a) + "; two different edges were expected"};
  for (const Stitch& s : stitches_)
    if (joins(s, *a, *b))
      return {false, "stitch " + std::to_string(s.id) + " is there already; another place was expected"};
  remember({moment(), {}, {}});
  stitches_.push_back({next_stitch_++, next_spring_++, *a, *b, position_mm(a->embedded) - position_mm(b->embedded)});
  publish_springs();
  return {true, {}};
}

Outcome OperatingTable::act(const SutureRow& c) {
  if (c.a.size() < 2 || c.b.size() < 2) return {false, "a row of stitches needs two paths of at least two points"};
  if (!(c.spacing_mm > 0)) return {false, "the spacing of a row must be more than 0 mm"};
  const double length = std::max(path_length_mm(c.a), path_length_mm(c.b));
  const double stitches = std::floor(length / c.spacing_mm + 0.5) + 1;
  if (!(stitches <= 500)) return {false, "a row of more than 500 stitches; a wider spacing or a shorter path was expected"};
  const int n = std::max(2, int(stitches));
  const std::vector<Vec2> pa = resample(c.a, n), pb = resample(c.b, n);
  std::vector<Stitch> row;
  for (int i = 0; i < n; ++i) {
    std::string reason;
    const auto a = find_anchor(pa[size_t(i)], true, reason);
    const auto b = a ? find_anchor(pb[size_t(i)], true, reason) : std::nullopt;
    if (!a || !b) return {false, "stitch " + std::to_string(i + 1) + " of the row: " + reason};
    const auto near = [&](const Stitch& s) { return joins(s, *a, *b); };
    if (same_place(*a, *b) || std::any_of(stitches_.begin(), stitches_.end(), near) || std::any_of(row.begin(), row.end(), near)) continue;
    row.push_back({0, 0, *a, *b, position_mm(a->embedded) - position_mm(b->embedded)});
  }
  if (row.empty()) return {false, "every stitch of the row is there already; free edges were expected"};
  remember({moment(), {}, {}});
  for (Stitch& s : row) {
    s.id = next_stitch_++, s.spring = next_spring_++;
    stitches_.push_back(s);
  }
  publish_springs();
  return {true, {}};
}

}  // namespace limberg
