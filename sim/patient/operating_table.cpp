#include "sim/patient/operating_table.h"

#include <algorithm>
#include <cmath>

#include "sim/base/hash.h"
#include "sim/contact/contact_finder.h"
#include "sim/cutting/arrangement/store.h"
#include "sim/fem/solver/region_solver.h"
#include "sim/lattice/embedding.h"
#include "sim/lattice/grid_fit.h"
#include "sim/lattice/region.h"

namespace limberg {
namespace {

// Until contacts follow: iterations of the minimiser, and how far it may go. (10 instead of 20: as much overlap in both
// shipped operations, and 69 and 44 % more searches, 2026-11-22.)
constexpr int kIterationsOfContacts = 20;
constexpr double kMoveOfContacts_mm = 1.5;

}  // namespace

OperatingTable::OperatingTable(WorldSpec spec, Workers& workers)
    : spec_(std::move(spec)),
      body_(spec_.body),
      shared_skin_(std::make_shared<const Skin>(spec_.body)),
      skin_(*shared_skin_),
      arrangement_(std::make_unique<Arrangement>(body_->surface, body_->grid)),
      workers_(workers) {
  const int front_levels = spec_.can_cut && spec_.refine_fronts ? kLevels : 0;
  const LatticeGrid grid = fit_lattice(*body_, spec_.cell_mm, front_levels);
  stencils_ = std::make_unique<StencilTable>(skin_, grid);
  version_.lattice = build_topology(grid, material_surface(*arrangement_), front_levels);
  version_.model = hold_outside(assemble_fem(*stencils_, *version_.lattice), *body_, spec_.region_mm);
  make_surface(version_, draw_surface());
  initial_volume_mm3_ = volume_mm3_ = arrangement_->volume_mm3();
  if (!spec_.can_cut) arrangement_.reset();
  if (arrangement_) arrangement_->store().points.fault = spec_.fault;
  solver_ = spec_.region_mm > 0 ? make_region_solver(workers) : make_solver(workers);
  solver_->set_model(version_.model, {});
}

OperatingTable::~OperatingTable() = default;

Outcome OperatingTable::apply(const Command& command) {
  const int32_t operations = arrangement_ ? arrangement_->operations() : 0;
  const auto lattice = version_.lattice;
  followed_.reset();
  Outcome outcome;
  try {
    outcome = std::visit([this](const auto& c) { return act(c); }, command);
  } catch (const std::exception& e) {
    // Memory at its end, or a check that has found a contradiction, in the middle of a cut: the arrangement goes back
    // to where it was, and nothing else has changed yet.
    if (!arrangement_ || arrangement_->operations() < operations || version_.lattice != lattice) throw;
    while (arrangement_->operations() > operations) arrangement_->undo();
    if (stroke_) stop_stroke(stroke_->id, "a piece of it failed");
    outcome = {false, std::string("the cut failed inside (") + e.what() + "); nothing has changed"};
  }
  if (!outcome.done) ++refused_;
  return outcome;
}

Outcome OperatingTable::act(const Stage&) { return ++stage_, Outcome{true, {}}; }
Outcome OperatingTable::act(const Wait&) { return {true, {}}; }
Outcome OperatingTable::act(const HeadCommand&) {
  return {false, "there is no bone here; expected a scene with a [head]"};
}

void OperatingTable::hold_at(const std::function<Vec3(const Vec3&)>& where) {
  const FemModel& m = *version_.model;
  const std::span<const Vec3f> was = solver_->displacement_mm();
  std::vector<Vec3f> u(was.begin(), was.end());
  bool other = false;
  for (size_t i = 0; i < u.size(); ++i) {
    if (!m.fixed[i]) continue;
    const Vec3f to = (where(m.X_mm[i]) - m.X_mm[i]).cast<float>();
    other |= to != u[i];
    u[i] = to;
  }
  if (other) solver_->set_displacement_mm(u);
}

StepReport OperatingTable::step(const StepSettings& settings) {
  draw_tight();
  const StepReport report = solve(settings);
  ++steps_;
  residual_ = float(report.residual);
  distance_mm_ = float(report.distance_mm);
  note_forces(report);
  return report;
}

// Where something may press, a step's iterations are taken some at a time, and after each contacts follow. At rest is
// only what is at rest with the contacts of its own place. A dynamic step cannot be parted; its length bounds how far
// things go.
StepReport OperatingTable::solve(const StepSettings& settings) {
  follow_contacts();
  if (!contacts_ || settings.dt_s > 0) {
    const StepReport report = solver_->step(settings);
    if (contacts_) contact_counts_.iterations += uint64_t(report.iterations);
    return report;
  }
  StepSettings part = settings;
  StepReport report;
  int done = 0;
  for (bool more = true; more;) {
    const bool near = contacts_->any_near();
    part.max_iterations =
        near ? std::min(settings.max_iterations - done, kIterationsOfContacts) : settings.max_iterations - done;
    part.most_move_mm = near ? kMoveOfContacts_mm : 0;
    report = solver_->step(part);
    done += report.iterations;
    const bool moved = report.iterations > 0, stopped = settings.should_stop && settings.should_stop();
    const bool others = moved && contacts_->any_near() && follow_contacts();
    if (done >= settings.max_iterations || stopped || !moved)
      more = false;
    else
      more = others || !report.converged;
    if (!more && others && report.converged) {  // is it at rest with these, too?
      part.max_iterations = 0;
      report = solver_->step(part);
    }
  }
  contact_counts_.iterations += uint64_t(done);
  report.iterations = done;
  return report;
}

bool OperatingTable::follow_contacts() {
  if (spec_.contact == ContactChoice::off) return false;
  bool fresh = false;
  if (contacts_version_ != version_.surface->version) {
    contacts_version_ = version_.surface->version;
    contact_counts_ = contact_counts();
    const auto surface = contact_surface({version_.surface, &version_.surface->view}, version_.surface->embedding,
                                         version_.lattice, *version_.model);
    contacts_ = surface ? std::make_unique<ContactFinder>(surface, *version_.model) : nullptr;
    if (contacts_) ++contact_counts_.surfaces;
    contacts_lattice_ = version_.lattice;
    fresh = true;
  }
  if (contacts_to_resume_) {
    if (contacts_) contacts_->resume(*contacts_to_resume_);
    contacts_to_resume_.reset();
    fresh = true;
  }
  if (!contacts_) return false;
  const bool changed = contacts_->follow(solver_->displacement_mm(), workers_);
  if (fresh || changed) solver_->set_contacts(contacts_->contacts());
  return fresh || changed;
}

PressAnswer OperatingTable::press(const PressQuestion& question, int iterations) {
  if (!press_) press_ = std::make_unique<PressProbe>(workers_);
  const std::vector<Spring> held = springs();
  const bool touching = contacts_ && contacts_version_ == version_.surface->version;
  return press_->ask({*version_.surface, version_.model, *solver_, held,
                      touching ? contacts_->contacts() : std::span<const Contact>{}, *body_},
                     question, iterations);
}

ContactCounts OperatingTable::contact_counts() const {
  ContactCounts n = contact_counts_;
  n.places = n.triangles = n.pairs = n.tired = 0;
  if (!contacts_) return n;
  const ContactCounts& now = contacts_->counts();
  n.checks += now.checks, n.searches += now.searches, n.looks += now.looks, n.turned += now.turned;
  n.places = now.places, n.triangles = now.triangles, n.pairs = now.pairs, n.tired = now.tired;
  return n;
}

bool OperatingTable::settled() const {
  return std::all_of(stitches_.begin(), stitches_.end(), [](const Stitch& s) { return s.drawn(); }) &&
         std::all_of(threads_.begin(), threads_.end(), [](const Thread& t) { return !t.closing; });
}

void OperatingTable::fill(Snapshot& snapshot, bool with_field) const {
  const SurfaceTopology& surface = *version_.surface;
  snapshot.step = steps_;
  snapshot.topology_version = surface.version;
  if (snapshot.topology != version_.surface) snapshot.topology = version_.surface;
  const std::span<const Vec3f> u = solver_->displacement_mm();
  const size_t n = surface.view.X_mm.size();
  snapshot.x_mm.resize(n);
  for (size_t v = 0; v < n; ++v) {
    const EmbeddedPoint& e = surface.embedding[v];
    Vec3f d = Vec3f::Zero();
    for (size_t i = 0; i < 8; ++i) d += e.w[i] * u[size_t(e.node[i])];
    snapshot.x_mm[v] = surface.view.X_mm[v].cast<float>() + d;
  }
  snapshot.hooks.clear();
  for (const Hook& h : hooks_) {
    const Vec3 at = position_mm(h.anchor.embedded);
    snapshot.hooks.push_back(
        {h.id, at.cast<float>(), h.handle_mm.cast<float>(), (solver_->spring_force_mN(h.spring) * 1e-3).cast<float>()});
  }
  snapshot.sutures.clear();
  for (const Stitch& s : stitches_) {
    if (!s.across()) continue;
    const Vec3 a = position_mm(s.a.embedded), b = position_mm(s.b.embedded);
    snapshot.sutures.push_back(
        {s.id, a.cast<float>(), b.cast<float>(), float(solver_->spring_force_mN(s.spring).norm() * 1e-3),
         float((held_mm(s.a) - held_mm(s.b)).norm()), s.thread, float(s.tied_N), float(s.peak_N)});
  }
  snapshot.residual = residual_;
  snapshot.distance_mm = distance_mm_;
  snapshot.stage = stage_;
  if (!with_field) {
    snapshot.field.clear();
    return;
  }
  if (!tension_ || tension_version_ != surface.version) {
    tension_ = std::make_unique<TensionField>(surface, skin_);
    tension_version_ = surface.version;
  }
  tension_->compute(surface, *solver_, snapshot.field);
}

uint64_t OperatingTable::state_hash() const {
  Hash64 h;
  h.add(topology_hash());
  const std::span<const Vec3f> u = solver_->displacement_mm();
  h.bytes(u.data(), u.size() * sizeof(Vec3f));
  for (const Hook& k : hooks_) {
    h.add(k.id);
    h.bytes(k.anchor.X_mm.data(), 3 * sizeof(double));
    h.bytes(k.handle_mm.data(), 3 * sizeof(double));
  }
  for (const Stitch& s : stitches_) {
    h.add(s.id);
    h.bytes(s.a.X_mm.data(), 3 * sizeof(double));
    h.bytes(s.b.X_mm.data(), 3 * sizeof(double));
    h.bytes(s.slack_mm.data(), 3 * sizeof(double));
  }
  for (const Thread& t : threads_) h.add(t.id), h.add(t.length_mm);
  if (const auto m = solver_->memory(); !m.empty()) h.bytes(m.data(), m.size() * sizeof(float));
  return h.value();
}

}  // namespace limberg
