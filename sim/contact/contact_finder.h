#pragma once
// Which wound surfaces press on each other now.
//
//   cut  -> contact_surface()        walls and the skin beside them, sheet by sheet (contact_surface.h, sheets.h)
//   step -> finder.follow(u)         persistence   which pairs still hold (surface_motion.h)
//                                    broad phase   which cell copies may hold a place (moving_cells.h)
//                                    narrow phase  where in them it lies at rest, and the way out (rest_tissue.h)
//        -> solver.set_contacts()    fem/forces/contact_forces.h, when a pair is new or gone
//
// A pair is a place of one surface and a plane: that of a sheet at the foot of the place. The tissue at the foot
// carries the plane; the plane does not turn, and nothing acts along it unless a scene asks for friction
// (contact_friction.h). For given pairs the energy is one function of the positions with a continuous gradient, so the
// minimiser comes to rest as it does without contacts.
//
// Stiffness. A place that stands for area A has k = c E A / h: c times that of a column of tissue of one cell's height
// h, in scale with the solver's metric, which knows nothing of contacts. Under a pressure p both banks' places together
// yield by p h / (2 c E): 0.03 mm for 5 kPa, 3.5 mm and 30 kPa.
//
// Persistence. A pair stays as it was found until its place has slid by slide_mm, until the sheet has turned by
// turn_deg, or until the narrow phase finds the place in other cells. Its plane is then wrong by turn_deg and by the
// sagitta of slide_mm: 0.002 mm on a radius of 5 mm. A pair found outside is tested for depth when it first presses.
//
// Weights. The stiffness is multiplied by weights that fall smoothly from 1 to 0 (contact_constants.h) as the way out
// through this sheet becomes longer than the shortest one, as the place gets too deep, and as the sheet turns away from
// the place. Every sheet presses by itself, so that a place in a corner is held by two.
//
// Damping. Where the foot jumps, a pair could be projected for ever, as the body moves with it each time. From the
// third projection in one neighbourhood on, a pair goes a part of the way only (1/2, 1/3, ...), and after the eighth it
// stands still between the two answers: the equilibrium at a jump in the sense of Filippov. So without motion from
// outside only finitely many pairs change, and then the body comes to rest.
//
// Limit. In the cell in which a cut ends both banks are one copy, unless it is divided (Fronts, lattice/topology.h):
// what a stitch draws in there has no way out and ends up to 1 mm deep.
#include <memory>
#include <span>
#include <vector>

#include "sim/base/workers.h"
#include "sim/contact/contact_counts.h"
#include "sim/contact/contact_friction.h"
#include "sim/contact/contact_memory.h"
#include "sim/contact/contact_surface.h"
#include "sim/contact/moving_cells.h"
#include "sim/contact/rest_tissue.h"
#include "sim/contact/surface_motion.h"

namespace limberg {

class ContactFinder {
 public:
  /// `friction`: its coefficient.
  ContactFinder(std::shared_ptr<const ContactSurface> surface, const FemModel& model, double friction = 0);

  /// Lets the pairs follow to displacement u (per node of the model). True when they are not what they were.
  /// `step_begins`: a step of the solver does (contact_friction.h).
  bool follow(std::span<const Vec3f> u, Workers& workers, bool step_begins = false);
  /// Valid until the next follow().
  std::span<const Contact> contacts() const { return contacts_; }
  bool any_near() const { return near_; }  // did any pair press, or nearly, at the last follow()?

  /// resume() takes back what a finder of the same surface held, at the same positions. Throws InputError for pairs of
  /// another surface.
  ContactMemory memory() const;
  void resume(const ContactMemory& memory);

  const ContactCounts& counts() const { return counts_; }

