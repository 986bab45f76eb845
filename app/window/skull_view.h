#pragma once
// The skull beside a normal one or its mirror image, in the window:
// bones coloured by their distance from it, followed while they move.
//
// Fitting takes seconds and measuring a tenth of one, so both are done
// on a thread of their own; the picture shows what was found last.
#include <future>
#include <memory>
#include <optional>
#include <string>

#include "sim/commands/head_command.h"
#include "sim/imaging/register/superposition.h"
#include "sim/patient/snapshot.h"

namespace limberg {

class SkullView {
 public:
  /// What is to be shown instead of the snapshot: the bones alone, `moved_mm` their distance; null until there is one.
  /// `first`: the patient before anything was done. `normal_files`: lay_upon_normal.
  const Snapshot* show(SkullBeside with, const std::vector<std::string>& normal_files, const Snapshot& first,
                       const Snapshot& now);
  /// What it is at, in a few words; empty: it is done.
  std::string word() const { return word_; }

 private:
  struct Other {  // what it lies upon
    SurfaceTarget target;
    Similarity map;
    std::string reason;
  };
  struct Found {
    SkullBeside with = SkullBeside::off;
    std::shared_ptr<const Other> other;
    Snapshot shown;
    double rms_mm = 0;
  };
  SkullBeside with_ = SkullBeside::off;
  std::shared_ptr<const Other> other_;
  std::future<Found> work_;
  std::optional<Snapshot> shown_;
  std::vector<Vec3f> measured_;  // places of the bones that shown_ is of
  uint64_t version_ = uint64_t(1) << 40;
  std::string word_;
};

}  // namespace limberg
