#pragma once
// Where the members of a study are run: on this machine, or on a cluster.
//
// An engine starts members and knows whether any of them may still leave a file. What they came to is not its business:
// it stands in the study's folder, one file for each member (member_file.h), written whole or not at all. So nothing is
// lost with the engine, its machine or a node: whoever asks again finds the files, and runs what is missing
// (campaign.h).
#include <memory>
#include <string>
#include <vector>

#include "app/study/study.h"

namespace limberg::study {

/// A member to be run.
struct Job {
  const Family* family = nullptr;
  Values values;
};

/// How each member is run, wherever.
struct MemberLimits {
  double seconds = 0;  // it is ended after so long, and has failed; 0: never
  int memory_MB = 0;   // what it may have of its own; 0: all there is
  int workers = 1;
  std::string simd = {};  // as of --simd; empty: the machine's
};

struct EngineState {
  size_t running = 0;  // members, as far as the engine knows
  bool over = true;    // nothing that was submitted will leave a file any more
  std::string note;    // what holds it up, in words; mostly nothing
};

class Engine {
 public:
  virtual ~Engine() = default;
  /// Hands these over. InputError when it cannot take them.
  virtual void submit(const std::vector<Job>& jobs) = 0;
  /// How far it is; also of what an earlier program has submitted for the same folder. Does not wait.
  virtual EngineState poll() = 0;
  /// After an interrupt. What goes on without this program is said; true: nothing does, and poll() has to be asked
  /// until all is over.
  virtual bool stop() = 0;
  virtual double poll_every_s() const = 0;
};

/// Processes on this machine, so many at a time. Those that end without a file of their own get one that says why.
/// `in_groups`: Process::own_group.
std::unique_ptr<Engine> local_engine(const std::string& dir, const MemberLimits& limits, int at_once,
                                     bool in_groups = true);

struct SlurmSettings {
  std::string study;              // the name that the command was called with
  int tasks_at_once = 0;          // 0: as many as the cluster gives
  int per_task = 0;               // members; 0: so that there are about kTasks
  std::vector<std::string> more;  // options for sbatch
  static constexpr int kTasks = 100;
};
/// A Slurm array, each task a number of members one after the other (`limberg study NAME --task FILE`). InputError when
/// there is no sbatch, or it refuses.
std::unique_ptr<Engine> slurm_engine(const std::string& dir, const MemberLimits& limits, const SlurmSettings& settings);

/// The command that runs one member and leaves its file.
std::vector<std::string> member_call(const Job& job, const std::string& dir, const MemberLimits& limits);

}  // namespace limberg::study
