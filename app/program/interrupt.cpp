#include "app/program/interrupt.h"

#include <unistd.h>

#include <atomic>
#include <csignal>

namespace limberg {

namespace {

std::atomic<bool> flag{false};  // a signal handler can reach nothing else
static_assert(std::atomic<bool>::is_always_lock_free);

void set_flag(int) { flag.store(true); }

void end_now(int) {
  constexpr char line[] = "limberg: interrupted; nothing was written\n";
  [[maybe_unused]] const ssize_t n = write(STDERR_FILENO, line, sizeof line - 1);
  _exit(3);
}

void on_interrupt(void (*handler)(int)) {
  struct sigaction a {};
  a.sa_handler = handler;
  a.sa_flags = int(SA_RESETHAND) | SA_RESTART;
  sigemptyset(&a.sa_mask);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction now {};
    if (signal == SIGHUP && sigaction(signal, nullptr, &now) == 0 && now.sa_handler == SIG_IGN) continue;  // nohup
    sigaction(signal, &a, nullptr);
  }
}

}  // namespace

void end_at_interrupts() {
  on_interrupt(end_now);
  std::signal(SIGPIPE, SIG_IGN);
}

void catch_interrupts() { on_interrupt(set_flag); }

bool interrupted() { return flag.load(); }

}  // namespace limberg
