#pragma once
// Which wound surfaces press on each other now. The story of this folder:
//
//   cut  -> contact_surface()            what may touch what: walls and the skin beside them, sheet by sheet
//                                        (contact_surface.h, sheets.h)
//   step -> finder.follow(u)             does what was found still hold (surface_motion.h)?
//                                        where not: which cells of other tissue hold the
//                                        place (moving_cells.h), where that is at rest and
//                                        which way leads out of it (rest_tissue.h), and a
//                                        one-sided spring to each sheet that is near
//        -> solver.set_contacts(...)     fem/contact_forces.h, when anything is new
//
// A pair is a place and a plane: that of a sheet at the foot of the place. The plane is carried by the tissue at the
// foot; it does not turn, and nothing acts along it. For given pairs the energy is one function of the positions
// with a continuous gradient, and the minimiser comes to rest on it as it does without contacts. What can keep a
// body from rest is that pairs change as it moves. So they have hysteresis: a pair stands as it was found until
//
//   slide     its place has gone slide_mm along the plane from the foot,
//   turn      the sheet at the foot has turned by turn_deg,
//   first     or it begins to press and nobody has judged
//             yet whether the place is inside at all (once:
//             it then stays, judged, or goes),
//   elsewhere or, as something near has moved, the place looks around
//             and lies in other cells than when it was last judged,
//             or farther than slide_mm from there in one of them.
//
// The plane is then wrong by turn_deg and by the sagitta of slide_mm on the sheet's curvature,
// 0.002 mm for a radius of 5 mm. Where the answer itself jumps (a foot from one part of a sheet to
// another, or to another sheet), a pair might turn for ever, as the body moves by more than
// slide_mm with it each time. So places tire: from the third time that its pairs turn in one spot,
// each goes only a part of the way to what is found (a half, a third, ...), and after the last they
// stand still: between the two answers, which is what an equilibrium at a jump is (the solution in
// the sense of Filippov). A place that has slid on by spot_mm is fresh again. So without motion
// from outside only finitely many pairs turn, and when none turns any more, the body comes to rest.
//
// What makes jumps rare: whether a place is inside, and the shortest way out, depend on where it is and on nothing
// that was before; the normal is that of the sheet at the foot, interpolated between its corners; each sheet presses
// on its own, so that a place in a corner is held by two; and a pair's stiffness is multiplied by numbers that go
// from 1 to 0 with a level end (smooth_step) where it must end: as the way out through this sheet becomes longer
// than the shortest one, and as the place gets too deep to be believed, and as the sheet turns away from the place.
// The way is taken along the place's own normal: edges that meet part sideways, they do not climb over each other.
//
// Who looks. Each cell copy that carries places has a list of the copies around it. While it and what
// is near have moved by less than margin_mm against each other, nothing else can hold its places.
// While it and the copies of the list have moved by less than look_mm, they do not look again either;
// so what has nothing moving near it never does. A place that looks asks the tree of all copies'
// boxes; so a list is made only when it is wanted, at the next check: not where all moves on fast.
//
// Stiffness. A place that stands for area A has k = c E A / h: c times that of a column of tissue of one
// cell's height h. It is in scale with the solver's metric, which knows nothing of contacts. Under a
// pressure p both banks' places together yield by p h / (2 c E): 0.03 mm for 5 kPa, 3.5 mm and 30 kPa.
// A place begins to press slack_mm inside other tissue: cuts that just coincide, at rest or after rounding, never push.
// There is no friction.
//
// What it cannot part. In the cell in which a cut ends both banks are
// one copy, unless it is divided (lattice/topology.h, Fronts): what a
// stitch draws in between there has no way out and ends up to 1 mm deep.
#include <memory>
#include <span>
#include <vector>

#include "sim/base/workers.h"
#include "sim/contact/contact_counts.h"
#include "sim/contact/contact_memory.h"
#include "sim/contact/contact_surface.h"
#include "sim/contact/moving_cells.h"
#include "sim/contact/rest_tissue.h"
#include "sim/contact/surface_motion.h"

