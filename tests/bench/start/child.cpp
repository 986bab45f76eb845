#include "tests/bench/start/child.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <set>

#include "app/session/clock.h"
#include "sim/base/error.h"

namespace limberg::bench {

namespace {

/// "calling init: /lib/libz.so.1", one for each library, whether linked or opened later (ld.so, LD_DEBUG=libs).
std::vector<std::string> libraries_told(const std::string& folder) {
  std::set<std::string> names;
  for (const auto& e : std::filesystem::directory_iterator(folder)) {
    std::ifstream in(e.path());
    for (std::string line; std::getline(in, line);)
      if (const size_t at = line.find("calling init: "); at != std::string::npos)
        names.insert(std::filesystem::path(line.substr(at + 14)).filename());
  }
  return {names.begin(), names.end()};
}

}  // namespace

ChildFigures run_child(const std::vector<std::string>& words, const std::string& folder) {
  std::filesystem::remove_all(folder), std::filesystem::create_directories(folder);
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) throw InputError("", 0, "no pipe can be made; expected fewer open files");
  std::vector<std::string> settings{"LD_DEBUG=libs", "LD_DEBUG_OUTPUT=" + folder + "/loader"};
  for (char** e = environ; *e; ++e)
    if (const std::string s = *e; !s.starts_with("DISPLAY=") && !s.starts_with("WAYLAND_DISPLAY="))
      settings.push_back(s);
  std::vector<char*> argv, env;
  for (const std::string& w : words) argv.push_back(const_cast<char*>(w.c_str()));
  for (const std::string& s : settings) env.push_back(const_cast<char*>(s.c_str()));
  argv.push_back(nullptr), env.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_adddup2(&actions, ends[1], STDERR_FILENO);
  ChildFigures f;
  pid_t pid = -1;
  const int64_t began = RealClock::monotonic_ns();
  const auto since = [&] { return double(RealClock::monotonic_ns() - began) * 1e-9; };
  const bool started = posix_spawn(&pid, words[0].c_str(), &actions, nullptr, argv.data(), env.data()) == 0;
  posix_spawn_file_actions_destroy(&actions);
  close(ends[1]);
  char text[4096];
  for (ssize_t n; started && (n = read(ends[0], text, sizeof text)) > 0;)
    if (f.until_line_s < 0 && std::find(text, text + n, '\n') != text + n) f.until_line_s = since();
  close(ends[0]);
  if (!started) return f;
  int status = 0;
  rusage used{};
  wait4(pid, &status, 0, &used);
  f.took_s = since();
  f.status = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  f.peak_mb = double(used.ru_maxrss) * 1024 / 1e6;
  f.libraries = libraries_told(folder);
  return f;
}

}  // namespace limberg::bench
