#include "sim/patient/tissue.h"

#include <fmt/format.h>

#include "sim/base/error.h"
#include "sim/base/hash.h"
#include "sim/cutting/strokes/blade_build.h"
#include "sim/fem/solver/focus_solver.h"
#include "sim/fem/solver/region_solver.h"
#include "sim/lattice/embedding.h"
#include "sim/lattice/grid_fit.h"
#include "sim/lattice/region.h"
#include "sim/patient/region_colours.h"
#include "sim/patient/skin_patch.h"

namespace limberg {
namespace {

constexpr double kMissing_mm = 1.5;  // a point this near to living skin still means that skin (tracker noise at a rim)

Grading grading_of(const WorldSpec& spec, const Skin& skin) {
  Grading out;
  if (spec.can_cut) out.wound_level = spec.wound_level;
  for (const FineZone& f : spec.fine) {
    const auto from = skin.at(f.at), to = skin.at(f.to);
    if (!from || !to)
      throw InputError(spec.body->name, 0,
                       "a fine zone of the lattice lies off the skin at " + at_text(from ? f.to : f.at) +
                           "; a place on the skin was expected");
    if (f.level > 0) out.zones.push_back({from->X_mm, to->X_mm, -from->normal, f.radius_mm, f.depth_mm, f.level});
  }
  return out;
}

}  // namespace

Tissue::Tissue(WorldSpec spec, Workers& workers)
    : spec_(std::move(spec)),
      body_(spec_.body),
      skin_(std::make_shared<const Skin>(spec_.body)),
      workers_(workers),
      arrangement_(std::make_unique<Arrangement>(body_->surface, body_->grid)) {
  const int front_levels = spec_.can_cut && spec_.refine_fronts ? kLevels : 0;
  const Grading grading = grading_of(spec_, *skin_);
  const LatticeGrid grid = fit_lattice(*body_, spec_.cell_mm, front_levels > 0 || !grading.empty() ? kLevels : 0);
  stencils_ = std::make_unique<StencilTable>(*skin_, grid);
  version_.activation = stencils_->activation();
  version_.lattice = build_topology(grid, material_surface(*arrangement_), front_levels, grading);
  make_parts_ready(*stencils_, *version_.lattice, nullptr, workers);
  version_.model = hold_outside(assemble_fem(*stencils_, *version_.lattice), *body_, spec_.region_mm);
  make_surface(version_, draw_surface());
  initial_volume_mm3_ = arrangement_->volume_mm3();
  if (!spec_.can_cut) arrangement_.reset();
  if (arrangement_) arrangement_->set_fault(spec_.fault);
  solver_ = spec_.region_mm > 0 ? make_region_solver(workers) : make_focus_solver(workers, spec_.focus);
  solver_->set_gravity(spec_.gravity_m_s2);
  solver_->set_model(version_.model, {});
}

BladeContext Tissue::blade_context() const {
  BladeContext c;
  c.body = body_.get();
  c.arrangement = arrangement_.get();
  c.skin = [this](const ChartPoint& p) { return skin_at(p); };
  c.view = look_ ? look_->view : nullptr;
  c.gradient = [this](const SkinHit& hit) -> Mat3 {
    const auto at = version_.index->locate(hit.X_mm, hit.triangle, 1e-2);
    if (!at) return Mat3::Identity();
    const SurfaceView& view = version_.surface->view;
    const int32_t cell = view.cell_copy[size_t(view.tri[size_t(at->triangle)][0])];
    return cell < 0 ? Mat3(Mat3::Identity()) : solver_->cell_F(cell);
  };
  return c;
}

std::string Tissue::place_text(const ChartPoint& p) const {
  return look_ && look_->place_mm ? at_text(look_->place_mm(p)) : at_text(p);
}

std::optional<SurfacePoint> Tissue::find_skin(const ChartPoint& p, std::string& reason) const {
  if (!p.allFinite())
    return reason = "the point is not a number; two finite coordinates in mm were expected", std::nullopt;
  const auto hit = skin_at(p);
  if (!hit)
    return reason = "point " + place_text(p) + " lies off the skin; a point on the skin was expected", std::nullopt;
  auto point = version_.index->locate(hit->X_mm, hit->triangle, 1e-2);
  if (!point) point = version_.index->nearest_skin(hit->X_mm, kMissing_mm);
  if (!point) reason = "the skin at " + place_text(p) + " has been removed; a point on remaining skin was expected";
  return point;
}

std::optional<Anchor> Tissue::find_anchor(const ChartPoint& p, bool on_rim, std::string& reason) const {
  auto point = find_skin(p, reason);
  if (!point) return std::nullopt;
  if (on_rim)
    if (const auto rim = version_.index->snap_to_rim(*point, kStitchReach_mm)) point = rim;
  Anchor anchor = make_anchor(version_.surface->view, *version_.index, *point);
  anchor.embedded = embed(anchor.at);
  return anchor;
}

std::optional<Anchor> Tissue::find_in_wall(const ChartPoint& p, HeldSide side, std::string& reason) const {
  if (!look_)
    return reason = fmt::format("\"{}\" of a point on the chart; a place [x, y, z] on the cut face was expected",
                                kHeldSides[size_t(side)]),
           std::nullopt;
  const Vec3 X = look_->place_mm(p);
  auto anchor = make_wall_anchor(version_.surface->view, *version_.index, *skin_, X, side);
  if (anchor) anchor->embedded = embed(anchor->at);
  if (!anchor)
    reason = fmt::format(
        "there is no cut face of the kind \"{}\" within {:g} mm of {}; a place on one, where "
        "it lay at rest, was expected",
        kHeldSides[size_t(side)], kWallReach_mm, at_text(X));
  return anchor;
}

EmbeddedPoint Tissue::embed(const SurfacePoint& p) const {
  return embed_point(*version_.lattice, version_.surface->view, p.triangle, {p.bary.x(), p.bary.y(), p.bary.z()});
}

std::vector<HeldPlace> Tissue::embed_patch(const Anchor& anchor, double radius_mm) const {
  std::vector<HeldPlace> out;
  for (const SurfacePoint& p : skin_patch(version_.surface->view, anchor.at, radius_mm)) out.push_back(embed(p));
  return out;
}

std::vector<HeldPlace> Tissue::embed_bite(const SurfacePoint& at, double radius_mm) const {
  std::vector<HeldPlace> out;
  for (const auto& [place, share] : bite_patch(version_.surface->view, at, radius_mm))
    out.emplace_back(embed(place), share);
  return out;
}

bool Tissue::carry(Anchor& anchor) const {
  const auto next = carry_anchor(anchor, version_.surface->view, *version_.index);
  if (!next) return false;
  anchor = *next;
  anchor.embedded = embed(anchor.at);
  return true;
}

Vec3 Tissue::held_mm(const Anchor& a) const {
  if (a.wide.empty()) return position_mm(a.embedded);
  Vec3 sum = Vec3::Zero();
  double all = 0;
  for (const HeldPlace& p : a.wide) sum += p.share * position_mm(p), all += p.share;
  return sum / all;
}

const RimWalk& Tissue::rim() const {
  if (!rim_ || rim_version_ != version_.surface->version)
    rim_ = std::make_unique<RimWalk>(version_.surface->view), rim_version_ = version_.surface->version;
  return *rim_;
}

void Tissue::hold_at(const std::function<Vec3(const Vec3&)>& where) {
  const FemModel& m = *version_.model;
  const std::span<const Vec3f> was = solver_->displacement_mm();
  std::vector<Vec3f> u(was.begin(), was.end());
  bool other = false;
  for (size_t i = 0; i < u.size(); ++i) {
    if (!m.fixed[i].any()) continue;
    Vec3f to = (where(m.X_mm[i]) - m.X_mm[i]).cast<float>();
    for (int a = 0; a < 3; ++a)
      if (!m.fixed[i].along(a)) to[a] = u[i][a];
    other |= to != u[i];
    u[i] = to;
  }
  if (other) solver_->set_displacement_mm(u);
}

void Tissue::activate(std::vector<double> activation) {
  stencils_->activate(activation);
  auto model = std::make_shared<FemModel>(*version_.model);
  model->laws = stencils_->laws();
  model->parent = ParentList::identity(model->X_mm.size());
  model->born.clear();
  version_.model = model, version_.activation = std::move(activation);
  solver_->set_model(version_.model, ParentList::identity(model->cells.size()));
}

void Tissue::return_to(const TissueVersion& version, ParentList parent) {
  if (version.lattice == version_.lattice) {
    if (version.activation != version_.activation) activate(version.activation);
    return;
  }
  stencils_->activate(version.activation);
  version_ = version;
  // The same surface under a new number: readers take versions to grow.
  auto surface = std::make_shared<SurfaceTopology>(*version.surface);
  surface->version = next_version_++;
  version_.surface = surface;
  // The same model, for a solver that comes from another side of it than when it was made.
  auto model = std::make_shared<FemModel>(*version.model);
  model->parent = std::move(parent);
  version_.model = model;
  solver_->set_model(version_.model, {});
}

Tissue::Drawn Tissue::draw_surface() {
  Drawn d;
  d.surface = std::make_shared<SurfaceTopology>();
  d.surface->body = body_, d.surface->image = spec_.image;
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
  d.surface->depth_mm = depths_.follow(view, d.change, skin_, d.on_skin);
  d.surface->layers_mm = skin_->even() ? d.surface->depth_mm : layers_.follow(view, d.change, skin_, d.on_skin);
  return d;
}

void Tissue::make_surface(TissueVersion& next, Drawn drawn) {
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
  surface->rgba = region_colours(*skin_, view, version_.surface.get());
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

uint64_t Tissue::topology_hash() const {
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
