#pragma once
// Which wound surfaces press on each other now. The story of this folder:
//
//   cut  -> contact_surface()            what may touch what: walls and the skin beside them, sheet by sheet
//                                        (contact_surface.h, sheets.h)
//   step -> finder.find(u)               for every place on a wall the nearest points of other sheets that face it
//                                        (facing_tree.h), and a one-sided spring to each that is near or inside
//        -> solver.set_contacts(...)     fem/contact_forces.h
//
// The minimiser needs one energy, so pairs and normals stand still for some iterations; then they are found again, until what
// is found presses as what was used. That comes to rest only when the force is a continuous function of the positions. What
// makes it so:
//
//   law       force and slope begin at zero (fem/contact_law.h)
//   normal    that of the sheet at the foot, interpolated between its corners: it turns smoothly as the foot slides
//   foot      carried by the cell that holds it, so that its share of each node changes smoothly too
//   sheets    each presses on its own: a place in a corner is held by two, and does not swing between them
//   fading    a pair's stiffness is multiplied by numbers that go from 1 to 0 with a level end (smooth_step) where it must
//             end: as the surfaces turn away from facing each other, as the place gets too deep to be believed, and near the
//             border of the sheet, where the way out through the sheet beside it becomes the shorter one
//
// A pair is a place and a sheet. From one search to the next it goes towards what is found, weight and normal alike, at its own
// rate: faster as long as it goes one way, slower when it turns back; a pair that is no longer found goes towards nothing. So
// where the force still jumps (a foot from one part of a sheet to another), the pair settles between the two, which is what
// an equilibrium at a jump is (the solution in the sense of Filippov). Pairs are part of what undo brings back: held().
//
// Stiffness. A place that stands for area A has k = c E A / h: c times that of a column of tissue of one cell's height h. It
// is in scale with the solver's metric, which knows nothing of contacts. Under a pressure p both banks' places together
// yield by p h / (2 c E): 0.03 mm for 5 kPa, 3.5 mm and 30 kPa.
// A place begins to press slack_mm inside other tissue: cuts that just coincide, at rest or after rounding, never push.
// There is no friction.
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
  double slack_mm = 0.01;     // overlap that does not push
  double soft_mm = 0.04;      // overlap beyond it over which the stiffness sets in
  // Places nearer than this get a spring, in case the iterations bring them together: twice the largest move since the
  // contacts were found before, within these limits.
  double ahead_least_mm = 0.1, ahead_mm = 0.75;
  double most_mm = 0.4;      // deeper overlaps push no harder than this one
  // Where pairs fade, from 1 to 0. Thinner flaps than deep are none.
  double facing_full = 0.5, facing_none = 0.2;    // minus the cosine between the two normals
  double deep_full_mm = 0.6, deep_none_mm = 2;   // how far inside
  double border_mm = 0.25;                         // near the border of the sheet, at least; or 1.5 overlaps, where that is more
};

/// A pair of a place and a sheet as it is now.
struct HeldContact {
  int32_t place = 0, sheet = -1, triangle = -1;
  std::array<double, 3> bary{};
  Vec3 normal = Vec3::UnitZ();
  double s_mm = 0;    // clearance of the surfaces as they are shown; negative inside
  double weight = 0;  // 0 to 1
  double rate = 1;    // part of the way to what is found that it goes
  double change = 0;  // of the weight and of the normal, the last time, had it gone all the way
  Vec3 turn = Vec3::Zero();
};

class ContactFinder {
 public:
  explicit ContactFinder(std::shared_ptr<const ContactSurface> surface, const Vec3& cell_mm, const ContactSettings& settings = {});

  /// Contacts at displacement u (per node of the model). Valid until the next call.
  std::span<const Contact> find(std::span<const Vec3f> u, Workers& workers);
  /// All pairs, by place. resume() takes them back for a finder of the same surface, at the same positions; an empty list
  /// makes it begin anew. Throws InputError for pairs of another surface.
  std::vector<HeldContact> held() const;
  void resume(std::span<const HeldContact> held);
  bool presses() const;  // does any pair press where the places were when they were found?
  size_t places() const { return surface_->place.size(); }
  size_t triangles() const { return surface_->tri.size(); }

 private:
  using Guess = std::array<int32_t, FacingTree::kFeet>;
  Vec3 smooth_normal(int32_t triangle, const std::array<double, 3>& bary) const;
  void look(size_t place, std::vector<HeldContact>& out);
  double inside(const Neighbours::Place& self, const Vec3& p_mm, const FacingTree::Foot& foot);
  void follow(const std::vector<HeldContact>& before, std::vector<HeldContact>& found) const;
  Contact contact(const HeldContact& f, std::span<const Vec3f> u) const;
  std::shared_ptr<const ContactSurface> surface_;
  ContactSettings settings_;
  double cell_mm_ = 1;
  double ahead_mm_ = 0;  // of this step
  bool first_ = true;
  FacingTree tree_;
  Neighbours neighbours_;
  std::vector<Vec3> x_;
  std::vector<double> move2_;              // per chunk of x_: largest move since the last call, squared
  std::vector<std::vector<HeldContact>> found_, before_;  // per chunk of places
  std::vector<Guess> guess_;               // per place: where the search begins; no answer depends on it
  std::vector<Contact> contacts_;
};

}  // namespace limberg
