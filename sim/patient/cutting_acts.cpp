// Cuts and excisions, and incisions that open while they are drawn: piece by piece, each atomic, undone as one.
#include <fmt/format.h>

#include "sim/base/hash.h"
#include "sim/cutting/arrangement/fault.h"
#include "sim/cutting/strokes/blade_build.h"
#include "sim/cutting/strokes/blade_parts.h"
#include "sim/patient/open_stroke.h"
#include "sim/patient/soft_tissue.h"

namespace limberg {
namespace {

/// A point well inside a simple polygon: of the midpoints of the diagonals and the centroid, the first that is inside
/// by the crossing rule; nothing for fewer than three points or no area.
std::optional<ChartPoint> interior_point(const std::vector<ChartPoint>& outline) {
  if (outline.size() < 3) return std::nullopt;
  const auto inside = [&](const ChartPoint& p) {
    bool in = false;
    for (size_t i = 0, j = outline.size() - 1; i < outline.size(); j = i++) {
      const ChartPoint &a = outline[i], &b = outline[j];
      if ((a.y() > p.y()) != (b.y() > p.y()) && p.x() < (b.x() - a.x()) * (p.y() - a.y()) / (b.y() - a.y()) + a.x())
        in = !in;
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

Outcome refusal(const CutResult& made) {
  return {false, made.reason.empty() ? "the blade met no tissue that is not cut already; a new cut was expected"
                                     : made.reason};
}

void pass(FaultPlan* fault) {
  if (fault) fault->strikes();
}

}  // namespace

uint64_t SoftTissue::seed() const {
  Hash64 seed;
  seed.add(spec().seed);
  seed.add(figures_.cuts + 1);
  return seed.value();
}

Acted<TissueChange> SoftTissue::cut(const Incise& c) {
  TissueCut cut(tissue_);
  const CutResult made = cut_stroke(cut, c.path, c.depth_mm, c.angle_deg, c.spline);
  if (!made.ok()) return refusal(made);
  return finish(cut);
}

CutResult SoftTissue::cut_stroke(TissueCut& cut, const std::vector<ChartPoint>& path, double depth_mm, double angle_deg,
                                 bool spline) {
  return cut_whole(tissue_.blade_context(), path, depth_mm, angle_deg, spline,
                   [&](const Blade& blade) { return cut.cut(blade, seed()); });
}

Acted<TissueChange> SoftTissue::cut(const Undermine& c) {
  const AlongHeld held{c.above_held_mm > 0 ? &tissue_.skin() : nullptr, c.above_held_mm};
  const BladeResult blade = build_undermining(tissue_.blade_context(), c.outline, c.depth_mm, held);
  if (!blade.blade) return {false, blade.reason};
  TissueCut cut(tissue_, spec().refine_pockets ? Divide::fronts : Divide::nothing);
  const CutResult made = cut.cut(*blade.blade, seed());
  if (!made.ok()) return refusal(made);
  const DebrisResult shaved = cut.sweep_shavings();
  Acted<TissueChange> acted = finish(cut);
  if (acted.done && shaved.pieces > 0)
    acted.reason = fmt::format("under the defect the blade shaved the bed: {:.0f} mm³ without skin {} swept away",
                               shaved.volume_mm3, shaved.pieces == 1 ? "was" : "in slices were");
  return acted;
}

Acted<TissueChange> SoftTissue::cut(const Excise& c) {
  const std::vector<ChartPoint> outline = closed_outline(c.outline);
  const auto inside = interior_point(outline);
  if (!inside)
    return {false, "the outline encloses nothing; a closed outline around the tissue to remove was expected"};
  std::string reason;
  const auto at = tissue_.find_skin(*inside, reason);
  if (!at) return {false, reason};
  const Vec3 inside_mm = tissue_.version().index->rest_mm(*at);
  TissueCut cut(tissue_);
  if (c.floor) {
    const BladeResult blade = build_plug(tissue_.blade_context(), c.outline, c.depth_mm);
    if (!blade.blade) return {false, blade.reason};
    const CutResult made = cut.cut(*blade.blade, seed(), inside_mm);
    if (!made.ok()) return refusal(made);
    return finish(cut);
  }
  // The walls, as far as they are not there yet; then what they and earlier cuts have freed.
  std::vector<ChartPoint> ring = outline;
  ring.push_back(ring.front());
  const CutResult made = cut_stroke(cut, ring, c.depth_mm, 90, false);
  if (made.status == CutResult::refused) return {false, made.reason};
  if (const Outcome o = cut.take_out(inside_mm); !o.done) return o;
  return finish(cut);
}

Acted<TissueChange> SoftTissue::cut(const ExcisePiece& c) {
  std::string reason;
  const auto at = tissue_.find_skin(c.at, reason);
  if (!at) return {false, reason};
  TissueCut cut(tissue_);
  if (const Outcome o = cut.take_out(*at); !o.done) return o;
  return finish(cut);
}

Acted<TissueChange> SoftTissue::cut(const CutThrough& c) {
  std::string reason;
  std::vector<Vec3> seen = c.path;
  if (c.from_bed)  // the view is of the skin above
    for (Vec3& X : seen)
      if (const SkinHit hit = tissue_.skin().nearest(X); hit.triangle >= 0) X = hit.X_mm;
  const auto view = view_of(tissue_.skin(), seen, reason);
  if (!view) return {false, reason};
  BladeContext context = tissue_.blade_context();
  context.view = &*view;
  context.skin = [&](const ChartPoint& p) { return tissue_.skin().at(p, *view); };
  const BladeResult blade = build_through(
      context, tissue_.skin(), {c.normals, c.open_start, c.open_end, c.from_bed ? c.path : std::span<const Vec3>()});
  if (!blade.blade) return {false, blade.reason};
  TissueCut cut(tissue_);
  const CutResult made = cut.cut(*blade.blade, seed());
  if (!made.ok()) return refusal(made);
  return finish(cut);
}

Acted<TissueChange> SoftTissue::finish(TissueCut& cut) {
  if (const Outcome built = cut.build(); !built.done) return built;
  TissueChange change;
  change.before = moment();
  try {
    contacts_.prepare(cut.built());
    cut.enter();
    pass(spec().fault);
    hooks_.carry();
    sutures_.carry();
    loads_.carry();
    publish_holding();
    pass(spec().fault);
    ++figures_.cuts;
    figures_.removed_volume_mm3 += cut.removed_mm3();
    figures_.volume_mm3 = arrangement()->volume_mm3();
    change.ancestor = tissue_.version().model->parent;
  } catch (...) {
    const FemModel& was = *change.before.version.model;
    return_to(change.before, tissue_.version().model->parent.reversed(was.X_mm.size()));
    throw;
  }
  change.steps = cut.keep();
  return {{true, {}}, std::move(change)};
}

// ---- an incision that opens while it is drawn ----

void SoftTissue::stop_stroke(std::string_view why) noexcept {
  if (!stroke_) return;
  stopped_stroke_ = stroke_->id;
  try {
    why_stopped_ = why;
  } catch (const std::bad_alloc&) {
    why_stopped_.clear();
  }
  stroke_.reset();
}

void SoftTissue::another_act() noexcept {
  if (stroke_ && stroke_->cut) stop_stroke("another act came between");
}

Acted<TissueChange> SoftTissue::cut(const InciseMore& c) {
  if (c.stroke <= 0) return {false, fmt::format("stroke number {}; a positive number was expected", c.stroke)};
  if (stopped_stroke_ == c.stroke) {
    if (c.last) stopped_stroke_ = 0;
    return {false, fmt::format("stroke {} has stopped: {}", c.stroke, why_stopped_)};
  }
  if (!stroke_ || stroke_->id != c.stroke)
    stroke_.reset(new OpenStroke{c.stroke, DrawnStroke(c.depth_mm, c.angle_deg)});
  if (const std::string why = stroke_->drawn.draw(tissue_.blade_context(), c.path); !why.empty()) {
    stop_stroke(why);
    if (c.last) stopped_stroke_ = 0;
    return {false, why};
  }
  Acted<TissueChange> made = cut_on(c.last);
  if (!made.done) stop_stroke(made.reason);
  if (c.last) {
    stroke_.reset();
    stopped_stroke_ = 0;
  }
  return made;
}

Acted<TissueChange> SoftTissue::cut_on(bool last) {
  TissueCut cut(tissue_);
  const CutResult result =
      stroke_->drawn.cut(tissue_.blade_context(), last, [&](const Blade& blade) { return cut.cut(blade, seed()); });
  if (result.status == CutResult::refused) return refusal(result);
  if (cut.empty() && last && !stroke_->cut) return {false, result.reason};
  if (cut.empty()) return {true, {}};
  Acted<TissueChange> made = finish(cut);
  if (!made.done) return made;
  made.goes_on = stroke_->cut;
  stroke_->cut = true;
  return made;
}

}  // namespace limberg
