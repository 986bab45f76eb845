#pragma once
// The fuzzer at the height of a patient: what a surgeon's hand does, act by act, on a World, and after each act
//
//   always    a refused act leaves every bit as it was and says why;
//             remaining and removed volume are the body's; the lattice has
//             the arrangement's pieces and volume; a cut moves nothing
//             (I7: every copy starts where its parent is, seen at the
//             corners of the surface); undo gives back the bits of just
//             before the act, redo those of just before the undo
//   in full   Arrangement::check_all, check_topology, the lattice equals one built from nothing
//   at last   all that was not undone again on a new patient: the
//             same bits; where no step was taken, on another lattice:
//             the same arrangement; then everything undone
//
// A case is an operation script (sim/commands/script.h) whose scene names the patient: "fuzz size=60 cell=5 ...".
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "app/operating_point/bench.h"
#include "sim/base/workers.h"
#include "sim/commands/command.h"
#include "sim/patient/world.h"

namespace limberg::fuzz {

struct WorldCase {
  int size_mm = 60, thickness_mm = 10, skin_cell_mm = 3, cell_mm = 5;
  bool fronts = false;  // cells at a cut's end are divided
  bool steps = true;    // Wait{s} makes 100 * s solver steps; else none, and strokes do not depend on the lattice
  uint64_t seed = 1;
  std::vector<Command> acts;
  std::string violation;  // what went wrong when it was written
};

/// A script, and back; InputError when its scene is no fuzz patient.
std::string to_text(const WorldCase& c);
WorldCase world_case(const std::string& text, const std::string& file);

struct WorldCounts {
  int64_t acts = 0, done = 0, cuts = 0, refused = 0, defects = 0;  // defects: refused because something inside failed
  int64_t undone = 0, redone = 0, full_checks = 0;
  void add(const WorldCounts& b);
};

class WorldRunner {
 public:
  WorldRunner(const WorldCase& c, int check_every);

  /// Empty, or which invariant broke. Nothing more can be done with this runner then.
  std::string apply(const Command& command);
  std::string finish();  // what comes at last

  const World& world() const { return *world_; }
  const WorldCounts& counts() const { return counts_; }
  const std::vector<std::string>& defects() const { return defects_; }

 private:
  struct Entry {  // of the history: hashes before the act, and before it was undone
    uint64_t before = 0, after = 0;
  };
  std::string act(const Command& command);
  std::string check(bool full) const;
  std::unique_ptr<World> make(int cell_mm) const;
  void wait(World& world, double seconds) const;

  WorldCase case_;
  int check_every_;
  InlineWorkers workers_;
  std::unique_ptr<World> world_;
  std::vector<Entry> done_, redo_;
  int stroke_ = 0;            // that has its entry
  std::vector<Command> all_;  // as given
  WorldCounts counts_;
  std::vector<std::string> defects_;
};

/// The whole of a case: empty or the violation, and at which act (as many as there are: at last).
struct WorldOutcome {
  std::string violation;
  size_t act = 0;
  WorldCounts counts;
  std::vector<std::string> defects;
};
WorldOutcome run_world_case(const WorldCase& c, int check_every = 1);

struct WorldFuzzSettings {
  int64_t acts = 400;
  uint64_t seed = 1;
  int check_every = 3;
  int max_violations = 10;
  int shrink_runs = 60;
  std::string out_dir;                               // for cases that broke something; empty: none are written
  std::function<void(const std::string&)> progress;  // empty: silent
};
struct WorldFuzzReport {
  WorldCounts counts;
  struct Violation {
    std::string what, file;
  };
  std::vector<Violation> violations;
  std::vector<std::string> defects;  // reasons of acts refused because something inside failed
  bench::Result result() const;      // rows and bars
};
WorldFuzzReport world_fuzz(const WorldFuzzSettings& settings);

}  // namespace limberg::fuzz
