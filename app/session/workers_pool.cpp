#include "app/session/workers_pool.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <deque>
#include <exception>
#include <mutex>
#include <stdexcept>
#include <system_error>
#include <thread>
#include <vector>

#include "app/session/thread.h"

namespace limberg {

namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::microseconds;
using std::chrono::milliseconds;

// A wait is long when it is this much longer than three chunks of the caller's took.
constexpr microseconds patience{150};
constexpr milliseconds first_pause{10}, longest_pause{1000};
constexpr int good_loops_forget = 500;

void pause_cpu() {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#endif
}

}  // namespace

class PoolJob final : public Workers::Job {
 public:
  explicit PoolJob(std::function<void()> f) : f_(std::move(f)) {}
  bool done() const override { return state_.load(std::memory_order_acquire) == kDone; }
  void wait() override {
    run_if_unclaimed();
    for (int s = state_.load(std::memory_order_acquire); s != kDone; s = state_.load(std::memory_order_acquire))
      state_.wait(s, std::memory_order_acquire);
    if (error_) std::rethrow_exception(error_);
  }
  void run_if_unclaimed() {
    int expected = kWaiting;
    if (!state_.compare_exchange_strong(expected, kRunning, std::memory_order_acq_rel)) return;
    try {
      f_();
    } catch (...) {
      error_ = std::current_exception();
    }
    f_ = nullptr;  // frees what the job held on to
    state_.store(kDone, std::memory_order_release);
    state_.notify_all();
  }

 private:
  enum { kWaiting, kRunning, kDone };
  std::function<void()> f_;
  std::exception_ptr error_;
  std::atomic<int> state_{kWaiting};
};

// The loop in progress is described by plain members. They are written only while no helper is inside: `open` is closed
// first, then the caller waits for `inside` to fall to zero. A helper counts itself in before it looks at `open`, so
// (sequentially consistent) either the caller sees it inside or it sees the loop closed.
struct WorkersPool::Impl {
  const std::function<void(size_t, size_t)>* body = nullptr;
  size_t n = 0, grain = 1;
  std::atomic<size_t> next{0};
  std::atomic<bool> open{false};
  std::atomic<int> inside{0};
  std::atomic<bool> busy{false};
  std::exception_ptr error;
  std::mutex error_mutex;

  // How sharing goes; only the caller of a loop (the one that made it `busy`) touches these.
  Pace pace;
  Clock::time_point alone_until{};
  Clock::duration pause = first_pause;
  int good_loops = 0;

  std::mutex jobs_mutex;
  std::deque<std::shared_ptr<PoolJob>> jobs;

  std::atomic<uint32_t> bell{0};  // rung when there is something to do
  std::atomic<bool> stop{false};
  std::vector<std::unique_ptr<ScheduledThread>> helpers;

  void ring() {
    bell.fetch_add(1);
    bell.notify_all();
  }

  size_t take_chunks() {
    for (size_t taken = 0;; ++taken) {
      const size_t i = next.fetch_add(1, std::memory_order_relaxed);
      const size_t begin = i * grain;
      if (begin >= n) return taken;
      try {
        (*body)(begin, std::min(n, begin + grain));
      } catch (...) {
        const std::lock_guard lock(error_mutex);
        if (!error) error = std::current_exception();
      }
    }
  }

  void help() {
    while (!stop.load()) {
      const uint32_t heard = bell.load();
      inside.fetch_add(1);
      if (open.load()) take_chunks();
      inside.fetch_sub(1);
      std::shared_ptr<PoolJob> job;
      {
        const std::lock_guard lock(jobs_mutex);
        if (!jobs.empty()) job = std::move(jobs.front()), jobs.pop_front();
      }
      if (job) {
        job->run_if_unclaimed();
        continue;
      }
      // Loops of one solver iteration follow each other within microseconds: listen a moment before sleeping.
      for (int i = 0; i < 2000 && bell.load(std::memory_order_relaxed) == heard; ++i) pause_cpu();
      if (bell.load() == heard && !stop.load()) bell.wait(heard);
    }
  }
};

WorkersPool::WorkersPool(int n) : impl_(std::make_unique<Impl>()), n_(n) {
  if (n < 1) throw std::invalid_argument("a pool needs at least one worker");
  impl_->helpers.reserve(size_t(n) - 1);  // a helper for whom there is no room could not be told to stop
  try {
    for (int i = 1; i < n; ++i)
      impl_->helpers.push_back(std::make_unique<ScheduledThread>([p = impl_.get()] { p->help(); }));
  } catch (const std::system_error&) {  // a machine that gives no more threads: those that there are do the work
    n_ = 1 + int(impl_->helpers.size());
  } catch (...) {
    end();
    throw;
  }
}

WorkersPool::~WorkersPool() { end(); }

void WorkersPool::end() {
  impl_->stop.store(true);
  impl_->ring();
  impl_->helpers.clear();
}

void WorkersPool::parallel_for(size_t n, size_t grain, const std::function<void(size_t, size_t)>& body) {
  if (n == 0) return;
  if (grain == 0) grain = 1;
  if (n_ == 1 || n <= grain || impl_->busy.exchange(true)) {
    for (size_t b = 0; b < n; b += grain) body(b, std::min(n, b + grain));
    return;
  }
  Impl& p = *impl_;
  const Clock::time_point start = Clock::now();
  if (start < p.alone_until) {
    ++p.pace.alone;
    p.busy.store(false);
    for (size_t b = 0; b < n; b += grain) body(b, std::min(n, b + grain));
    return;
  }
  p.body = &body, p.n = n, p.grain = grain, p.error = nullptr;
  p.next.store(0, std::memory_order_relaxed);
  p.open.store(true);
  p.ring();
  const size_t taken = p.take_chunks();
  p.open.store(false);
  const Clock::time_point done = Clock::now();
  for (int spins = 0; p.inside.load() != 0; ++spins)
    if (spins < 1000)
      pause_cpu();
    else
      std::this_thread::yield();
  const Clock::time_point end = Clock::now();
  ++p.pace.shared;
  if (end - done > patience + 3 * (done - start) / std::max<int64_t>(1, int64_t(taken))) {
    ++p.pace.long_waits;
    p.alone_until = end + p.pause;
    p.pause = std::min<Clock::duration>(2 * p.pause, longest_pause);
    p.good_loops = 0;
  } else if (++p.good_loops == good_loops_forget) {
    p.pause = first_pause;
  }
  const std::exception_ptr error = p.error;
  p.busy.store(false);
  if (error) std::rethrow_exception(error);
}

WorkersPool::Pace WorkersPool::pace() const { return impl_->pace; }

std::shared_ptr<Workers::Job> WorkersPool::submit(std::function<void()> job) {
  auto j = std::make_shared<PoolJob>(std::move(job));
  if (n_ > 1) {
    {
      const std::lock_guard lock(impl_->jobs_mutex);
      impl_->jobs.push_back(j);
    }
    impl_->ring();
  }
  return j;
}

void WorkersPool::alone(const std::function<void()>& job) {
  static std::mutex one_at_a_time;  // what it guards is the process's own
  const std::scoped_lock lock(one_at_a_time);
  job();
}

}  // namespace limberg
