#pragma once
// Vector types of the float engine. GCC/Clang vector extensions, so that the same code runs with SSE2 and with AVX-512;
// only where a shuffle has no good narrow form does a kernel keep two versions.
//
// Files that include this header may be compiled for the building machine (LIMBERG_NATIVE) and must not include Eigen:
// its alignment rules change with the instruction set, and two layouts of one type must never meet in one program.
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <new>
#include <utility>
#ifdef __AVX512F__
#include <immintrin.h>
#endif

namespace limberg::fem {

typedef float v4 __attribute__((vector_size(16)));
typedef float v16 __attribute__((vector_size(64)));
typedef int32_t v4i __attribute__((vector_size(16)));
typedef int32_t v16i __attribute__((vector_size(64)));
typedef double v8d __attribute__((vector_size(64)));

/// A node's vector in 16 bytes; w is zero unless a function says what it keeps there.
struct alignas(16) Node4 {
  float x = 0, y = 0, z = 0, w = 0;
};

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
    if (n > n_ || n == 0 || bytes(n) != bytes(n_)) {
      ::operator delete[](static_cast<void*>(p_), std::align_val_t(64));
      p_ = static_cast<T*>(::operator new[](bytes(n), std::align_val_t(64)));
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
  size_t n_ = 0;
};

using NodeArray = AlignedArray<Node4>;

inline v4 load(const Node4& a) { return *reinterpret_cast<const v4*>(&a); }
inline void store(Node4& a, v4 v) { *reinterpret_cast<v4*>(&a) = v; }

#ifdef __AVX512F__
/// The same four numbers in every 128-bit lane.
inline v16 in_every_lane(const void* four) { return (v16)_mm512_broadcast_f32x4(_mm_loadu_ps(static_cast<const float*>(four))); }
#endif

/// Three vectors of 16 numbers (x, y, z of 16 rows) to four vectors whose 128-bit lane l holds row 4*l + k as (x,y,z,0).
inline void to_rows(v16 x, v16 y, v16 z, v16 r[4]) {
  const v16 o = {};
  const v16i lo = {0, 16, 1, 17, 4, 20, 5, 21, 8, 24, 9, 25, 12, 28, 13, 29};
  const v16i hi = {2, 18, 3, 19, 6, 22, 7, 23, 10, 26, 11, 27, 14, 30, 15, 31};
  const v16i first = {0, 1, 16, 17, 4, 5, 20, 21, 8, 9, 24, 25, 12, 13, 28, 29};
  const v16i second = {2, 3, 18, 19, 6, 7, 22, 23, 10, 11, 26, 27, 14, 15, 30, 31};
  const v16 a = __builtin_shuffle(x, y, lo), b = __builtin_shuffle(x, y, hi);
  const v16 c = __builtin_shuffle(z, o, lo), d = __builtin_shuffle(z, o, hi);
  r[0] = __builtin_shuffle(a, c, first), r[1] = __builtin_shuffle(a, c, second);
  r[2] = __builtin_shuffle(b, d, first), r[3] = __builtin_shuffle(b, d, second);
}

/// The inverse: r[k] has row 4*l + k in lane l.
inline void from_rows(const v16 r[4], v16& x, v16& y, v16& z) {
  const v16i lo = {0, 16, 1, 17, 4, 20, 5, 21, 8, 24, 9, 25, 12, 28, 13, 29};
  const v16i hi = {2, 18, 3, 19, 6, 22, 7, 23, 10, 26, 11, 27, 14, 30, 15, 31};
  const v16i first = {0, 1, 16, 17, 4, 5, 20, 21, 8, 9, 24, 25, 12, 13, 28, 29};
  const v16i second = {2, 3, 18, 19, 6, 7, 22, 23, 10, 11, 26, 27, 14, 15, 30, 31};
  const v16 a = __builtin_shuffle(r[0], r[1], lo), b = __builtin_shuffle(r[2], r[3], lo);
  const v16 c = __builtin_shuffle(r[0], r[1], hi), d = __builtin_shuffle(r[2], r[3], hi);
  x = __builtin_shuffle(a, b, first), y = __builtin_shuffle(a, b, second);
  z = __builtin_shuffle(c, d, first);
}

}  // namespace limberg::fem
