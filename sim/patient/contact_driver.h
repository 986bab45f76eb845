#pragma once
// Contact during solver steps, of wound surfaces and with colliders: the finders of the present surface, and the
// iterations between which contacts follow the tissue.
//
// Where something may press, a step's iterations are taken some at a time, and after each contacts follow. At rest is
// only what is at rest with the contacts of its own place. A dynamic step cannot be parted; its length bounds how far
// things go.
#include <memory>
#include <optional>
#include <span>

#include "sim/contact/collider_contacts.h"
#include "sim/contact/contact_counts.h"
#include "sim/contact/contact_finder.h"
#include "sim/patient/tissue.h"

namespace limberg {

class ContactDriver {
 public:
  explicit ContactDriver(Tissue& tissue) : tissue_(tissue) {}

  /// Begins to look, beside whatever else is done, at what can touch in a version that the tissue is about to take: the
  /// first step with it finds that made.
  void prepare(const TissueVersion& next);
  StepReport step(const StepSettings& settings);
  ContactCounts counts() const;
  /// What undo and redo bring back. Brought back, it is taken up by the next step.
  ContactMemory memory() const;
  void resume(const ContactMemory& memory) { to_resume_ = memory; }
  /// Of the present surface; empty before its first step.
  std::span<const Contact> contacts() const;
  /// Sum of the forces of colliders on the tissue, mN.
  Vec3 collider_force_mN() const;

 private:
  struct Finders;  // of one version of the surface
  Finders take_finders(const StepSettings& settings);
  /// True when the solver has others now. Nothing is done where nothing can touch.
  bool follow(bool step_begins, const StepSettings& settings);
  std::span<const Contact> held_apart() const;  // what the solver has
  bool any() const { return finder_ || colliders_; }
  bool any_near() const { return (finder_ && finder_->any_near()) || (colliders_ && colliders_->any_near()); }

  Tissue& tissue_;
  std::unique_ptr<ContactFinder> finder_;           // absent as long as there is no wall
  std::unique_ptr<ColliderContacts> colliders_;     // absent where none is near
  std::vector<Contact> both_;                       // of both, where there are both
  uint64_t version_ = 0;                            // of the surface that it was made for
  std::shared_ptr<const LatticeTopology> lattice_;  // that it is for
  std::optional<ContactMemory> to_resume_;
  ContactCounts gone_;  // of finders that are gone
  std::shared_ptr<Finders> prepared_;
  std::shared_ptr<Workers::Job> preparing_;
};

}  // namespace limberg
