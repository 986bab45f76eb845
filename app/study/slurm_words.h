#pragma once
// What Slurm's commands print, read.
#include <string>

namespace limberg::study {

struct Queue {
  size_t running = 0, waiting = 0;  // tasks
  std::string held;                 // why some wait that will not start by themselves; empty: none
};
/// Of `squeue --noheader --array --format=%t|%r`: a task a line. What is no such line is passed over.
Queue read_queue(const std::string& text);

/// Of `scontrol show config`: MaxArraySize, the number that no index of an array may reach; 1001, Slurm's own default,
/// when it does not say.
int read_max_array(const std::string& text);

/// Of `sbatch --parsable`: the job's number, without the cluster's name; empty: none.
std::string read_job(const std::string& text);

}  // namespace limberg::study
