#pragma once
// Contact of wound surfaces during solver steps: the finder of the present surface, and the iterations between which
// contacts follow the tissue.
//
// Where something may press, a step's iterations are taken some at a time, and after each contacts follow. At rest is
// only what is at rest with the contacts of its own place. A dynamic step cannot be parted; its length bounds how far
// things go.
#include <memory>
#include <optional>
#include <span>

#include "sim/contact/contact_counts.h"
#include "sim/contact/contact_finder.h"
#include "sim/patient/tissue.h"

namespace limberg {

class ContactDriver {
 public:
  explicit ContactDriver(Tissue& tissue) : tissue_(tissue) {}

  StepReport step(const StepSettings& settings);
  ContactCounts counts() const;
  /// What undo and redo bring back. Brought back, it is taken up by the next step.
  ContactMemory memory() const;
  void resume(const ContactMemory& memory) { to_resume_ = memory; }
  /// Of the present surface; empty before its first step.
  std::span<const Contact> contacts() const;

 private:
  bool follow();  // true when the solver has others now; nothing is done where nothing has been cut

  Tissue& tissue_;
  std::unique_ptr<ContactFinder> finder_;           // absent as long as there is no wall
  uint64_t version_ = 0;                            // of the surface that it was made for
  std::shared_ptr<const LatticeTopology> lattice_;  // that it is for
  std::optional<ContactMemory> to_resume_;
  ContactCounts gone_;  // of finders that are gone
};

}  // namespace limberg
