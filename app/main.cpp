// limberg: the command line. Each command is a file in commands/; here they are listed.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <string>
#include <vector>

#include "app/commands/command_line.h"
#include "app/commands/commands.h"
#include "app/program/manual.h"
#include "app/program/version.h"

namespace limberg {
namespace {

// What a call without a command says.
constexpr const char* kFirstSteps =
    "Limberg: a trainer for open reconstructive surgery. Try:\n"
    "  limberg run                                    a window: operate on a rhomboid defect with the mouse; N shows "
    "each step\n"
    "  limberg replay recordings/rhomboid.lcm --out out/demo   a recorded operation, its pictures and its report\n"
    "  limberg operate zplasty recordings/zplasty.jsonl --out out/z   an operation by script, to equilibrium\n"
    "  limberg study zplasty --out out/study          what a Z-plasty gains, by its angle\n"
    "  limberg bench speed                            how fast it is on this machine\n"
    "limberg --help lists the commands; limberg COMMAND --help (or limberg help COMMAND) has an example of each.\n";

int run_main(int argc, char** argv) {
  CLI::App app("Limberg: a trainer for open reconstructive surgery", "limberg");
  app.require_subcommand(0, 1);
  app.set_version_flag("--version", program_name());
  app.footer(
      "Exit status: 0 done; 1 the program failed; 2 the input or the call is wrong; 3 the goal was not reached.\n"
      "Example: limberg replay recordings/rhomboid.lcm --out out/demo");
  bool man = false, completion = false;
  app.add_flag("--man", man, "Print the manual page (limberg --man | man -l -)");
  app.add_flag("--completion", completion, "Print the completion for bash");
  Chosen chosen;
  add_run(app, chosen);
  add_replay(app, chosen);
  add_operate(app, chosen);
  add_procedure(app, chosen);
  add_study(app, chosen);
  add_emulate(app, chosen);
  add_check(app, chosen);
  add_report(app, chosen);
  add_bench(app, chosen);
  add_calibrate(app, chosen);
  add_devices(app, chosen);
  add_fit(app, chosen);
  add_patient(app, chosen);
  add_import(app, chosen);
  add_export(app, chosen);
  add_superpose(app, chosen);
  add_cases(app, chosen);
  add_measures(app, chosen);
  add_actions(app, chosen);
  add_design(app, chosen);
  add_class(app, chosen);
  add_rooms(app, chosen);
  add_words(app, chosen);
  std::vector<std::string> words(argv + 1, argv + argc);
  if (!words.empty() && words.front() == "bench") return run_bench_beside({words.begin() + 1, words.end()});
  if (words.size() > 1 && words[0] == "help" && words[1] == "bench") return run_bench_beside({"--help"});
  app.callback([&] {
    if (man) chosen = [&] { return std::fputs(manual_page(app, program_name()).c_str(), stdout) < 0; };
    if (completion) chosen = [&] { return std::fputs(bash_completion(app).c_str(), stdout) < 0; };
  });
  return run_command_line(app, std::move(words), chosen, kFirstSteps);
}

}  // namespace
}  // namespace limberg

int main(int argc, char** argv) {
  return limberg::run_framed([&] { return limberg::run_main(argc, argv); });
}
