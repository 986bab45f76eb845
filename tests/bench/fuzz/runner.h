#pragma once
// Carries a case out operation by operation, arrangement and lattice together, and checks after each of them:
//
//   always       a cut keeps the exact volume (modulo 2^61 - 1); pieces never grow together; a refused cut leaves the
//                full hash and the record of the last operation as they were; the lattice update meets no
//                contradiction (I12-I14, I16) and has the arrangement's pieces (I15), volume and mass (I4-I6); its
//                parents refine (I7); undo gives back the full hash, redo the full hash of before the undo
//   in full      Arrangement::check_all (I1-I3, I9, I11, I13, orientation, coverage), check_topology, the updated
//                lattice equals one built from nothing
//   replay       the history again on a new body: same full hash; a finer lattice: same pieces, same volume, every
//                piece of a fine cell lies in one piece of the coarse cell
//   fault        signs forced to zero, steps made to fail, memory made to run out: rolled back, or right
#include <memory>
#include <string>
#include <vector>

#include "sim/cutting/arrangement/fault.h"
#include "sim/lattice/topology.h"
#include "tests/bench/fuzz/case.h"

namespace limberg::fuzz {

struct Counts {
  int64_t operations = 0;                                                         // all, of every kind
  int64_t cuts = 0, done = 0, nothing = 0, by_rule = 0, folded = 0, refused = 0;  // refused: 8 tries were not enough
  int64_t tries = 0;                                                              // of cuts that were done or refused
  int64_t excised = 0, undone = 0, redone = 0, replayed = 0, faults = 0, faults_rolled_back = 0;
  int64_t full_checks = 0;
  void add(const Counts& b);
};

struct Settings {
  int check_every = 1;  // operations between full checks
  bool with_lattice = true;
  bool skip_embedding = false;  // blades that run through themselves are taken: to show that the test is needed
};

/// A cut that was made and is not taken back: what later operations can refer to.
struct Made {
  int32_t number = 0;  // of the operation in the case
  Op op;
  std::vector<int32_t> blade_point;
  uint64_t full_before = 0;
  std::shared_ptr<const LatticeTopology> lattice_before;
  int tries = 0;
};

class Runner {
 public:
  Runner(const Case& c, const Settings& settings);
  ~Runner();

  /// Empty, or which invariant broke. Nothing more can be done with this runner then.
  std::string apply(const Op& op);

  const Arrangement& arrangement() const { return *a_; }
  const LatticeTopology* lattice() const { return t_.get(); }
  const std::vector<Made>& made() const { return made_; }
  size_t can_redo() const { return undone_.size(); }
  const Counts& counts() const { return counts_; }
  CutResult last_cut;

 private:
  struct Undone {
    Op op;
    int32_t number;
    uint64_t full_after;
    int tries;
  };
  std::string carry_out(const Op& op);
  std::string cut(const Op& op, int32_t number, int first_try = 0);
  std::string excise(const Op& op, int32_t number);
  std::string undo();
  std::string redo();
  std::string replay(const Op& op);
  std::string fault(const Op& op);
  std::string update_lattice(bool only_cuts);
  std::string check(bool full);
  Blade blade_of(const Op& op) const;
  int32_t component_of_rank(int which) const;

  Case case_;  // without operations
  Settings settings_;
  LatticeGrid grid_;
  std::unique_ptr<Arrangement> a_;
  std::shared_ptr<const LatticeTopology> t_;
  FaultPlan plan_;
  std::vector<Made> made_;
  std::vector<Undone> undone_;
  uint64_t body_volume_ = 0;
  double volume_mm3_ = 0;  // of what should be there
  int32_t number_ = 0;
  Counts counts_;
};

/// Runs a whole case; empty, or the violation and the number of the operation that showed it.
struct Outcome {
  std::string violation;
  int32_t op = -1;
  Counts counts;
};
Outcome run_case(const Case& c, const Settings& settings);

}  // namespace limberg::fuzz
