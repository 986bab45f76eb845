#pragma once
// Which wound surfaces press on each other now. The story of this folder:
//
//   cut  -> contact_surface()            what may touch what: walls and the skin beside them, sheet by sheet
//                                        (contact_surface.h, sheets.h)
//   step -> finder.follow(u)             does what was found still hold (surface_motion.h)? where not: for every place on a
//                                        wall the nearest points of other sheets that face it (facing_tree.h), and a
//                                        one-sided spring to each that is near or inside
//        -> solver.set_contacts(...)     fem/contact_forces.h, when anything is new
//
// A pair is a place and a plane: that of a sheet at the foot of the place. The plane is carried by the tissue at the foot; it
// does not turn, and nothing acts along it. For given pairs the energy is one function of the positions with a continuous
// gradient, and the minimiser comes to rest on it as it does without contacts. What can keep a body from rest is that pairs
// change as it moves. So they have hysteresis: a pair stands as it was found until
//
//   slide     its place has gone slide_mm along the plane from the foot,
//   turn      the sheet at the foot has turned by turn_deg,
//   first     or it begins to press and nobody has judged yet whether the place is inside at all.
//
// The plane is then wrong by turn_deg and by the sagitta of slide_mm on the sheet's curvature, 0.002 mm for a radius of 5 mm.
// Where the answer itself jumps (a foot from one part of a sheet to another, or to another sheet), a pair might turn for
// ever, as the body moves by more than slide_mm with it each time. So places tire: from the fifth time that its pairs turn
// in one spot, each goes only a part of the way to what is found (a half, a third, ...), and after the last they stand
// still: between the two answers, which is what an equilibrium at a jump is (the solution in the sense of Filippov). A place
// that has slid on by spot_mm is fresh again. So without motion from outside only finitely many pairs turn, and when none
// turns any more, the body comes to rest.
//
// What makes jumps rare: the normal is that of the sheet at the foot, interpolated between its corners; each sheet presses on
// its own, so that a place in a corner is held by two; and a pair's stiffness is multiplied by numbers that go from 1 to 0
// with a level end (smooth_step) where it must end: as the surfaces turn away from facing each other, as the place gets too
// deep to be believed, and near the border of the sheet, where the way out through the sheet beside it becomes shorter.
//
// New pairs. Every sheet within guard_mm of a place gets its pair. When a place looks around, it looks farther, and notes how
// far it is to the nearest sheet that is no pair yet. Until the place and what is near it together have moved so far, nothing
// can touch it that was not seen, and it does not look again; so what has nothing moving near it never does. What slides is
// looked for on its own sheet, near its last foot.
//
// Stiffness. A place that stands for area A has k = c E A / h: c times that of a column of tissue of one cell's height h. It
// is in scale with the solver's metric, which knows nothing of contacts. Under a pressure p both banks' places together
// yield by p h / (2 c E): 0.03 mm for 5 kPa, 3.5 mm and 30 kPa.
// A place begins to press slack_mm inside other tissue: cuts that just coincide, at rest or after rounding, never push.
// There is no friction.
#include <memory>
#include <span>
#include <vector>

#include "sim/contact/contact_counts.h"
#include "sim/contact/contact_surface.h"
#include "sim/contact/facing_tree.h"
#include "sim/contact/neighbours.h"
#include "sim/contact/surface_motion.h"
#include "sim/workers.h"

