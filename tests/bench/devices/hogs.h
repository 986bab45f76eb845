#pragma once
// Threads of ordinary priority that only use time, until destroyed: the other work of a busy machine.
#include <atomic>
#include <memory>
#include <vector>

#include "app/session/thread.h"

namespace limberg::bench {

class Hogs {
 public:
  explicit Hogs(int n) {
    for (int i = 0; i < n; ++i)
      thread_.push_back(std::make_unique<ScheduledThread>([this] {
        uint64_t x = 1;
        while (!stop_.load(std::memory_order_relaxed))
          for (int k = 0; k < 1000; ++k) x = x * 6364136223846793005ull + 1;
        sink_.fetch_add(x, std::memory_order_relaxed);
      }));
  }
  ~Hogs() { stop_ = true; }

 private:
  std::atomic<bool> stop_{false};
  std::atomic<uint64_t> sink_{0};
  std::vector<std::unique_ptr<ScheduledThread>> thread_;
};

}  // namespace limberg::bench
