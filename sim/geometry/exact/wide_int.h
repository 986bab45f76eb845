#pragma once
// Signed integers of fixed width: what every exact sign is computed with. No allocation, no rounding, no overflow
// check: the callers state their bit budgets (predicates.h) and tests assert them.
//
// WideInt<N> holds 64*N bits in two's complement, least significant limb first. Arithmetic is modulo 2^(64 N), so a
// result is right whenever it fits.
#include <array>
#include <cstdint>

namespace limberg {

__extension__ typedef __int128 int128;
__extension__ typedef unsigned __int128 uint128;

template <int N>
struct WideInt {
  std::array<uint64_t, N> limb{};

  constexpr WideInt() = default;
  constexpr WideInt(int64_t v) {  // NOLINT: implicit on purpose, as for built-in integers
    limb[0] = uint64_t(v);
    for (int i = 1; i < N; ++i) limb[i] = v < 0 ? ~uint64_t(0) : 0;
  }
  constexpr explicit WideInt(int128 v) {
    static_assert(N >= 2);
    limb[0] = uint64_t(v);
    limb[1] = uint64_t(v >> 64);
    for (int i = 2; i < N; ++i) limb[i] = v < 0 ? ~uint64_t(0) : 0;
  }
  /// Widens (sign kept) or narrows (the value must fit).
  template <int M>
  constexpr explicit WideInt(const WideInt<M>& v) {
    const uint64_t fill = v.sign() < 0 ? ~uint64_t(0) : 0;
    for (int i = 0; i < N; ++i) limb[i] = i < M ? v.limb[i] : fill;
  }

  constexpr bool negative() const { return int64_t(limb[N - 1]) < 0; }
  /// -1, 0 or +1.
  constexpr int sign() const {
    if (negative()) return -1;
    for (uint64_t l : limb)
      if (l != 0) return 1;
    return 0;
  }
  /// Bits of the magnitude: 0 for 0, 1 for 1, 8 for 255.
  constexpr int bit_length() const {
    const WideInt m = negative() ? -*this : *this;
    for (int i = N - 1; i >= 0; --i)
      if (m.limb[i] != 0) return 64 * i + 64 - __builtin_clzll(m.limb[i]);
    return 0;
  }
  /// Nearest-ish double: relative error at most 2^-52 (the limbs are rounded one by one).
  double to_double() const {
    static_assert(N <= 8);
    constexpr std::array<double, 8> kPower{1, 0x1p64, 0x1p128, 0x1p192, 0x1p256, 0x1p320, 0x1p384, 0x1p448};
    const WideInt m = negative() ? -*this : *this;
    double r = 0;
    for (int i = N - 1; i >= 0; --i)
      if (m.limb[i] != 0) {
        // The two highest limbs carry at least 65 bits; what lies below is less than 2^-64 of the value.
        r = double(m.limb[i]) * kPower[unsigned(i)];  // powers of two: no rounding
        if (i > 0) r += double(m.limb[i - 1]) * kPower[unsigned(i - 1)];
        break;
      }
    return negative() ? -r : r;
  }
  /// The value modulo a prime below 2^61 (Mersenne 2^61 - 1 in practice), in [0, p).
  constexpr uint64_t mod(uint64_t p) const {
    const WideInt m = negative() ? -*this : *this;
    uint64_t r = 0;
    for (int i = N - 1; i >= 0; --i) r = uint64_t(((uint128(r) << 64) | m.limb[i]) % p);
    return negative() && r != 0 ? p - r : r;
  }

  constexpr WideInt operator-() const {
    WideInt r;
    uint64_t carry = 1;
    for (int i = 0; i < N; ++i) {
      r.limb[i] = ~limb[i] + carry;
      carry = carry != 0 && r.limb[i] == 0;
    }
    return r;
  }
  constexpr WideInt& operator+=(const WideInt& b) {
    uint64_t carry = 0;
    for (int i = 0; i < N; ++i) {
      const uint128 s = uint128(limb[i]) + b.limb[i] + carry;
      limb[i] = uint64_t(s);
      carry = uint64_t(s >> 64);
    }
    return *this;
  }
  constexpr WideInt& operator-=(const WideInt& b) {
    uint64_t borrow = 0;
    for (int i = 0; i < N; ++i) {
      const uint128 s = uint128(limb[i]) - b.limb[i] - borrow;
      limb[i] = uint64_t(s);
      borrow = uint64_t(s >> 64) & 1;
    }
    return *this;
  }
  friend constexpr WideInt operator+(WideInt a, const WideInt& b) { return a += b; }
  friend constexpr WideInt operator-(WideInt a, const WideInt& b) { return a -= b; }
  friend constexpr WideInt operator*(const WideInt& a, const WideInt& b) { return multiply<N>(a, b); }
  friend constexpr bool operator==(const WideInt&, const WideInt&) = default;
  friend constexpr bool operator<(const WideInt& a, const WideInt& b) { return (a - b).sign() < 0; }
};

/// The product in 64*R bits, right whenever it fits. Factors may be narrower than the result.
template <int R, int A, int B>
constexpr WideInt<R> multiply(const WideInt<A>& a, const WideInt<B>& b) {
  // Magnitudes are multiplied; two's complement would need every operand widened to R limbs first.
  const bool na = a.negative(), nb = b.negative();
  const WideInt<A> ma = na ? -a : a;
  const WideInt<B> mb = nb ? -b : b;
  WideInt<R> r;
  for (int i = 0; i < A && i < R; ++i) {
    if (ma.limb[i] == 0) continue;
    uint64_t carry = 0;
    for (int j = 0; i + j < R; ++j) {
      if (j >= B && carry == 0) break;
      const uint128 s = uint128(ma.limb[i]) * (j < B ? mb.limb[j] : 0) + r.limb[i + j] + carry;
      r.limb[i + j] = uint64_t(s);
      carry = uint64_t(s >> 64);
    }
  }
  return na != nb ? -r : r;
}

using Int256 = WideInt<4>;
using Int512 = WideInt<8>;

constexpr int sign_of(int128 v) { return v > 0 ? 1 : v < 0 ? -1 : 0; }

}  // namespace limberg
