#include "sim/patient/skin_loads.h"

#include "sim/base/error.h"

namespace limberg {

void SkinLoads::place() {
  holding_.loads.clear();
  for (const SkinLoad& l : tissue_.spec().loads) {
    const std::string name = tissue_.body().name;
    if (!l.force_N.allFinite() || !(l.radius_mm >= 0))
      throw InputError(name, 0, "a load at " + at_text(l.at) + " has no finite force or no radius; both were expected");
    std::string reason;
    std::optional<Anchor> anchor = tissue_.find_anchor(l.at, false, reason);
    if (!anchor) throw InputError(name, 0, "a load lies nowhere: " + reason);
    anchor->wide = tissue_.embed_patch(*anchor, l.radius_mm);
    holding_.loads.push_back({*anchor, l.force_N, l.radius_mm});
  }
}

void SkinLoads::carry() {
  std::erase_if(holding_.loads, [&](PlacedLoad& l) { return !tissue_.carry(l.anchor); });
  for (PlacedLoad& l : holding_.loads) l.anchor.wide = tissue_.embed_patch(l.anchor, l.radius_mm);
}

std::vector<DeadLoad> loads(const Holding& holding) {
  std::vector<DeadLoad> out;
  for (const PlacedLoad& l : holding.loads) out.push_back({l.anchor.wide, 1000 * l.force_N});
  return out;
}

}  // namespace limberg
