#include "sim/patient/tissue_cut.h"

#include <algorithm>

#include "sim/base/error.h"
#include "sim/cutting/arrangement/point_store.h"
#include "sim/geometry/triangle.h"
#include "sim/lattice/contradiction.h"
#include "sim/lattice/embedding.h"
#include "sim/lattice/material_surface.h"
#include "sim/lattice/region.h"

namespace limberg {
namespace {

// Of the surface of a piece that is taken out by touching it: more is one that sits on the bone.
constexpr double kMostHeld = 0.12;
// Of the surface of a slice off a bed: hairs of it, where two blades ran along the same wall.
constexpr double kShavedSkin = 0.02;

}  // namespace

TissueCut::TissueCut(Tissue& tissue, Divide divide)
    : tissue_(tissue),
      arrangement_(*tissue.arrangement_),
      divide_(divide),
      operations_before_(arrangement_.operations()) {}

TissueCut::~TissueCut() {
  if (!kept_) back_to(operations_before_);
}

void TissueCut::back_to(int32_t operations) {
  while (arrangement_.operations() > operations) arrangement_.undo();
  if (followed_operations_ > operations) followed_.reset();
}

CutResult TissueCut::cut(const Blade& blade, uint64_t seed, const std::optional<Vec3>& take_out_mm) {
  const int32_t before = arrangement_.operations();
  CutStep step;
  step.seed = seed;
  CutResult made = arrangement_.cut(blade, seed);
  if (!made.ok()) return made;
  step.first_try = made.tries - 1;
  const auto refuse = [&](const std::string& why) {
    back_to(before);
    CutResult r;
    r.reason = why;
    return r;
  };
  const bool takes = take_out_mm || arrangement_.find_debris(kDebris_mm3).pieces > 0;
  if (takes)
    if (const Outcome o = follow(); !o.done) return refuse(o.reason);
  if (take_out_mm) {
    step.excised = arrangement_.loose_component_near(*take_out_mm, 0.01);
    if (step.excised < 0)
      return refuse("the tissue inside the outline is still attached; a plug free of its bed was expected");
    const ExciseResult taken = arrangement_.excise(step.excised);
    if (!taken.done) return refuse(taken.reason);
    step.operations = 2;
    step.taken_mm3 = taken.volume_mm3;
  }
  // Blades that nearly coincide leave slivers that no lattice can hold; they go with the cut, and their volume is
  // booked.
  step.debris = arrangement_.sweep_debris(kDebris_mm3);
  if (takes)
    if (const Outcome o = follow(); !o.done) return refuse(o.reason);
  step.blade = blade;
  step.hash_after = arrangement_.hash();
  steps_.push_back(std::move(step));
  return made;
}

Outcome TissueCut::take_out(const Vec3& at_mm) {
  if (!steps_.empty())
    if (const Outcome o = follow(); !o.done) return o;
  return take(arrangement_.loose_component_near(at_mm, 0.01),
              "the tissue inside the outline is still attached; walls that reach through, or undermining below it, "
              "were expected");
}

double TissueCut::held_share(int32_t component) const {
  const SurfaceView& view = tissue_.surface().view;
  double all = 0, held = 0;
  for (size_t t = 0; t < view.tri.size(); ++t) {
    if (arrangement_.component_of(view.sided_face[t]) != component) continue;
    const Tri& c = view.tri[t];
    const double area = area_vector2(view.X_mm[size_t(c[0])], view.X_mm[size_t(c[1])], view.X_mm[size_t(c[2])]).norm();
    all += area;
    if (view.kind[t] == FaceKind::fixed) held += area;
  }
  return all > 0 ? held / all : 1;
}

Outcome TissueCut::take_out(const SurfacePoint& touched) {
  const std::vector<SurfaceComponent>& all = arrangement_.components();
  const int32_t c = arrangement_.component_of(tissue_.surface().view.sided_face[size_t(touched.triangle)]);
  const bool held = c < 0 || (all[size_t(c)].touches_fixed && held_share(c) > kMostHeld);
  const bool most = c >= 0 && 2 * all[size_t(c)].volume_mm3 > arrangement_.volume_mm3();
  return take(
      held || most ? -1 : c,
      "the tissue there is still attached; a piece that cuts have freed all round was expected (incise round it "
      "and undermine it, or give \"outline\" and \"depth_mm\")");
}

int32_t TissueCut::shaving() const {
  const std::vector<SurfaceComponent>& all = arrangement_.components();
  std::vector<double> area(all.size(), 0), skin(all.size(), 0);
  const auto loose = [&](int32_t c) {
    return c >= 0 && !all[size_t(c)].touches_fixed && all[size_t(c)].volume_mm3 > 0;
  };
  if (std::none_of(all.begin(), all.end(), [&](const auto& c) { return loose(int32_t(&c - all.data())); })) return -1;
  const MaterialSurface s = material_surface(arrangement_);
  for (size_t f = 0; f < s.faces.size(); ++f)
    for (int side = 0; side < 2; ++side) {
      const int32_t c = s.faces[f].has_side(side) ? arrangement_.component_of(sided_face(int32_t(f), side)) : -1;
      if (!loose(c)) continue;
      std::array<Vec3, 3> X;
      for (size_t k = 0; k < 3; ++k) X[k] = s.grid.half_unit_mm() * s.points->approx(s.faces[f].v[k]);
      const double mm2 = 0.5 * area_vector2(X[0], X[1], X[2]).norm();
      const size_t o = size_t(s.faces[f].orig);
      area[size_t(c)] += mm2;
      if (s.orig[o].op == 0 && o < s.tag.size() && s.tag[o] == SurfaceTag::skin) skin[size_t(c)] += mm2;
    }
  for (size_t c = 0; c < all.size(); ++c)
    if (loose(int32_t(c)) && 2 * all[c].volume_mm3 < kShaving_mm * area[c] && skin[c] < kShavedSkin * area[c])
      return int32_t(c);
  return -1;
}

DebrisResult TissueCut::sweep_shavings() {
  DebrisResult swept;
  for (int32_t c = shaving(); c >= 0; c = shaving()) {
    const double before = removed_mm3();
    if (!follow().done || !take(c, "").done) break;
    ++swept.pieces, swept.volume_mm3 += removed_mm3() - before;
  }
  return swept;
}

Outcome TissueCut::take(int32_t component, const char* attached) {
  CutStep step;
  step.excised = component;
  const ExciseResult taken = component < 0 ? ExciseResult{} : arrangement_.excise(component);
  if (!taken.done) return {false, taken.reason.empty() ? attached : taken.reason};
  step.debris = arrangement_.sweep_debris(kDebris_mm3);
  step.taken_mm3 = taken.volume_mm3;
  step.hash_after = arrangement_.hash();
  steps_.push_back(std::move(step));
  return {true, {}};
}

void TissueCut::make_room_to_take_back(Tissue& tissue, std::span<const CutStep> steps) {
  int32_t operations = 0;
  for (const CutStep& s : steps) operations += s.operations;
  if (operations > 0) tissue.arrangement_->make_room_to_undo(operations);
}

void TissueCut::take_back(Tissue& tissue, std::span<const CutStep> steps) {
  for (size_t i = steps.size(); i-- > 0;)
    for (int k = 0; k < steps[i].operations; ++k) tissue.arrangement_->undo();
}

bool TissueCut::again(const CutStep& s) {
  const int32_t before = arrangement_.operations();
  if (!s.blade.tri.empty() && !arrangement_.cut(s.blade, s.seed, s.first_try).ok()) return false;
  if (s.excised >= 0) arrangement_.excise(s.excised);
  arrangement_.sweep_debris(kDebris_mm3);
  return arrangement_.operations() - before == s.operations && arrangement_.hash() == s.hash_after;
}

double TissueCut::removed_mm3() const {
  double sum = 0;
  for (const CutStep& s : steps_) sum += s.taken_mm3 + s.debris.volume_mm3;
  return sum;
}

Outcome TissueCut::follow() {
  if (followed_ && followed_hash_ == arrangement_.hash()) return {true, {}};
  try {
    const auto next = update_topology(followed_ ? *followed_ : *tissue_.version_.lattice,
                                      material_surface(arrangement_), &tissue_.workers_, divide_);
    followed_ = followed_ ? skip_version(*followed_, *next) : next;
    followed_hash_ = arrangement_.hash();
    followed_operations_ = arrangement_.operations();
  } catch (const InputError& e) {
    return {false, e.what()};
  } catch (const Contradiction& e) {
    return {false, std::string("the lattice cannot follow this cut (") + e.what() +
                       "); a slightly different stroke was expected"};
  }
  return {true, {}};
}

// Three parts hang together only at their ends: the surface that is drawn, the lattice with its model, and the
// embedding of the one in the other. So the first is made beside the lattice, and the model beside the embedding.
Outcome TissueCut::build() {
  Tissue& t = tissue_;
  next_ = {};
  next_.activation = tissue_.version_.activation;
  Tissue::Drawn drawn;
  const EarlierModel before{*t.version_.lattice, *t.version_.model};
  const std::shared_ptr<Workers::Job> drawing = t.workers_.submit([&] { drawn = t.draw_surface(); });
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
    next_.lattice = followed_;
    make_parts_ready(*t.stencils_, *next_.lattice, &before.topology, t.workers_);
    assembling = t.workers_.submit([&] {
      const MaterialSurface surface = material_surface(arrangement_);
      next_.model =
          hold_outside(assemble_fem(*t.stencils_, *next_.lattice, &before, &surface), *t.body_, t.spec_.region_mm);
    });
    drawing->wait();
    t.make_surface(next_, std::move(drawn));
    assembling->wait();
  } catch (const InputError& e) {
    return {false, e.what()};
  } catch (const Contradiction& e) {
    return {false, std::string("the model cannot follow this cut (") + e.what() +
                       "); a slightly different stroke was expected"};
  }
  return {true, {}};
}

void TissueCut::enter() {
  tissue_.version_ = next_;
  tissue_.solver_->set_model(next_.model, next_.lattice->cell_parent);
}

std::vector<CutStep> TissueCut::keep() {
  kept_ = true;
  return std::move(steps_);
}

}  // namespace limberg
