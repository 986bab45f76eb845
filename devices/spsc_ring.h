#pragma once
// Every value of something, in order, from one producer thread to one consumer thread, without waiting.
//
// The memory is taken once, at construction. A full ring refuses the value and counts it: an overflow is reported,
// never silent. Each side caches the other's index and looks at the shared one only when the cache says full or empty.
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace limberg {

template <class T>
class SpscRing {
  static_assert(std::atomic<size_t>::is_always_lock_free);

 public:
  /// Holds at least `capacity` values (rounded up to a power of two).
  explicit SpscRing(size_t capacity)
      : slot_(std::bit_ceil(capacity < 2 ? size_t(2) : capacity)), mask_(slot_.size() - 1) {}
  SpscRing(const SpscRing&) = delete;
  SpscRing& operator=(const SpscRing&) = delete;

  size_t capacity() const { return slot_.size(); }

  /// Producer only. False: the ring was full, the value is counted as lost.
  bool push(const T& v) noexcept {
    const size_t t = tail_.load(std::memory_order_relaxed);
    if (t - head_cache_ == slot_.size()) {
      head_cache_ = head_.load(std::memory_order_acquire);
      if (t - head_cache_ == slot_.size()) {
        lost_.store(lost_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
        return false;
      }
    }
    slot_[t & mask_] = v;
    tail_.store(t + 1, std::memory_order_release);
    return true;
  }

  /// Consumer only. False: the ring was empty.
  bool pop(T& v) noexcept {
    const T* first = front();
    if (!first) return false;
    v = *first;
    drop();
    return true;
  }

  /// Consumer only. The value that pop() would give, in its place until then; null: the ring is empty.
  T* front() noexcept {
    const size_t h = head_.load(std::memory_order_relaxed);
    if (h == tail_cache_) {
      tail_cache_ = tail_.load(std::memory_order_acquire);
      if (h == tail_cache_) return nullptr;
    }
    return &slot_[h & mask_];
  }
  /// Consumer only. Lets go of front().
  void drop() noexcept { head_.store(head_.load(std::memory_order_relaxed) + 1, std::memory_order_release); }

  /// How many values were refused. Any thread.
  uint64_t lost() const { return lost_.load(std::memory_order_relaxed); }

 private:
  std::vector<T> slot_;
  const size_t mask_;
  alignas(64) std::atomic<size_t> head_{0};  // next to pop; written by the consumer
  size_t tail_cache_ = 0;                    // the consumer's last look at tail_
  alignas(64) std::atomic<size_t> tail_{0};  // next to push; written by the producer
  size_t head_cache_ = 0;                    // the producer's last look at head_
  std::atomic<uint64_t> lost_{0};
};

}  // namespace limberg
