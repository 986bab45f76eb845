#pragma once
// Which places of the surface press on what does not move (body/collider.h).
//
//   cut  -> ColliderContacts(...)    places: vertices of the free surface that lie near a collider
//   step -> follow(u)                pairs: where such a place is within reach, the plane at its foot
//        -> solver.set_contacts()    with those of wounds (patient/contact_driver.h)
//
// A pair is a place and a plane of the collider: the law and the stiffness are those of wounds (contact_finder.h), the
// other side is fixed. What overlaps at rest, since both shapes are only as true as their meshes, does not push: a
// place may lie as deep as it does at rest.
//
// A place that was so far away when it was asked for last is not asked for before it has come that far, and the search
// goes no farther than to the foot it had then.
//
// Persistence. A pair stays until its place has slid by slide_mm along its plane. Where a foot jumps, at a ridge, a
// pair could be projected for ever: from the third projection within neighbourhood_mm on it goes a part of the way only
// (1/2, 1/3, ...), and after the eighth it stands still.
#include <memory>
#include <span>
#include <vector>

#include "sim/base/workers.h"
#include "sim/body/body.h"
#include "sim/contact/contact_friction.h"
#include "sim/contact/contact_memory.h"
#include "sim/cutting/arrangement/surface_view.h"
#include "sim/fem/model/fem_model.h"
#include "sim/geometry/sided_patch.h"

namespace limberg {

class ColliderContacts {
 public:
  /// `embedding`: per vertex of the view. Without a collider near the surface there are no places.
  /// `friction`: its coefficient.
  ColliderContacts(std::shared_ptr<const Body> body, const SurfaceView& view, std::span<const EmbeddedPoint> embedding,
                   const FemModel& model, double friction = 0);

  /// Lets the pairs follow to displacement u (per node of the model). True when they are not what they were.
  /// `step_begins`: a step of the solver does (contact_friction.h).
  bool follow(std::span<const Vec3f> u, Workers& workers, bool step_begins = false);
  /// Valid until the next follow().
  std::span<const Contact> contacts() const { return contacts_; }
  bool any_near() const { return !contacts_.empty(); }
  size_t places() const { return place_.size(); }

  /// resume() takes back what one of the same surface held, at the same positions.
  std::vector<HeldByCollider> memory() const;
  void resume(std::span<const HeldByCollider> memory);

 private:
  struct Place {
    int32_t vertex = 0;
    EmbeddedPoint embedded;
    Vec3 X_mm = Vec3::Zero();
    double k_N_per_mm = 0;
    double deep_mm = 0;  // how deep it lies in the collider at rest
  };
  struct State {
    Vec3 asked_mm = Vec3::Zero();  // where it was when it was asked for last,
    double clear_mm = -1;          // and how far it may go from there without coming within reach; below 0: not asked
    HeldByCollider held;
    bool holds = false;
  };
  bool follow_place(size_t i, std::span<const Vec3f> u);  // true: its pair is not what it was
  void project(size_t i, const Vec3& x);
  Contact contact(size_t i) const;  // of a place that is held

  std::shared_ptr<const Body> body_;
  std::vector<SidedPatch> patch_;  // per collider
  std::vector<Place> place_;
  std::vector<State> state_;
  std::vector<Vec3> foot_mm_;  // per place and collider: the nearest point of that when it was asked for last; or NaN
  std::vector<Contact> contacts_;
  Friction friction_;
  bool resumed_ = false;
};

}  // namespace limberg
