#pragma once
// The newest value of something, from one writer thread to one reader thread, without waiting on either side.
//
// Three slots: the writer owns one, the reader owns one, the third lies between them. One atomic byte names the slot in
// between and whether it is newer than what the reader has. Publishing and updating each exchange an own slot for it,
// so values are never copied and never torn; a reader that is slow misses values, it never delays the writer.
//
//     writer                          reader
//     buffer.writing() = ...;         if (buffer.update()) { ... buffer.reading() ... }
//     buffer.publish();
//
// exchange is acquire-release on both sides: it hands the own slot over and takes the other one in one act.
#include <atomic>
#include <cstdint>

namespace limberg {

template <class T>
class TripleBuffer {
 public:
  TripleBuffer() = default;
  TripleBuffer(const TripleBuffer&) = delete;
  TripleBuffer& operator=(const TripleBuffer&) = delete;

  // Writer's side. The slot keeps what was written into it three values ago: vectors in it can be reused.
  T& writing() { return slot_[write_].value; }
  void publish() noexcept { write_ = between_.exchange(uint8_t(write_ | kFresh), std::memory_order_acq_rel) & kIndex; }

  // Reader's side. reading() stays the same object until update() says that there is a newer one.
  bool update() noexcept {
    if (!(between_.load(std::memory_order_relaxed) & kFresh)) return false;
    read_ = between_.exchange(read_, std::memory_order_acq_rel) & kIndex;
    return true;
  }
  const T& reading() const { return slot_[read_].value; }

  /// Calls f on each of the three slots; only while no other thread uses the buffer (to reserve memory, to clear).
  template <class F>
  void for_each_slot(F&& f) {
    for (auto& s : slot_) f(s.value);
  }

 private:
  static constexpr uint8_t kIndex = 3, kFresh = 4;
  static_assert(std::atomic<uint8_t>::is_always_lock_free);
  struct alignas(64) Slot {
    T value{};
  };
  Slot slot_[3];
  alignas(64) std::atomic<uint8_t> between_{2};
  alignas(64) uint8_t write_ = 0;  // only the writer looks at it
  alignas(64) uint8_t read_ = 1;   // only the reader looks at it
};

}  // namespace limberg
