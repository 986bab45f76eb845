#include "sim/patient/contact_driver.h"

#include <algorithm>
#include <utility>

namespace limberg {
namespace {

// Until contacts follow: iterations of the minimiser, and how far it may go. (10 instead of 20: as much overlap in both
// shipped operations, and 69 and 44 % more searches, 2026-11-22.)
constexpr int kIterationsOfContacts = 20;
constexpr double kMoveOfContacts_mm = 1.5;

}  // namespace

struct ContactDriver::Finders {
  uint64_t version = 0;                         // of the surface
  std::unique_ptr<ContactFinder> walls;         // absent: there is no wall
  std::unique_ptr<ColliderContacts> colliders;  // absent: none is near

  void make(const TissueVersion& of, double friction) {
    const SurfaceTopology& surface = *of.surface;
    if (auto found = contact_surface({of.surface, &surface.view}, surface.embedding, of.lattice, *of.model))
      walls = std::make_unique<ContactFinder>(std::move(found), *of.model, friction);
    if (surface.body->colliders.empty()) return;
    colliders =
        std::make_unique<ColliderContacts>(surface.body, surface.view, surface.embedding.flat(), *of.model, friction);
    if (colliders->places() == 0) colliders.reset();
  }
};

void ContactDriver::prepare(const TissueVersion& next) {
  if (tissue_.spec().contact == ContactChoice::off) return;
  prepared_ = std::make_shared<Finders>();
  prepared_->version = next.surface->version;
  preparing_ = tissue_.workers().submit(
      [next, made = prepared_, friction = tissue_.spec().contact_friction] { made->make(next, friction); });
}

// What was prepared is taken if it is of this surface: while that is on its way the solver makes its metric.
ContactDriver::Finders ContactDriver::take_finders(const StepSettings& settings) {
  const TissueVersion& now = tissue_.version();
  const auto job = std::exchange(preparing_, nullptr);
  const auto made = std::exchange(prepared_, nullptr);
  if (made && made->version == now.surface->version) {
    if (!job->done()) tissue_.solver().make_ready(settings);
    job->wait();
    return std::move(*made);
  }
  Finders out;
  out.make(now, tissue_.spec().contact_friction);
  return out;
}

StepReport ContactDriver::step(const StepSettings& settings) {
  ElasticSolver& solver = tissue_.solver();
  if (settings.afresh && !to_resume_) to_resume_ = memory();
  follow(true, settings);
  if (!any() || settings.dt_s > 0) {
    const StepReport report = solver.step(settings);
    if (any()) gone_.iterations += uint64_t(report.iterations);
    return report;
  }
  StepSettings part = settings;
  StepReport report;
  int done = 0;
  for (bool more = true; more;) {
    const bool near = any_near();
    part.max_iterations =
        near ? std::min(settings.max_iterations - done, kIterationsOfContacts) : settings.max_iterations - done;
    part.most_move_mm = near ? kMoveOfContacts_mm : 0;
    report = solver.step(part);
    part.afresh = false;
    done += report.iterations;
    const bool moved = report.iterations > 0, stopped = settings.should_stop && settings.should_stop();
    const bool others = moved && any_near() && follow(false, settings);
    if (done >= settings.max_iterations || stopped || !moved)
      more = false;
    else
      more = others || !(report.converged || report.at_floor);
    if (others) report.stalled = report.at_floor = false;  // said with the contacts before
    if (!more && others && report.converged) {             // is it at rest with these, too?
      part.max_iterations = 0;
      report = solver.step(part);
    }
  }
  gone_.iterations += uint64_t(done);
  report.iterations = done;
  return report;
}

bool ContactDriver::follow(bool step_begins, const StepSettings& settings) {
  if (tissue_.spec().contact == ContactChoice::off) return false;
  const TissueVersion& now = tissue_.version();
  bool fresh = false;
  if (version_ != now.surface->version) {
    version_ = now.surface->version;
    gone_ = counts();
    Finders found = take_finders(settings);
    finder_ = std::move(found.walls), colliders_ = std::move(found.colliders);
    if (finder_) ++gone_.surfaces;
    lattice_ = now.lattice;
    fresh = true;
  }
  if (to_resume_) {
    if (finder_) finder_->resume(*to_resume_);
    if (colliders_) colliders_->resume(to_resume_->colliders);
    to_resume_.reset();
    fresh = true;
  }
  if (!any()) return false;
  const std::span<const Vec3f> u = tissue_.solver().displacement_mm();
  bool changed = fresh;
  if (finder_) changed |= finder_->follow(u, tissue_.workers(), step_begins);
  if (colliders_) changed |= colliders_->follow(u, tissue_.workers(), step_begins);
  if (!changed) return false;
  if (finder_ && colliders_) {
    both_.assign(finder_->contacts().begin(), finder_->contacts().end());
    both_.insert(both_.end(), colliders_->contacts().begin(), colliders_->contacts().end());
  }
  tissue_.solver().set_contacts(held_apart());
  return true;
}

ContactCounts ContactDriver::counts() const {
  ContactCounts n = gone_;
  n.places = n.triangles = n.pairs = n.damped = 0;
  if (!finder_) return n;
  const ContactCounts& now = finder_->counts();
  n.checks += now.checks, n.searches += now.searches, n.queries += now.queries, n.reprojected += now.reprojected;
  n.places = now.places, n.triangles = now.triangles, n.pairs = now.pairs, n.damped = now.damped;
  return n;
}

ContactMemory ContactDriver::memory() const {
  if (to_resume_) return *to_resume_;  // not taken up yet
  if (!any() || lattice_ != tissue_.version().lattice) return {};
  ContactMemory m;
  if (finder_) m = finder_->memory();
  if (colliders_) m.colliders = colliders_->memory();
  return m;
}

std::span<const Contact> ContactDriver::held_apart() const {
  if (finder_ && colliders_) return both_;
  if (colliders_) return colliders_->contacts();
  return finder_ ? finder_->contacts() : std::span<const Contact>{};
}

Vec3 ContactDriver::collider_force_mN() const {
  Vec3 sum = Vec3::Zero();
  const std::span<const Contact> all = contacts();
  if (!colliders_ || all.size() != tissue_.solver().contacts()) return sum;
  for (size_t i = all.size() - colliders_->contacts().size(); i < all.size(); ++i)  // the last of the list
    sum +=
        tissue_.solver().contact_force_mN(i) * all[i].normal.cast<double>() + tissue_.solver().contact_friction_mN(i);
  return sum;
}

std::span<const Contact> ContactDriver::contacts() const {
  return version_ == tissue_.surface().version ? held_apart() : std::span<const Contact>{};
}

}  // namespace limberg
