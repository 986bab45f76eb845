#pragma once
// Threads whose scheduling is stated, never inherited: a real-time creator must not make real-time children.
#include <pthread.h>

#include <functional>
#include <memory>
#include <string>

namespace limberg {

/// Runs `body` at SCHED_OTHER on a new thread, joined by the destructor.
class ScheduledThread {
 public:
  explicit ScheduledThread(std::function<void()> body);
  ~ScheduledThread() { join(); }
  ScheduledThread(const ScheduledThread&) = delete;
  ScheduledThread& operator=(const ScheduledThread&) = delete;
  void join();

 private:
  pthread_t id_{};
  bool joinable_ = false;
};

/// Asks for SCHED_FIFO at `priority` and locked memory for the calling thread; says in one line what it got and what
/// follows from it. Memory is locked only where the limit allows all of it: otherwise later allocations would fail.
/// Priority 0: asks for nothing.
std::string request_real_time(int priority);

/// The end of what request_real_time() asked of the process: locked memory cannot be given back.
void unlock_memory();

/// Lowers the calling thread's priority (nice value, >= 0).
void be_nice(int nice);

/// At most this many microseconds of timer slack for the calling thread (the default is 50).
void request_exact_timers();

}  // namespace limberg
