#pragma once
// Which wound surfaces press on each other now. The story of this folder:
//
//   cut  -> contact_surface()            what may touch what: walls and the skin beside them      (contact_surface.h)
//   step -> finder.find(u)               for every place on a wall the nearest other sheet that faces it (facing_tree.h),
//                                        and a one-sided spring to it where it is near or inside
//        -> solver.set_contacts(...)     fem/contact_forces.h
//
// What is remembered from step to step: with which triangle a place that lies inside other tissue is paired, and along which
// normal it is pushed. As long as it lies inside, its foot only slides on along that sheet, and the normal follows the sheet
// with some delay: otherwise a place between two sheets, or a tip that slides on a tilted one, would swing to and fro from
// step to step. A place that has come out is free again. Answers never depend on the number of workers.
//
// Stiffness. A place that stands for area A has k = c E A / h: c times that of a column of tissue of one cell's height h. It
// is in scale with the solver's metric, which knows nothing of contacts. Under a pressure p both banks' places together
// yield by p h / (2 c E): 0.03 mm for 5 kPa, 3.5 mm and 30 kPa.
// A place begins to press 0.02 mm inside other tissue: cuts that just coincide, at rest or after rounding, never push.
// There is no friction.
#include <algorithm>
#include <memory>
#include <span>
#include <vector>

#include "sim/contact/contact_surface.h"
#include "sim/contact/facing_tree.h"
#include "sim/contact/neighbours.h"
#include "sim/workers.h"

namespace limberg {

struct ContactSettings {
  double stiffness = 8;       // c above
  double slack_mm = 0.02;     // overlap that does not push
  // Places nearer than this get a spring, in case the step brings them together: twice the largest move of the step before,
  // within these limits.
  double ahead_least_mm = 0.1, ahead_mm = 0.75;
  // Deeper than this no new pair is recognised: it is rather a mistake. Twice the largest move, within these limits.
  double new_mm = 0.5, new_most_mm = 1.5;
  double within_mm = 2;       // a pair that has come to be deeper than this is given up; thinner flaps than this are none
  double hold_mm = 3;         // a pair's foot moves by less than this, at rest, in a step
  double release_mm = 0.05;   // a pair ends when the place has come out by so much
  double turn = 0.2;          // of the way to its new direction that a pair's normal goes in a step
};

class ContactFinder {
 public:
  explicit ContactFinder(std::shared_ptr<const ContactSurface> surface, const Vec3& cell_mm, const ContactSettings& settings = {});

  /// Contacts at displacement u (per node of the model). Valid until the next call.
  std::span<const Contact> find(std::span<const Vec3f> u, Workers& workers);
  /// Forgets all pairs: after a jump of the positions.
  void forget() { std::fill(pair_.begin(), pair_.end(), -1), first_ = true; }
  size_t places() const { return surface_->place.size(); }
  size_t triangles() const { return surface_->tri.size(); }

 private:
  struct Found {
    int32_t triangle = -1;
    std::array<double, 3> bary{};
    Vec3 normal = Vec3::UnitZ();
    double s_mm = 0;  // clearance of the surfaces as they are shown; negative inside
  };
  Found look(size_t place);   // its pair, or what is new
  Found foot(size_t place, double within_mm, const Vec3* near_X_mm);
  std::shared_ptr<const ContactSurface> surface_;
  ContactSettings settings_;
  double cell_mm_ = 1;
  double ahead_mm_ = 0, new_mm_ = 0;  // of this step
  bool first_ = true;
  FacingTree tree_;
  Neighbours neighbours_;
  std::vector<Vec3> x_;
  std::vector<double> move2_;    // per chunk of x_: largest move since the last call, squared
  std::vector<Found> found_;     // per place
  std::vector<int32_t> guess_;   // per place: where the search begins; no answer depends on it
  std::vector<int32_t> pair_;    // per place: the triangle that it presses on; -1: free
  std::vector<Vec3> pair_X_mm_;  // and the point of it, at rest
  std::vector<Vec3> pair_normal_;
  std::vector<Contact> contacts_;
};

}  // namespace limberg
