// Hooks, and the places on the skin that hooks and stitches hold.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "sim/lattice/embedding.h"
#include "sim/patient/operating_table.h"

namespace limberg {
namespace {

constexpr double kMissing_mm = 1.5;  // a point this near to living skin still means that skin (tracker noise at a rim)

}  // namespace

std::optional<SurfacePoint> OperatingTable::find_skin(const ChartPoint& p, std::string& reason) const {
  if (!p.allFinite())
    return reason = "the point is not a number; two finite coordinates in mm were expected", std::nullopt;
  const auto hit = skin_.at(p);
  if (!hit)
    return reason = "point " + at_text(p) + " lies off the skin; a point on the skin was expected", std::nullopt;
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
  std::vector<int32_t> torn;  // a thread that has lost one bite holds nothing
  std::erase_if(stitches_, [&](Stitch& s) {
    if (carry(s.a) && carry(s.b)) {
      widen(s.a), widen(s.b);
      return false;
    }
    if (s.thread > 0) torn.push_back(s.thread);
    return lost = true;
  });
  for (int32_t t : torn) drop_thread(t);
  return lost;
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
  if (!c.to_mm.allFinite())
    return {false, "the hook's target is not a number; three finite coordinates in mm were expected"};
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

}  // namespace limberg
