#pragma once
// Several runs of programs at once, each with a limit of time.
#include <sys/types.h>

#include <deque>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace limberg::study {

struct Process {
  std::vector<std::string> arguments;  // the first is the program, looked for as the shell does
  std::string log_file;                // of what it says, in words
  std::string output_file = {};        // of what it prints; empty: thrown away
  double limit_s = 0;                  // it is ended (SIGKILL) after so long; 0: never
  // In a process group of its own, so that Ctrl-C on a terminal reaches only this program, which passes it on once.
  // Under a scheduler, which ends what it knows of, all stay in one.
  bool own_group = true;
};

/// Told instead of an exit status: 1000 + the signal that ended it, and these.
inline constexpr int kNotRun = -1;       // it could not be started, or was stopped before
inline constexpr int kOverLimit = 2000;  // it was ended because it took too long
using Ended = std::function<void(size_t process, int status)>;

/// Runs what it is given, at most `at_once` at a time, in that order.
class ProcessPool {
 public:
  explicit ProcessPool(int at_once) : at_once_(at_once) {}
  /// Those that run are asked to end, and waited for.
  ~ProcessPool();
  ProcessPool(const ProcessPool&) = delete;
  ProcessPool& operator=(const ProcessPool&) = delete;

  void add(size_t name, Process process) { waiting_.emplace_back(name, std::move(process)); }
  /// Starts what there is room for and tells which have ended since. Does not wait.
  void turn(const Ended& ended);
  /// Starts none any more (they are told as kNotRun); those that run are asked to end (SIGTERM).
  void stop();
  size_t running() const { return running_.size(); }
  bool idle() const { return running_.empty() && waiting_.empty(); }

 private:
  struct Running {
    size_t name = 0;
    double until_s = 0;  // 0: no limit
    bool over = false;
  };
  int at_once_;
  bool stopped_ = false;
  std::deque<std::pair<size_t, Process>> waiting_;
  std::map<pid_t, Running> running_;
};

/// Runs all; `ended` is called as each ends, on this thread. When interrupted() is true the pool is stopped.
void run_processes(const std::vector<Process>& processes, int at_once, const std::function<bool()>& interrupted,
                   const std::function<void(size_t running)>& idle, const Ended& ended);

/// What a short program printed and said, and its status.
struct Answer {
  int status = kNotRun;
  std::string output, words;
};
/// Waits for it, `limit_s` at most. InputError when there is no room for temporary files.
Answer ask_program(const std::vector<std::string>& arguments, double limit_s = 60);

/// The running program's own file.
std::string this_program();
/// As a shell takes it for one word.
std::string quoted(const std::string& word);
/// A short rest between two looks.
void nap(double seconds);

}  // namespace limberg::study
