#include "sim/patient/hooks.h"

#include <fmt/format.h>

#include <algorithm>

namespace limberg {

Outcome Hooks::act(const SetHook& c) {
  if (c.id <= 0) return {false, fmt::format("hook id {}; a positive number was expected", c.id)};
  if (std::any_of(holding_.hooks.begin(), holding_.hooks.end(), [&](const Hook& h) { return h.id == c.id; }))
    return {false, fmt::format("hook {} is set already; release it first or use another id", c.id)};
  std::string reason;
  auto anchor =
      c.side == HeldSide::skin ? tissue_.find_anchor(c.at, false, reason) : tissue_.find_in_wall(c.at, c.side, reason);
  if (!anchor) return {false, reason};
  anchor->wide = tissue_.embed_patch(*anchor, tissue_.spec().hook_tip_mm);
  holding_.hooks.push_back({c.id, holding_.next_spring++, *anchor, tissue_.held_mm(*anchor)});
  return {true, {}};
}

Outcome Hooks::act(const MoveHook& c) {
  if (!c.to_mm.allFinite())
    return {false, "the hook's target is not a number; three finite coordinates in mm were expected"};
  for (Hook& h : holding_.hooks)
    if (h.id == c.id) {
      h.handle_mm = c.to_mm;
      return {true, {}};
    }
  return {false, fmt::format("there is no hook {}; the id of a hook that is set was expected", c.id)};
}

Outcome Hooks::act(const ReleaseHook& c) {
  if (std::erase_if(holding_.hooks, [&](const Hook& h) { return h.id == c.id; }) == 0)
    return {false, fmt::format("there is no hook {}; the id of a hook that is set was expected", c.id)};
  return {true, {}};
}

void Hooks::carry() {
  std::erase_if(holding_.hooks, [&](Hook& h) { return !tissue_.carry(h.anchor); });
  for (Hook& h : holding_.hooks) h.anchor.wide = tissue_.embed_patch(h.anchor, tissue_.spec().hook_tip_mm);
}

}  // namespace limberg
