#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <cstring>
#include <filesystem>

#include "app/commands/commands.h"
#include "sim/base/error.h"

namespace limberg {

void add_bench(CLI::App& app, Chosen& chosen) {
  CLI::App* c = app.add_subcommand(
      "bench", "Measure against bars, in CPU time: accuracy, speed, stability, cutting, devices and more");
  c->prefix_command();
  c->footer("Example: limberg bench speed --quick --json out/bench.json");
  c->callback([c, &chosen] { chosen = [c] { return run_bench_beside(c->remaining()); }; });
}

int run_bench_beside(const std::vector<std::string>& words) {
  std::error_code error;
  const std::filesystem::path self = std::filesystem::read_symlink("/proc/self/exe", error);
  const std::string program = (self.parent_path() / "limberg_bench").string();
  std::vector<char*> argv{const_cast<char*>(program.c_str())};
  for (const std::string& w : words) argv.push_back(const_cast<char*>(w.c_str()));
  argv.push_back(nullptr);
  execv(program.c_str(), argv.data());  // returns only where it failed
  throw InputError("", 0,
                   "limberg bench starts " + program + ", which cannot be run (" + std::strerror(errno) +
                       "); expected it there: ./do build makes it");
}

}  // namespace limberg
