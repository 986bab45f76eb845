#include "app/interrupt.h"

#include <atomic>
#include <csignal>

namespace limberg {

namespace {
std::atomic<bool> flag{false};  // a signal handler can reach nothing else
static_assert(std::atomic<bool>::is_always_lock_free);
void on_signal(int) { flag.store(true); }
}  // namespace

void catch_interrupts() {
  struct sigaction a {};
  a.sa_handler = on_signal;
  a.sa_flags = int(SA_RESETHAND) | SA_RESTART;
  sigemptyset(&a.sa_mask);
  sigaction(SIGINT, &a, nullptr);
  sigaction(SIGTERM, &a, nullptr);
  std::signal(SIGPIPE, SIG_IGN);
}

bool interrupted() { return flag.load(); }

}  // namespace limberg