namespace limberg {

struct ContactSettings {
  double stiffness = 8;    // c above
  double slack_mm = 0.01;  // overlap that does not push
  double soft_mm = 0.04;   // overlap beyond it over which the stiffness sets in
  double guard_mm = 0.5;   // sheets so near to a place are its pairs
  double margin_mm = 1, look_mm = 0.4;
  double most_mm = 0.4;  // deeper overlaps push no harder than this one
  double slide_mm = 0.15, turn_deg = 5, spot_mm = 1;
  double weight = 0.25;  // a pair whose weight would change by so much is found anew
  // Where pairs fade, from 1 to 0. Thinner flaps than deep are none.
  double facing_full = 0.5, facing_none = 0.2;  // minus the cosine between the two normals
  double deep_full_mm = 0.6, deep_none_mm = 2;  // how far inside
  double other_full = 1.25, other_none = 2;     // how much farther the way out is than the shortest one
};

class ContactFinder {
 public:
  ContactFinder(std::shared_ptr<const ContactSurface> surface, const FemModel& model,
                const ContactSettings& settings = {});

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
    int32_t copy = 0;  // of tissue_
    bool kin = false;  // it hangs together with the group's own
    auto operator<=>(const Around&) const = default;
  };
  struct Group {  // the places that one cell copy carries
    size_t first = 0, last = 0;
    size_t own = 0;                    // that copy, in tissue_
    int32_t sheet = -1;                // that all its places lie on, or -1
    double far_mm = 1e30;              // it and what is near it against each other, since its list was made
    double near_mm = 1e30;             // it and the list's copies against each other, since its places last looked
    bool due = false, afresh = false;  // its places look around; its list has had its time
    bool listed = true;                // false: of its list only who carries what it has pairs with is there yet
    std::vector<int32_t> around;
  };
  struct Looked {  // of a place
    Vec3 slid_mm = Vec3::Zero();
    int32_t turns = 0;
    bool due = false;    // it looks, since its group does or a pair of its own is stale; then: it is judged
    bool stale = false;  // a pair of its own is
  };
  struct Held {  // a place that is in or near a copy
    int32_t place = 0, copy = 0;
    bool kin = false, in = false;  // in the cell itself, not beside it
    int32_t part = 0;
    Vec3 at = Vec3::Zero();
  };
  struct Chunk {
    size_t first = 0, last = 0;  // of groups
    std::vector<Pair> pair;
    std::vector<Held> held;        // by place; of this search
    std::vector<Held> judged;      // by place; by which each was judged last
    std::vector<int32_t> unknown;  // parts
    bool changed = false, due = false;
    double left_mm = 0;     // until any of its pairs can turn
    double nearest_mm = 0;  // clearance of its nearest pair, at least
    uint64_t looks = 0, turned = 0;
  };
  Vec3 displacement(const EmbeddedPoint& e) const;
  Vec3 shown_mm(int32_t triangle, const std::array<double, 3>& bary) const;
  Vec3 carried_normal(int32_t triangle, const std::array<double, 3>& bary, const Vec3& N) const;
  void check(size_t chunk);
  void begin_list(Group& group, std::span<const Pair> pairs) const;
  void complete_list(Group& group, std::vector<uint8_t>& kinship) const;
  void mark_kin(const Group& group, bool marked, std::vector<uint8_t>& kinship) const;
  double moved_mm(const Group& group) const;
  struct Point {  // where a place is that looks
    size_t place = 0;
    Vec3f p = Vec3f::Zero();
  };
  void who_may_hold(const Group& group, std::span<const Point> points, std::vector<Around>& around,
                    std::vector<uint8_t>& kinship) const;
  void locate(const Point& point, std::span<const Around> around, std::vector<Held>& held) const;
  bool where_it_was(std::span<const Held> now, std::span<const Held> judged) const;
  bool slide(Looked& looked, const Vec3& slid_mm) const;
  void judge(size_t place, std::span<const Held> held, std::vector<HeldContact>& found) const;
  void find_cells(size_t chunk);
  void find_pairs(size_t chunk);
  void merge(size_t place, std::span<Pair> before, std::vector<HeldContact>& found, Chunk& chunk,
             std::vector<Pair>& out);
  void make_contact(Pair& p) const;

  std::shared_ptr<const ContactSurface> surface_;
  ContactSettings settings_;
  double cell_mm_ = 1, turn_cos_ = 1;
  RestTissue tissue_;
  MovingCells cells_;
  SurfaceMotion motion_;
  std::vector<int32_t> carrier_;  // per triangle: its copy in tissue_
  std::vector<Group> group_;      // by copy, and so by place
  std::vector<Vec3> normal_;      // per place, at rest
  std::vector<fem::v4> u_;        // per node of the model
  std::vector<Looked> looked_;    // per place
  std::vector<Chunk> chunk_;      // of groups
  std::vector<size_t> chunk_of_;  // per place
  std::vector<Contact> contacts_;
  bool near_ = false, resumed_ = false;
  double since_sorted_mm_ = 1e30;  // cells_
  ContactCounts counts_;
};

}  // namespace limberg
