#include "app/study/processes.h"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <time.h>

#include <algorithm>
#include <filesystem>
#include <map>

extern char** environ;

namespace limberg::study {

namespace {

/// 0 when it cannot be started.
pid_t start(const Process& p) {
  std::vector<std::string> words = p.arguments;
  std::vector<char*> argument;
  for (std::string& w : words) argument.push_back(w.data());
  argument.push_back(nullptr);
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_addopen(&files, 0, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&files, 1, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_addopen(&files, 2, p.log_file.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  posix_spawnattr_setpgroup(&attributes, 0);
  pid_t pid = 0;
  if (::posix_spawn(&pid, words[0].c_str(), &files, &attributes, argument.data(), environ) != 0) pid = 0;
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&files);
  return pid;
}

}  // namespace

void run_processes(const std::vector<Process>& all, int at_once, const std::function<bool()>& interrupted,
                   const std::function<void(size_t)>& idle, const Ended& ended) {
  std::map<pid_t, size_t> running;
  size_t next = 0;
  bool asked = false;
  while (next < all.size() || !running.empty()) {
    if (interrupted && interrupted() && !asked) {
      asked = true;
      for (const auto& [pid, i] : running) ::kill(pid, SIGTERM);
      for (; next < all.size(); ++next) ended(next, -1);
    }
    while (next < all.size() && int(running.size()) < std::max(1, at_once)) {
      const pid_t pid = start(all[next]);
      if (pid > 0)
        running[pid] = next;
      else
        ended(next, -1);
      ++next;
    }
    for (auto it = running.begin(); it != running.end();) {
      int status = 0;
      const pid_t done = ::waitpid(it->first, &status, WNOHANG);
      if (done == 0) {
        ++it;
        continue;
      }
      const size_t i = it->second;
      it = running.erase(it);
      ended(i, done < 0 ? -1 : WIFEXITED(status) ? WEXITSTATUS(status) : 1000 + WTERMSIG(status));
    }
    if (idle) idle(running.size());
    const timespec nap{0, 20'000'000};
    if (!running.empty()) ::nanosleep(&nap, nullptr);
  }
}

std::string this_program() {
  std::error_code ec;
  const auto self = std::filesystem::read_symlink("/proc/self/exe", ec);
  return ec ? "limberg" : self.string();
}

}  // namespace limberg::study