 private:
  static constexpr double kNothing = 1e-4;  // a pair of this weight is left out: its force is below single precision
  struct Pair {
    HeldContact held;
    Contact contact;
    Vec3 rest_apart_mm = Vec3::Zero();
    bool stale = false;
    double s_mm = 0;  // at the last check
  };
  struct Around {
    int32_t copy = 0;       // of tissue_
    bool adjacent = false;  // it hangs together with the group's own
    auto operator<=>(const Around&) const = default;
  };
  struct Group {  // the places that one cell copy carries
    size_t first = 0, last = 0;
    size_t own = 0;         // that copy, in tissue_
    int32_t sheet = -1;     // that all its places lie on, or -1
    double far_mm = 1e30;   // it and what is near it against each other, since its list was made
    double near_mm = 1e30;  // it and the list's copies against each other, since its places were last queried
    bool due = false, relist = false;  // its places are queried; its list is made anew
    bool listed = true;                // false: of its list only who carries what it has pairs with is there yet
    std::vector<int32_t> around;
  };
  struct PlaceState {  // of a place
    Vec3 slid_mm = Vec3::Zero();
    int32_t projections = 0;  // in this neighbourhood
    bool due = false;         // it is queried, since its group is or a pair of its own is stale
    bool stale = false;       // a pair of its own is
  };
  struct Located {  // a place that is in or near a copy
    int32_t place = 0, copy = 0;
    bool adjacent = false, in = false;  // in the cell itself, not beside it
    int32_t part = 0;
    Vec3 at = Vec3::Zero();
  };
  struct Chunk {
    size_t first = 0, last = 0;  // of groups
    std::vector<Pair> pair;
    std::vector<Located> located;  // by place; of this search
    std::vector<Located> before;   // by place; of the search from which its pairs come
    std::vector<int32_t> unknown;  // parts
    bool changed = false, due = false;
    double left_mm = 0;     // until any of its pairs can go stale
    double nearest_mm = 0;  // clearance of its nearest pair, at least
    uint64_t queries = 0, reprojected = 0;
  };
  Vec3 displacement(const EmbeddedPoint& e) const;
  Vec3 shown_mm(int32_t triangle, const std::array<double, 3>& bary) const;
  Vec3 carried_normal(int32_t triangle, const std::array<double, 3>& bary, const Vec3& N) const;
  void check(size_t chunk);
  void begin_list(Group& group, std::span<const Pair> pairs) const;
  void complete_list(Group& group, std::vector<uint8_t>& relation) const;
  void mark_adjacent(const Group& group, bool marked, std::vector<uint8_t>& relation) const;
  double moved_mm(const Group& group) const;
  struct Point {  // a place that is queried
    size_t place = 0;
    Vec3f p = Vec3f::Zero();
  };
  void broad_phase(const Group& group, std::span<const Point> points, std::vector<Around>& around,
                   std::vector<uint8_t>& relation) const;
  void locate(const Point& point, std::span<const Around> around, std::vector<Located>& located) const;
  bool unmoved(std::span<const Located> now, std::span<const Located> before) const;
  bool slide(PlaceState& state, const Vec3& slid_mm) const;
  void narrow_phase(size_t place, std::span<const Located> located, std::vector<HeldContact>& found) const;
  void find_cells(size_t chunk);
  void find_pairs(size_t chunk);
  void merge(size_t place, std::span<Pair> before, std::vector<HeldContact>& found, Chunk& chunk,
             std::vector<Pair>& out);
  void make_contact(Pair& p) const;
  Vec3 apart_mm(const Pair& p) const;
  void grip(size_t chunk);

  std::shared_ptr<const ContactSurface> surface_;
  double cell_mm_ = 1;
  RestTissue tissue_;
  MovingCells cells_;
  SurfaceMotion motion_;
  std::vector<int32_t> carrier_;   // per triangle: its copy in tissue_
  std::vector<Group> group_;       // by copy, and so by place
  std::vector<Vec3> normal_;       // per place, at rest
  std::vector<v4> u_;              // per node of the model
  std::vector<PlaceState> state_;  // per place
  std::vector<Chunk> chunk_;       // of groups
  std::vector<size_t> chunk_of_;   // per place
  std::vector<Contact> contacts_;
  Friction friction_;
  bool near_ = false, resumed_ = false;
  double since_sorted_mm_ = 1e30;  // cells_
  ContactCounts counts_;
};

}  // namespace limberg
