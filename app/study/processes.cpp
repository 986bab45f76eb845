#include "app/study/processes.h"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <time.h>

#include <algorithm>
#include <filesystem>

#include "app/program/temporary_folder.h"
#include "sim/base/whole_file.h"

extern char** environ;

namespace limberg::study {

namespace {

/// 0 when it cannot be started.
pid_t start(const Process& p) {
  std::vector<std::string> words = p.arguments;
  std::vector<char*> argument;
  for (std::string& w : words) argument.push_back(w.data());
  argument.push_back(nullptr);
  const char* output = p.output_file.empty() ? "/dev/null" : p.output_file.c_str();
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_addopen(&files, 0, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&files, 1, output, O_WRONLY | O_CREAT | O_TRUNC, 0644);
  posix_spawn_file_actions_addopen(&files, 2, p.log_file.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  if (p.own_group) {
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
    posix_spawnattr_setpgroup(&attributes, 0);
  }
  pid_t pid = 0;
  if (::posix_spawnp(&pid, words[0].c_str(), &files, &attributes, argument.data(), environ) != 0) pid = 0;
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&files);
  return pid;
}

double process_clock_s() {
  timespec t{};
  ::clock_gettime(CLOCK_MONOTONIC, &t);
  return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
}

int status_of(pid_t waited, int status, bool over) {
  if (over) return kOverLimit;
  if (waited < 0) return kNotRun;
  return WIFEXITED(status) ? WEXITSTATUS(status) : 1000 + WTERMSIG(status);
}

}  // namespace

ProcessPool::~ProcessPool() {
  stop();
  for (const auto& [pid, r] : running_) ::waitpid(pid, nullptr, 0);
}

void ProcessPool::stop() {
  if (stopped_) return;
  stopped_ = true;
  for (const auto& [pid, r] : running_) ::kill(pid, SIGTERM);
}

void ProcessPool::turn(const Ended& ended) {
  while (!waiting_.empty() && (stopped_ || int(running_.size()) < std::max(1, at_once_))) {
    const auto [name, process] = std::move(waiting_.front());
    waiting_.pop_front();
    const pid_t pid = stopped_ ? 0 : start(process);
    if (pid > 0)
      running_[pid] = {name, process.limit_s > 0 ? process_clock_s() + process.limit_s : 0};
    else
      ended(name, kNotRun);
  }
  for (auto it = running_.begin(); it != running_.end();) {
    auto& [pid, r] = *it;
    int status = 0;
    const pid_t waited = ::waitpid(pid, &status, WNOHANG);
    if (waited == 0) {
      if (r.until_s > 0 && !r.over && process_clock_s() > r.until_s) r.over = ::kill(pid, SIGKILL) == 0;
      ++it;
      continue;
    }
    const Running done = r;
    it = running_.erase(it);
    ended(done.name, status_of(waited, status, done.over));
  }
}

void run_processes(const std::vector<Process>& all, int at_once, const std::function<bool()>& interrupted,
                   const std::function<void(size_t)>& idle, const Ended& ended) {
  ProcessPool pool(at_once);
  for (size_t i = 0; i < all.size(); ++i) pool.add(i, all[i]);
  while (!pool.idle()) {
    if (interrupted && interrupted()) pool.stop();
    pool.turn(ended);
    if (idle) idle(pool.running());
    if (!pool.idle()) nap(0.02);
  }
}

Answer ask_program(const std::vector<std::string>& arguments, double limit_s) {
  const TemporaryFolder folder;
  const std::string output = (folder.path() / "output").string(), words = (folder.path() / "words").string();
  Answer answer;
  run_processes({{arguments, words, output, limit_s}}, 1, {}, {}, [&](size_t, int status) { answer.status = status; });
  if (answer.status == kNotRun) return answer;
  constexpr size_t kMost = size_t(16) << 20;
  answer.output = read_whole_file(output, kMost), answer.words = read_whole_file(words, kMost);
  return answer;
}

std::string this_program() {
  std::error_code ec;
  const auto self = std::filesystem::read_symlink("/proc/self/exe", ec);
  return ec ? "limberg" : self.string();
}

std::string quoted(const std::string& word) {
  if (!word.empty() &&
      word.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+=./,:") ==
          std::string::npos)
    return word;
  std::string out = "'";
  for (const char c : word) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

void nap(double seconds) {
  const timespec t{time_t(seconds), long(1e9 * (seconds - double(time_t(seconds))))};
  ::nanosleep(&t, nullptr);
}

}  // namespace limberg::study
