// Cuts, excision and undo: one change of topology, from the blade to the surface that is shown.
#include <cmath>

#include "sim/error.h"
#include "sim/hash.h"
#include "sim/lattice/embedding.h"
#include "sim/world/operating_table.h"

namespace limberg {
namespace {

constexpr double kDebris_mm3 = 1;  // the smallest loose piece that counts as tissue

/// A point well inside a simple polygon: of the midpoints of the diagonals and the centroid, the first that is inside
/// by the crossing rule; nothing for fewer than three points or no area.
std::optional<ChartPoint> interior_point(const std::vector<ChartPoint>& outline) {
  if (outline.size() < 3) return std::nullopt;
  const auto inside = [&](const ChartPoint& p) {
    bool in = false;
    for (size_t i = 0, j = outline.size() - 1; i < outline.size(); j = i++) {
      const ChartPoint &a = outline[i], &b = outline[j];
      if ((a.y() > p.y()) != (b.y() > p.y()) && p.x() < (b.x() - a.x()) * (p.y() - a.y()) / (b.y() - a.y()) + a.x()) in = !in;
    }
    return in;
  };
  ChartPoint centroid(0, 0);
  for (const ChartPoint& p : outline) centroid += p / double(outline.size());
  if (inside(centroid)) return centroid;
  for (size_t i = 0; i < outline.size(); ++i)
    for (size_t j = i + 2; j < outline.size(); ++j)
      if (const ChartPoint p = 0.5 * (outline[i] + outline[j]); inside(p)) return p;
  return std::nullopt;
}

}  // namespace

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
  // Blades that nearly coincide leave slivers that no lattice can hold; they go with the cut, and their volume is booked.
  const DebrisResult debris = arrangement_->sweep_debris(kDebris_mm3);
  const Outcome built = rebuild();
  if (!built.done) {
    for (int i = 0; i < before.arrangement_steps; ++i) arrangement_->undo();
    --cuts_;
    return built;
  }
  removed_volume_mm3_ += taken.volume_mm3 + debris.volume_mm3;
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
    // The same surface under a new number: readers take versions to grow.
    auto again = std::make_shared<SurfaceTopology>(*version_.surface);
    again->version = next_version_++;
    version_.surface = again;
    version_.index = std::make_shared<RestIndex>(again->view, body_->surface.tri.size());
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

Outcome OperatingTable::rebuild() {
  Version next;
  try {
    next.lattice = update_topology(*version_.lattice, material_surface(*arrangement_));
    next.model = assemble_fem(*stencils_, *next.lattice);
    next.surface = make_surface(*next.lattice);
  } catch (const InputError& e) {
    return {false, e.what()};
  } catch (const std::logic_error& e) {  // the lattice found a contradiction: nothing has changed yet, the cut is taken back
    return {false, std::string("the lattice cannot follow this cut (") + e.what() + "); a slightly different stroke was expected"};
  }
  next.index = std::make_shared<RestIndex>(next.surface->view, body_->surface.tri.size());
  version_ = next;
  std::vector<int32_t> cell_parent;
  for (const CellCopy& c : version_.lattice->cells) cell_parent.push_back(c.parent);
  solver_->set_model(version_.model, cell_parent);
  carry_anchors();
  publish_springs();
  return {true, {}};
}

std::shared_ptr<const SurfaceTopology> OperatingTable::make_surface(const LatticeTopology& lattice) {
  auto surface = std::make_shared<SurfaceTopology>();
  surface->version = next_version_++;
  surface->body = body_;
  surface->view = arrangement_->surface_view();
  surface->embedding = embed_surface(lattice, material_surface(*arrangement_), surface->view);
  // Depths are remembered by point: points of the arrangement never move.
  const SurfaceView& view = surface->view;
  surface->depth_mm.resize(view.X_mm.size());
  for (size_t v = 0; v < view.X_mm.size(); ++v) {
    const size_t point = size_t(view.point[v]);
    if (point >= depth_of_point_mm_.size()) depth_of_point_mm_.resize(point + 1, std::nanf(""));
    float& depth = depth_of_point_mm_[point];
    if (std::isnan(depth)) depth = float(skin_.depth_mm(view.X_mm[v]));
    surface->depth_mm[v] = depth;
  }
  Hash64 h;
  h.add(arrangement_->hash());
  h.add(lattice.hash);
  surface->hash = h.value();
  return surface;
}

}  // namespace limberg
