#pragma once
// Workers on N threads, the caller included: N - 1 helpers that sleep between loops and take background jobs.
//
// A loop is cut into the same chunks whatever N is, so results do not depend on it. One loop runs at a time; a loop
// begun while another runs (from a background job) runs on its caller alone. Helpers run at SCHED_OTHER.
//
// When another job takes a helper's core in the middle of a chunk, the caller has to wait until
// the scheduler gives the core back: milliseconds, for a loop of microseconds. So every loop is
// timed. A caller that has waited far longer than its own chunks took does the next loops alone,
// for 10 ms at first and for twice as long after every such wait up to 1 s, and shares again
// afterwards; 500 shared loops without a long wait forget the past. Who does a chunk never changes
// what it gives. An exception from a chunk or a job is thrown again to whoever waits for it.
#include <cstdint>
#include <memory>

#include "sim/base/workers.h"

namespace limberg {

class WorkersPool final : public Workers {
 public:
  /// n >= 1, or as many as the machine gives threads for. With n = 1 there is no helper: a job runs when it is waited
  /// for.
  explicit WorkersPool(int n);
  ~WorkersPool() override;

  int count() const override { return n_; }
  /// Loops so far: shared with helpers, done alone because of a long wait before, and those waits.
  struct Pace {
    uint64_t shared = 0, alone = 0, long_waits = 0;
  };
  Pace pace() const;
  void parallel_for(size_t n, size_t grain, const std::function<void(size_t, size_t)>& body) override;
  std::shared_ptr<Job> submit(std::function<void()> job) override;
  /// One at a time among all pools of the process.
  void alone(const std::function<void()>& job) override;

 private:
  void end();
  struct Impl;
  std::unique_ptr<Impl> impl_;
  int n_;
};

}  // namespace limberg
