#pragma once
// A transaction on the topology: the cuts and excisions of one act, then the version that follows from them. Whatever
// was not kept when it ends is taken back, exceptions included.
//
//   TissueCut cut(tissue);
//   CutResult r = cut.cut(blade, seed);            // refused: this cut alone has changed nothing
//   Outcome o = cut.build();                       // lattice, model and surface, aside
//   cut.enter();                                   // the tissue has its next version, the solver its model
//   cut.keep();                                    // else ~TissueCut takes all of it back
//
// The lattice follows between a cut and what is taken away after it, and before the next cut: an update that sees only
// one of the two names every parent exactly, one that sees both may not (lattice/topology.h).
#include <optional>
#include <span>
#include <vector>

#include "sim/commands/command.h"
#include "sim/patient/tissue.h"

namespace limberg {

/// The smallest loose piece that counts as tissue.
inline constexpr double kDebris_mm3 = 1;
/// Of a bed that a blade shaves while it undermines, where the skin over it is gone: a thinner slice counts as none.
inline constexpr double kShaving_mm = 1;

/// One cut of the arrangement with what went with it: enough to make it again.
struct CutStep {
  Blade blade;  // empty: it only takes something out
  uint64_t seed = 0;
  int first_try = 0;
  int32_t excised = -1;  // the component that was taken out afterwards
  int operations = 1;    // of the arrangement
  uint64_t hash_after = 0;
  DebrisResult debris;   // what the cut left loose and was swept with it
  double taken_mm3 = 0;  // volume of the excised component
};

class TissueCut {
 public:
  /// divide: of the lattice's cells that it touches.
  explicit TissueCut(Tissue& tissue, Divide divide = Divide::fronts);
  ~TissueCut();
  TissueCut(const TissueCut&) = delete;
  TissueCut& operator=(const TissueCut&) = delete;

  /// The blade, with the debris that it leaves. take_out_mm: and the piece there, which must be loose then.
  CutResult cut(const Blade& blade, uint64_t seed, const std::optional<Vec3>& take_out_mm = {});
  /// Takes out what is loose there.
  Outcome take_out(const Vec3& at_mm);
  /// Takes out the piece that this point of the present surface belongs to; refused while a good part of it is held, or
  /// where it is the patient. A strip of periosteum at its edge goes with it.
  Outcome take_out(const SurfacePoint& touched);
  /// Takes out what lies loose that has hardly any skin and is thinner than kShaving_mm (twice its volume over its
  /// surface): undermining goes on under a defect, and what it slices off the bed there no one would leave.
  DebrisResult sweep_shavings();
  /// The same blade, seed and try on the same state; false: other bits came of it, a defect.
  bool again(const CutStep& step);

  bool empty() const { return steps_.empty(); }
  const std::vector<CutStep>& steps() const { return steps_; }
  /// What the steps have taken away.
  double removed_mm3() const;

  /// The version that follows; refused: the lattice or the model cannot follow.
  Outcome build();
  const TissueVersion& built() const { return next_; }
  void enter();
  std::vector<CutStep> keep();  // the steps

  /// Takes steps that were kept back, the last first; given room, without asking for memory.
  static void take_back(Tissue& tissue, std::span<const CutStep> steps);
  static void make_room_to_take_back(Tissue& tissue, std::span<const CutStep> steps);

 private:
  int32_t shaving() const;                     // a component that is one; none: -1
  double held_share(int32_t component) const;  // of its surface
  Outcome follow();
  Outcome take(int32_t component, const char* attached);
  void back_to(int32_t operations);

  Tissue& tissue_;
  Arrangement& arrangement_;
  const Divide divide_;
  const int32_t operations_before_;
  bool kept_ = false;
  std::vector<CutStep> steps_;
  // The lattice after a part of the cuts, its parents in the tissue's version; null: nothing was followed yet.
  std::shared_ptr<const LatticeTopology> followed_;
  uint64_t followed_hash_ = 0;  // of the arrangement then
  int32_t followed_operations_ = 0;
  TissueVersion next_;
};

}  // namespace limberg
