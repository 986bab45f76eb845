// limberg: the command line. Each command is a file in commands/; here are only the frame, the exit status and the
// errors.
#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <new>
#include <string>
#include <utility>
#include <vector>

#include "app/commands/commands.h"
#include "app/interrupt.h"
#include "app/manual.h"
#include "app/progress.h"
#include "app/version.h"
#include "sim/error.h"

namespace limberg {
namespace {

int defect(const char* what) {
  say(std::string("internal error: ") + what + "; this is a defect of " + program_name() +
      ", please report it with the command line and the input files to the project's issue list");
  return kDefect;
}

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
  add_superpose(app, chosen);
  add_measures(app, chosen);
  add_design(app, chosen);
  // `limberg help run` as `limberg run --help`, for those who are used to it.
  std::vector<std::string> words(argv + 1, argv + argc);
  if (!words.empty() && words.front() == "help") {
    words.erase(words.begin());
    const std::vector<const CLI::App*> commands = std::as_const(app).get_subcommands({});
    if (words.empty() || std::any_of(commands.begin(), commands.end(),
                                     [&](const CLI::App* c) { return c->get_name() == words.front(); }))
      words.emplace_back("--help");
  }
  std::reverse(words.begin(), words.end());  // CLI11 takes them from the end
  try {
    app.parse(words);
  } catch (const CLI::Success& e) {
    return app.exit(e);  // --help, --version: on standard output
  } catch (const CLI::ParseError& e) {
    std::string what = e.what();
    for (char& c : what)
      if (c == '\n') c = ' ';
    const std::vector<CLI::App*> command = app.get_subcommands();
    const std::string help = "limberg " + (command.empty() ? "" : command.front()->get_name() + " ") + "--help";
    say(what + (what.find("; expected ") == std::string::npos ? "; expected a call as in " + help : " (" + help + ")"));
    return kBadInput;
  }
  if (man || completion) {
    std::fputs((man ? manual_page(app, program_name()) : bash_completion(app)).c_str(), stdout);
    return kDone;
  }
  if (!chosen) {
    if (app.get_subcommands().empty()) std::fputs(kFirstSteps, stdout);
    return kDone;
  }
  end_at_interrupts();  // commands with something to keep catch them instead
  return chosen();
}

/// What was printed may still wait in a buffer: a full disk is told, as for any other file.
int flushed(int status) {
  if (std::fflush(stdout) == 0 && !std::ferror(stdout)) return status;
  pollfd reader{STDOUT_FILENO, POLLOUT, 0};
  if (poll(&reader, 1, 0) == 1 && (reader.revents & POLLERR) != 0) return status;  // a pipe whose reader has had enough
  say("standard output: cannot be written; expected room and permission");
  return status == kDone ? int(kBadInput) : status;
}

/// A caller may have closed standard input, output or error. The next file that is opened would take that number, and
/// what is
/// printed would go into a recording.
void keep_standard_files() {
  for (const int fd : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    if (fcntl(fd, F_GETFD) < 0 && open("/dev/null", O_RDWR) != fd) std::abort();  // the lowest free number is fd
}

}  // namespace
}  // namespace limberg

int main(int argc, char** argv) {
  using namespace limberg;
  keep_standard_files();
  try {
    return flushed(run_main(argc, argv));
  } catch (const InputError& e) {
    say(e.what());
    return kBadInput;
  } catch (const std::bad_alloc&) {
    say("not enough memory for this input; expected a smaller body or larger cells (--cell-mm)");
    return kBadInput;
  } catch (const std::exception& e) {
    return defect(e.what());
  } catch (...) {
    return defect("unknown exception");
  }
}
