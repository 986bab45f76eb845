#include "app/commands/command_line.h"

#include <cxxabi.h>
#include <execinfo.h>
#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <new>
#include <system_error>
#include <typeinfo>
#include <utility>

#include "app/program/interrupt.h"
#include "app/program/shown.h"
#include "app/program/version.h"
#include "app/result/progress.h"
#include "sim/base/error.h"

namespace limberg {
namespace {

int defect(const char* what) {
  say(std::string("internal error: ") + what + "; this is a defect of " + program_name() +
      ", please report it with the command line and the input files to the project's issue list");
  return kDefect;
}

/// Takes no memory: there is none.
int out_of_memory() noexcept {
  constexpr char line[] =
      "limberg: not enough memory for this input; expected a smaller body or larger cells (--cell-mm)\n";
  [[maybe_unused]] const ssize_t n = write(STDERR_FILENO, line, sizeof line - 1);
  return kBadInput;
}

/// Where even what clears up wants memory (a JSON value takes some to be destroyed) there is nowhere to throw to. What
/// was recorded is on its way to the disk since a tenth of a second.
[[noreturn]] void end_without_memory() {
  if (const std::type_info* t = abi::__cxa_current_exception_type(); t && *t == typeid(std::bad_alloc))
    _exit(out_of_memory());
  std::abort();
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
/// what is printed would go into a recording.
void keep_standard_files() {
  for (const int fd : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    if (fcntl(fd, F_GETFD) < 0 && open("/dev/null", O_RDWR) != fd) std::abort();  // the lowest free number is fd
}

}  // namespace

int run_command_line(CLI::App& app, std::vector<std::string> words, const Chosen& chosen, const char* first_steps) {
  // `limberg help run` as `limberg run --help`, for those who are used to it.
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
    const std::string help =
        app.get_name() + " " + (command.empty() ? "" : command.front()->get_name() + " ") + "--help";
    say(what + (what.find("; expected ") == std::string::npos ? "; expected a call as in " + help : " (" + help + ")"));
    return kBadInput;
  }
  if (!chosen) {
    if (app.get_subcommands().empty()) std::fputs(first_steps, stdout);
    return kDone;
  }
  end_at_interrupts();  // commands with something to keep catch them instead
  return chosen();
}

int run_framed(const std::function<int()>& body) {
  std::set_terminate(end_without_memory);
  // The C library loads what it unwinds with when it first does, through std::call_once say, and ends the program where
  // there is no memory for that: so at once.
  void* here = nullptr;
  backtrace(&here, 1);
  keep_standard_files();
  show_standard_output();
  try {
    return flushed(body());
  } catch (const InputError& e) {
    say(e.what());
    return kBadInput;
  } catch (const std::filesystem::filesystem_error& e) {  // a name that no file system takes, a link that goes round
    say((e.path1().empty() ? "a file" : e.path1().string()) + ": cannot be used (" + e.code().message() +
        "); expected a file or folder that can be reached");
    return kBadInput;
  } catch (const std::bad_alloc&) {
    return out_of_memory();
  } catch (const std::system_error& e) {
    if (e.code() != std::errc::resource_unavailable_try_again) return defect(e.what());
    say(std::string(e.what()) + "; expected a machine that gives one more (ulimit -u)");
    return kBadInput;
  } catch (const std::exception& e) {
    return defect(e.what());
  } catch (...) {
    return defect("unknown exception");
  }
}

}  // namespace limberg
