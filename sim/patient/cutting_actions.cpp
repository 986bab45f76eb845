// Cuts and excision: one change of topology, from the blade to the surface that is shown.
#include <cmath>

#include "sim/base/error.h"
#include "sim/base/hash.h"
#include "sim/cutting/strokes/stroke_plan.h"
#include "sim/lattice/embedding.h"
#include "sim/lattice/region.h"
#include "sim/patient/operating_table.h"

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

}  // namespace

BladeContext OperatingTable::blade_context() const {
  BladeContext c;
  c.body = body_.get();
  c.arrangement = arrangement_.get();
  c.skin = [this](const ChartPoint& p) { return skin_.at(p); };
  c.gradient = [this](const SkinHit& hit) -> Mat3 {
    const auto at = version_.index->locate(hit.X_mm, hit.triangle, 1e-2);
    if (!at) return Mat3::Identity();
    const SurfaceView& view = version_.surface->view;
    const int32_t cell = view.cell_copy[size_t(view.tri[size_t(at->triangle)][0])];
    return cell < 0 ? Mat3(Mat3::Identity()) : solver_->cell_F(cell);
  };
  return c;
}

Outcome OperatingTable::act(const Incise& c) {
  if (!arrangement_) return {false, "this scene cannot be cut; can_cut = true was expected in the scene"};
  Done done;
  done.before = moment();
  const CutResult made = cut_stroke(c.path, c.depth_mm, c.angle_deg, c.spline, done.steps);
  if (!made.ok())
    return {false, made.reason.empty() ? "the blade met no tissue that is not cut already; a new cut was expected"
                                       : made.reason};
  return finish(std::move(done));
}

CutResult OperatingTable::cut_stroke(const std::vector<ChartPoint>& path, double depth_mm, double angle_deg,
                                     bool spline, std::vector<CutStep>& steps) {
  const BladeContext context = blade_context();
  return carry_out(
      plan_stroke(context, path, depth_mm, angle_deg, spline), context,
      [&](const Blade& blade) {
        CutStep step;
        CutResult one;
        if (cut_arrangement(blade, false, Vec3::Zero(), step, one).done) steps.push_back(std::move(step));
        return one;
      },
      [&] {
        take_back({&steps.back(), 1});
        steps.pop_back();
      });
}

Outcome OperatingTable::act(const Undermine& c) {
  if (!arrangement_) return {false, "this scene cannot be cut; can_cut = true was expected in the scene"};
  const struct Ends {
    Divide& divide;
    ~Ends() { divide = Divide::fronts; }
  } ends{divide_};
  if (!spec_.refine_pockets) divide_ = Divide::nothing;
  return cut(build_undermining(blade_context(), c.outline, c.depth_mm), false, {});
}

Outcome OperatingTable::act(const Excise& c) {
  if (!arrangement_) return {false, "this scene cannot be cut; can_cut = true was expected in the scene"};
  const auto inside = interior_point(c.outline);
  if (!inside)
    return {false, "the outline encloses nothing; a closed outline around the tissue to remove was expected"};
  std::string reason;
  const auto at = find_skin(*inside, reason);
  if (!at) return {false, reason};
  const Vec3 inside_mm = version_.index->rest_mm(*at);
  if (c.floor) return cut(build_plug(blade_context(), c.outline, c.depth_mm), true, inside_mm);
  // The walls, as far as they are not there yet; then what they and earlier cuts have freed.
  std::vector<ChartPoint> ring = c.outline;
  ring.push_back(ring.front());
  Done done;
  done.before = moment();
  const CutResult made = cut_stroke(ring, c.depth_mm, 90, false, done.steps);
  if (made.status == CutResult::refused) return {false, made.reason};
  if (!done.steps.empty())
    if (const Outcome o = follow(); !o.done) {
      take_back(done.steps);
      return o;
    }
  CutStep taking;
  taking.excised = arrangement_->loose_component_near(inside_mm, 0.01);
  const ExciseResult taken = taking.excised < 0 ? ExciseResult{} : arrangement_->excise(taking.excised);
  if (!taken.done) {
    take_back(done.steps);
    return {false,
            "the tissue inside the outline is still attached; walls that reach through, or undermining below it, were "
            "expected"};
  }
  taking.debris = arrangement_->sweep_debris(kDebris_mm3);
  taking.taken_mm3 = taken.volume_mm3;
  taking.hash_after = arrangement_->hash();
  done.steps.push_back(std::move(taking));
  return finish(std::move(done));
}