namespace limberg {

struct ContactSettings {
  double stiffness = 8;       // c above
  double slack_mm = 0.01;     // overlap that does not push
  double soft_mm = 0.04;      // overlap beyond it over which the stiffness sets in
  double guard_mm = 0.75;     // sheets so near to a place are its pairs
  double far_mm = 3;          // how far around it a place looks; less than a block's reach (surface_motion.h)
  double most_mm = 0.4;       // deeper overlaps push no harder than this one
  double slide_mm = 0.15, turn_deg = 5, spot_mm = 1;
  // Where pairs fade, from 1 to 0. Thinner flaps than deep are none.
  double facing_full = 0.5, facing_none = 0.2;    // minus the cosine between the two normals
  double deep_full_mm = 0.6, deep_none_mm = 2;    // how far inside
  double border_mm = 0.25;                        // near the border of the sheet, at least; or 1.5 overlaps, where that is more
};

/// A pair of a place and a sheet as it is now.
struct HeldContact {
  int32_t place = 0, sheet = -1, triangle = -1;
  std::array<double, 3> bary{};
  Vec3 normal = Vec3::UnitZ();    // of the plane
  Vec3 facet = Vec3::UnitZ();     // of the triangle when the pair was found
  Vec3 apart_mm = Vec3::Zero();   // of place and foot as the cells carry them, when it was found
  double gap_mm = 0;              // s = normal . apart - gap: clearance of the surfaces as they are shown; negative inside
  double weight = 0;              // 0 to 1
  bool judged = false;            // is the weight that of a place that presses?
};

/// What a finder must get back to go on as it would have. A place that is not named is fresh.
struct ContactMemory {
  struct Spot {
    int32_t place = 0, turns = 0;
    Vec3 slid_mm = Vec3::Zero();
  };
  std::vector<HeldContact> pairs;  // by place, then sheet
  std::vector<Spot> spots;         // by place
};

class ContactFinder {
 public:
  ContactFinder(std::shared_ptr<const ContactSurface> surface, const FemModel& model, const ContactSettings& settings = {});

  /// Lets the pairs follow to displacement u (per node of the model). True when they are not what they were.
  bool follow(std::span<const Vec3f> u, Workers& workers);
  /// Valid until the next follow().
  std::span<const Contact> contacts() const { return contacts_; }
  bool any_near() const { return near_; }  // did any pair press, or nearly, at the last follow()?

  /// resume() takes back what a finder of the same surface held, at the same positions. Throws InputError for pairs of
  /// another surface.
  ContactMemory memory() const;
  void resume(const ContactMemory& memory);

  const ContactCounts& counts() const { return counts_; }
  const ContactSurface& surface() const { return *surface_; }

 private:
  using Guess = std::array<int32_t, FacingTree::kFeet>;
  struct Pair {
    HeldContact held;
    Contact contact;
    Vec3 rest_apart_mm = Vec3::Zero();
    bool stale = false;
    double s_mm = 0;  // at the last check
  };
  struct Looked {             // of a place
    Vec3f at_mm = Vec3f::Zero();  // its displacement at the last check
    double travelled_mm = 1e30;  // it and what is near it against each other, since it last looked
    double free_mm = 0;          // so far there was nothing but its pairs
    Vec3 slid_mm = Vec3::Zero();
    int32_t turns = 0;
    bool due = false;    // it looks around
    bool stale = false;  // some of its pairs are
  };
  struct Chunk {
    std::vector<Pair> pair;
    bool changed = false, due = false;
    double left_mm = 0;      // until any of its pairs can turn
    double nearest_mm = 0;   // clearance of its nearest pair, at least
    uint64_t looks = 0, turned = 0;
  };
  Vec3 smooth_normal(int32_t triangle, const std::array<double, 3>& bary) const;
  Vec3 facet(int32_t triangle, std::span<const Vec3f> u) const;
  void check(size_t chunk, std::span<const Vec3f> u);
  void look(size_t place, int32_t sheet, std::vector<HeldContact>& found);
  double inside(const Neighbours::Place& self, const Vec3& p_mm, const FacingTree::Foot& foot);
  void search(size_t chunk, std::span<const Vec3f> u);
  void merge(size_t place, std::span<Pair> before, std::vector<HeldContact>& found, std::span<const Vec3f> u, Chunk& chunk, std::vector<Pair>& out);
  void make_contact(Pair& p) const;

  std::shared_ptr<const ContactSurface> surface_;
  ContactSettings settings_;
  double cell_mm_ = 1, turn_cos_ = 1;
  FacingTree tree_;
  Neighbours neighbours_;
  SurfaceMotion motion_;
  std::vector<Vec3> x_;
  std::vector<Looked> looked_;  // per place
  std::vector<Guess> guess_;    // per place: where the search begins; no answer depends on it
  std::vector<Chunk> chunk_;    // of places
  std::vector<Contact> contacts_;
  bool near_ = false, resumed_ = false;
  ContactCounts counts_;
};

}  // namespace limberg
