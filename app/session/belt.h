#pragma once
// One thing after another, done on a thread of its own while whoever hands them over goes on: the second thread of a
// film. At most two things wait; who hands over a third waits for room, so that neither runs away from the other.
//
// `begin`, `work` and `end` are called on that thread, in this order: it can own what belongs to one thread alone. The
// first exception of any of them is thrown again where the next thing is handed over, or at stop(); what comes after it
// is passed over.
#include <condition_variable>
#include <deque>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <utility>

#include "app/session/thread.h"

namespace limberg {

template <class Thing>
class Belt {
 public:
  static constexpr size_t kWaiting = 2;

  /// Returns, or throws, when `begin` has.
  Belt(std::function<void()> begin, std::function<void(Thing&)> work, std::function<void()> end)
      : begin_(std::move(begin)), work_(std::move(work)), end_(std::move(end)) {
    thread_ = std::make_unique<ScheduledThread>([this] { run(); });
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return begun_; });
    if (failure_) {
      lock.unlock();
      close();
      std::rethrow_exception(failure_);
    }
  }
  ~Belt() { close(); }
  Belt(const Belt&) = delete;
  Belt& operator=(const Belt&) = delete;

  void put(Thing thing) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return waiting_.size() < kWaiting || failure_; });
    if (failure_) std::rethrow_exception(failure_);
    waiting_.push_back(std::move(thing));
    changed_.notify_all();
  }
  /// After the last thing is done and `end` has been called.
  void stop() {
    close();
    if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
  }

 private:
  void close() {
    {
      const std::lock_guard lock(mutex_);
      closed_ = true;
      changed_.notify_all();
    }
    thread_.reset();  // joins
  }
  void run() {
    guarded(begin_);
    std::unique_lock lock(mutex_);
    begun_ = true;
    changed_.notify_all();
    for (;;) {
      changed_.wait(lock, [&] { return !waiting_.empty() || closed_; });
      if (waiting_.empty()) break;
      Thing thing = std::move(waiting_.front());
      waiting_.pop_front();
      changed_.notify_all();
      const bool passed_over = failure_ != nullptr;
      lock.unlock();
      if (!passed_over) guarded([&] { work_(thing); });
      lock.lock();
    }
    lock.unlock();
    guarded(end_);
  }
  template <class F>
  void guarded(F&& f) {
    try {
      f();
    } catch (...) {
      const std::lock_guard lock(mutex_);
      if (!failure_) failure_ = std::current_exception();
      changed_.notify_all();
    }
  }

  std::function<void()> begin_;
  std::function<void(Thing&)> work_;
  std::function<void()> end_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Thing> waiting_;
  std::exception_ptr failure_;
  bool begun_ = false, closed_ = false;
  std::unique_ptr<ScheduledThread> thread_;  // last: it uses all of the above
};

}  // namespace limberg