Outcome OperatingTable::cut_arrangement(const Blade& blade, bool take_out, const Vec3& inside_mm, CutStep& step,
                                        CutResult& made) {
  Hash64 seed;
  seed.add(spec_.seed);
  seed.add(cuts_ + 1);
  step = CutStep{};
  step.seed = seed.value();
  made = arrangement_->cut(blade, step.seed);
  if (!made.ok())
    return {false, made.reason.empty() ? "the blade met no tissue that is not cut already; a new cut was expected"
                                       : made.reason};
  step.first_try = made.tries - 1;
  const auto refuse = [&](const std::string& why) {
    arrangement_->undo();
    made = CutResult{};
    made.reason = why;
    return Outcome{false, why};
  };
  const bool takes = take_out || arrangement_->find_debris(kDebris_mm3).pieces > 0;
  if (takes)
    if (const Outcome o = follow(); !o.done) return refuse(o.reason);
  if (take_out) {
    step.excised = arrangement_->loose_component_near(inside_mm, 0.01);
    const ExciseResult taken =
        step.excised < 0
            ? ExciseResult{false,
                           "the tissue inside the outline is still attached; a plug free of its bed was expected", 0, 0}
            : arrangement_->excise(step.excised);
    if (!taken.done) {
      followed_.reset();
      return refuse(taken.reason);
    }
    step.operations = 2;
    step.taken_mm3 = taken.volume_mm3;
  }
  // Blades that nearly coincide leave slivers that no lattice can hold; they go with the cut, and their volume is
  // booked.
  step.debris = arrangement_->sweep_debris(kDebris_mm3);
  if (takes)
    if (const Outcome o = follow(); !o.done) {
      followed_.reset();
      if (step.operations == 2) arrangement_->undo();
      return refuse(o.reason);
    }
  step.blade = blade;
  step.hash_after = arrangement_->hash();
  return {true, {}};
}

Outcome OperatingTable::cut(const BladeResult& blade, bool take_out, const Vec3& inside_mm) {
  if (!blade.blade) return {false, blade.reason};
  Done done;
  done.before = moment();
  CutStep step;
  CutResult made;
  if (const Outcome o = cut_arrangement(*blade.blade, take_out, inside_mm, step, made); !o.done) return o;
  done.steps.push_back(std::move(step));
  return finish(std::move(done));
}

Outcome OperatingTable::finish(Done done) {
  const Outcome built = rebuild();
  if (!built.done) {
    take_back(done.steps);
    return built;
  }
  ++cuts_;
  for (const CutStep& s : done.steps) removed_volume_mm3_ += s.taken_mm3 + s.debris.volume_mm3;
  volume_mm3_ = arrangement_->volume_mm3();
  done.ancestor = version_.model->parent;
  remember(std::move(done));
  return {true, {}};
}

Outcome OperatingTable::follow() {
  if (followed_ && followed_hash_ == arrangement_->hash()) return {true, {}};
  try {
    const auto next = update_topology(followed_ ? *followed_ : *version_.lattice, material_surface(*arrangement_),
                                      &workers_, divide_);
    followed_ = followed_ ? skip_version(*followed_, *next) : next;
    followed_hash_ = arrangement_->hash();
  } catch (const InputError& e) {
    return {false, e.what()};
  } catch (
      const std::logic_error& e) {  // the lattice found a contradiction: nothing has changed yet, the cut is taken back
    return {false, std::string("the lattice cannot follow this cut (") + e.what() +
                       "); a slightly different stroke was expected"};
  }
  return {true, {}};
}

