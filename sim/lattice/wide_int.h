#pragma once
// Fixed-width signed integers of N 64-bit limbs, two's complement, for the exact fall-backs: no allocation, no overflow
// check (the widths are proved where they are used).
#include <array>
#include <cmath>
#include <cstdint>

namespace limberg {

__extension__ typedef __int128 Int128;
__extension__ typedef unsigned __int128 UInt128;

template <int N>
struct Wide {
  std::array<uint64_t, N> limb{};

  Wide() = default;
  Wide(Int128 v) {  // NOLINT: a number is a number
    limb[0] = uint64_t(v);
    for (int i = 1; i < N; ++i) limb[size_t(i)] = i == 1 ? uint64_t(v >> 64) : (v < 0 ? ~0ull : 0ull);
  }
  template <int M>
  explicit Wide(const Wide<M>& o) {
    const uint64_t fill = o.sign() < 0 ? ~0ull : 0ull;
    for (int i = 0; i < N; ++i) limb[size_t(i)] = i < M ? o.limb[size_t(i)] : fill;
  }

  int sign() const {
    if (int64_t(limb[N - 1]) < 0) return -1;
    for (uint64_t l : limb)
      if (l) return 1;
    return 0;
  }
  Wide operator-() const {
    Wide r;
    uint64_t carry = 1;
    for (size_t i = 0; i < N; ++i) r.limb[i] = ~limb[i] + carry, carry = carry && r.limb[i] == 0;
    return r;
  }
  friend Wide operator+(const Wide& a, const Wide& b) {
    Wide r;
    UInt128 c = 0;
    for (size_t i = 0; i < N; ++i) c += UInt128(a.limb[i]) + b.limb[i], r.limb[i] = uint64_t(c), c >>= 64;
    return r;
  }
  friend Wide operator-(const Wide& a, const Wide& b) { return a + (-b); }
  friend Wide operator*(const Wide& a, const Wide& b) {  // modulo 2^(64 N), which two's complement makes right for signs
    Wide r;
    for (size_t i = 0; i < N; ++i) {
      uint64_t carry = 0;
      for (size_t j = 0; i + j < N; ++j) {
        const UInt128 t = UInt128(a.limb[i]) * b.limb[j] + r.limb[i + j] + carry;
        r.limb[i + j] = uint64_t(t), carry = uint64_t(t >> 64);
      }
    }
    return r;
  }
  /// Nearest double within 2^-52 relative.
  double to_double() const {
    const bool negative = sign() < 0;
    const Wide m = negative ? -*this : *this;
    int top = N - 1;
    while (top > 0 && m.limb[size_t(top)] == 0) --top;
    double v = double(m.limb[size_t(top)]);
    if (top > 0) v = v * 0x1p64 + double(m.limb[size_t(top - 1)]), v = std::ldexp(v, 64 * (top - 1));
    return negative ? -v : v;
  }
};

}  // namespace limberg
