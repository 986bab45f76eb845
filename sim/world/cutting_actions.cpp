// Cuts, excision and undo: one change of topology, from the blade to the surface that is shown.
#include <algorithm>

#include "sim/hash.h"
#include "sim/lattice/embedding.h"
#include "sim/world/operating_table.h"

namespace limberg {

OperatingTable::Done OperatingTable::remember(bool is_cut, int arrangement_steps) const {
  Done d;
  d.is_cut = is_cut;
  d.arrangement_steps = arrangement_steps;
  d.stitches = stitches_;
  if (!is_cut) return d;
  d.before = version_;
  const std::span<const Vec3f> u = solver_->displacement_mm();
  d.displacement.assign(u.begin(), u.end());
  d.hooks = hooks_;
  d.volume_mm3 = volume_mm3_;
  d.removed_volume_mm3 = removed_volume_mm3_;
  return d;
}

BladeContext OperatingTable::blade_context() const {
  BladeContext c;
  c.body = body_.get();
  c.arrangement = arrangement_.get();
  c.skin = [this](const ChartPoint& p) { return skin_.at(p); };
  return c;
}

Outcome OperatingTable::act(const Incise& c) {
  if (!arrangement_) return {false, "this scene cannot be cut; can_cut = true was expected in the scene"};
  return cut(build_incision(blade_context(), c.path, c.depth_mm, c.angle_deg), false, {});
}

Outcome OperatingTable::act(const Undermine& c) {
  if (!arrangement_) return {false, "this scene cannot be cut; can_cut = true was expected in the scene"};
  return cut(build_undermining(blade_context(), c.outline, c.depth_mm), false, {});
}

Outcome OperatingTable::act(const Excise& c) {
  if (!arrangement_) return {false, "this scene cannot be cut; can_cut = true was expected in the scene"};
  const auto inside = interior_point(c.outline);
  if (!inside) return {false, "the outline encloses nothing; a closed outline around the tissue to remove was expected"};
  std::string reason;
  const auto at = find_skin(*inside, reason);
  if (!at) return {false, reason};
  return cut(build_plug(blade_context(), c.outline, c.depth_mm), true, version_.index->rest_mm(*at));
}

Outcome OperatingTable::cut(const BladeResult& blade, bool take_out, const Vec3& inside_mm) {
  if (!blade.blade) return {false, blade.reason};
  Done before = remember(true, 1);
  Hash64 seed;
  seed.add(spec_.seed);
  seed.add(++cuts_);
  const CutResult made = arrangement_->cut(*blade.blade, seed.value());
  if (!made.ok()) {
    --cuts_;
    return {false, made.reason.empty() ? "the blade met no tissue that is not cut already; a new cut was expected" : made.reason};
  }
  ExciseResult taken;
  if (take_out) {
    const int32_t component = arrangement_->loose_component_near(inside_mm, 0.01);
    taken = component < 0 ? ExciseResult{false, "the tissue inside the outline is still attached; a plug free of its bed was expected", 0, 0}
                          : arrangement_->excise(component);
    if (!taken.done) {
      arrangement_->undo();
      --cuts_;
      return {false, taken.reason};
    }
    before.arrangement_steps = 2;
  }
  const Outcome built = rebuild(before.arrangement_steps);
  if (!built.done) {
    for (int i = 0; i < before.arrangement_steps; ++i) arrangement_->undo();
    --cuts_;
    return built;
  }
  removed_volume_mm3_ += taken.volume_mm3;
  volume_mm3_ = arrangement_->volume_mm3();
  done_.push_back(std::move(before));
  return {true, {}};
}

Outcome OperatingTable::act(const Undo&) {
  if (done_.empty()) return {false, "there is nothing to undo; a cut, an excision or a stitch before it was expected"};
  Done d = std::move(done_.back());
  done_.pop_back();
  stitches_ = std::move(d.stitches);
  if (d.is_cut) {
    for (int i = 0; i < d.arrangement_steps; ++i) arrangement_->undo();
    version_ = std::move(d.before);
    restore_lattice();
    solver_->set_model(version_.model, {});
    solver_->set_displacement_mm(d.displacement);
    hooks_ = std::move(d.hooks);
    volume_mm3_ = d.volume_mm3;
    removed_volume_mm3_ = d.removed_volume_mm3;
    --cuts_;
  }
  publish_springs();
  return {true, {}};
}

}  // namespace limberg