// Three parts hang together only at their ends: the surface that is drawn, the lattice with its model, and the
// embedding of the one in the other. So the first is made beside the lattice, and the model beside the embedding.
Outcome OperatingTable::rebuild() {
  Version next;
  Drawn drawn;
  const EarlierModel before{*version_.lattice, *version_.model};
  const std::shared_ptr<Workers::Job> drawing = workers_.submit([&] { drawn = draw_surface(); });
  std::shared_ptr<Workers::Job> assembling;
  struct Finish {  // nobody goes on before the jobs have let go of this frame
    const std::shared_ptr<Workers::Job>& job;
    ~Finish() {
      try {
        if (job) job->wait();
      } catch (...) {  // told where it was first waited for
      }
    }
  };
  const Finish finish_drawing{drawing}, finish_assembling{assembling};
  if (const Outcome o = follow(); !o.done) return o;
  try {
    next.lattice = followed_;
    assembling = workers_.submit(
        [&] { next.model = hold_outside(assemble_fem(*stencils_, *next.lattice, &before), *body_, spec_.region_mm); });
    drawing->wait();
    make_surface(next, std::move(drawn));
    assembling->wait();
  } catch (const InputError& e) {
    return {false, e.what()};
  } catch (const std::logic_error& e) {
    return {false, std::string("the model cannot follow this cut (") + e.what() +
                       "); a slightly different stroke was expected"};
  }
  followed_.reset();
  version_ = next;
  solver_->set_model(version_.model, version_.lattice->cell_parent);
  carry_anchors();
  publish_springs();
  return {true, {}};
}

OperatingTable::Drawn OperatingTable::draw_surface() {
  Drawn d;
  d.surface = std::make_shared<SurfaceTopology>();
  d.surface->body = body_;
  SurfaceView& view = d.surface->view;
  if (version_.surface) {  // most of it is as it was
    view = arrangement_->surface_view(version_.surface->view, version_.lattice->operations, d.change);
    d.index = std::make_shared<RestIndex>(view, *version_.index, d.change);
  } else {
    d.change.whole = true;
    view = arrangement_->surface_view();
    d.index = std::make_shared<RestIndex>(view, body_->surface.tri.size());
  }
  d.on_skin = version_.on_skin;
  d.surface->depth_mm = depths_.follow(view, d.change, shared_skin_, d.on_skin);
  return d;
}

void OperatingTable::make_surface(Version& next, Drawn drawn) {
  const std::shared_ptr<SurfaceTopology>& surface = drawn.surface;
  surface->version = next_version_++;
  const MaterialSurface material = material_surface(*arrangement_);
  SurfaceView& view = surface->view;
  if (version_.surface) {
    const SurfaceTopology& before = *version_.surface;
    surface->embedding =
        embed_surface(*next.lattice, material, view, {*version_.lattice, before.view, before.embedding, drawn.change});
  } else {
    surface->embedding = embed_surface(*next.lattice, material, view);
  }
  next.index = drawn.index;
  next.on_skin = drawn.on_skin;
  Hash64 h;  // a few numbers that another state hardly shares; topology_hash() tells all
  h.add(arrangement_->hash());
  h.add(next.lattice->pieces);
  h.add(uint64_t(next.lattice->cells.size()));
  h.add(uint64_t(next.lattice->nodes.size()));
  surface->hash = h.value();
  next.surface = surface;
  next.arrangement_hash = arrangement_->hash();
}

uint64_t OperatingTable::topology_hash() const {
  if (hash_version_ != version_.surface->version) {
    Hash64 h;
    h.add(version_.arrangement_hash);
    h.add(version_.lattice->hash());
    hash_ = h.value();
    hash_version_ = version_.surface->version;
  }
  return hash_;
}

}  // namespace limberg
