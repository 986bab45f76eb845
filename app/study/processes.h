#pragma once
// Several runs of a program at once.
#include <functional>
#include <string>
#include <vector>

namespace limberg::study {

struct Process {
  std::vector<std::string> arguments;  // the first is the program
  std::string log_file;                // of what it says, in words; its output is thrown away
};

/// How a process ended: its exit status, or 1000 + the signal that
/// ended it; -1: it could not be started or was stopped before.
using Ended = std::function<void(size_t process, int status)>;

/// Runs all, at most `at_once` at a time, in their order; `ended` is called as each ends, on this thread. When
/// interrupted() is true none is started any more, those that run are asked to end (SIGTERM) and waited for. Each is in
/// a process group of its own, so that Ctrl-C
/// on a terminal reaches only this program, which passes it on once.
void run_processes(const std::vector<Process>& processes, int at_once, const std::function<bool()>& interrupted,
                   const std::function<void(size_t running)>& idle, const Ended& ended);

/// The running program's own file.
std::string this_program();

}  // namespace limberg::study
