#pragma once
// Arrays of 16-byte vectors, as kernels want them: aligned, padded and zeroed. The loops over them are in
// fem/kernels/, once per instruction set.
#include <cstring>
#include <new>
#include <utility>

#include "sim/base/node4.h"

namespace limberg {

/// A fixed-size array on a 64-byte boundary, zeroed, its capacity rounded up to 64 bytes so that kernels may run over.
template <class T>
class AlignedArray {
 public:
  AlignedArray() = default;
  explicit AlignedArray(size_t n) { resize(n); }
  AlignedArray(const AlignedArray& o) {
    resize(o.n_);
    if (n_) std::memcpy(static_cast<void*>(p_), o.p_, n_ * sizeof(T));
  }
  AlignedArray(AlignedArray&& o) noexcept { swap(o); }
  AlignedArray& operator=(AlignedArray o) noexcept {
    swap(o);
    return *this;
  }
  ~AlignedArray() { ::operator delete[](static_cast<void*>(p_), std::align_val_t(64)); }

  /// Drops the old content; everything is zero afterwards.
  void resize(size_t n) {
    const size_t needed = bytes(n);
    if (needed > room_ || needed < room_ / 2) {
      ::operator delete[](static_cast<void*>(p_), std::align_val_t(64));
      p_ = nullptr;
      room_ = 0;
      const size_t room = n_ && n > n_ ? bytes(n + n / 16) : needed;  // what grows once grows again
      p_ = static_cast<T*>(::operator new[](room, std::align_val_t(64)));
      room_ = room;
    }
    n_ = n;
    zero();
  }
  void zero() {
    if (p_) std::memset(static_cast<void*>(p_), 0, bytes(n_));
  }
  void swap(AlignedArray& o) noexcept {
    std::swap(p_, o.p_);
    std::swap(n_, o.n_);
    std::swap(room_, o.room_);
  }
  size_t size() const { return n_; }
  bool empty() const { return n_ == 0; }
  T* data() { return p_; }
  const T* data() const { return p_; }
  T& operator[](size_t i) { return p_[i]; }
  const T& operator[](size_t i) const { return p_[i]; }
  T* begin() { return p_; }
  T* end() { return p_ + n_; }
  const T* begin() const { return p_; }
  const T* end() const { return p_ + n_; }

 private:
  static size_t bytes(size_t n) { return (n * sizeof(T) + 63) / 64 * 64 + 64; }
  T* p_ = nullptr;
  size_t n_ = 0, room_ = 0;  // room in bytes
};

using NodeArray = AlignedArray<Node4>;

}  // namespace limberg
