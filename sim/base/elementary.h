#pragma once
// Elementary functions that give the same bits on every machine.
//
// A C library chooses its code by the processor (glibc has two exp, sin, pow ..., with and without fused multiply-add,
// and they differ in the last bit). These use +, -, *, / and square roots only, in one order; the build forbids
// contraction (-ffp-contract=off). All of sim/ calls these; std::sqrt, fmod, remainder, floor and the like are exact
// everywhere.
//
// Errors in units in the last place (tests/sim/base): 1 for exp, log, sin, cos and cbrt, 2 for hypot and log10, 3 for
// tan, atan and atan2, 4 for asin, acos, expm1 and tanh; pow loses 2 more for every unit of |y ln x|. sin, cos and tan
// up to |x| = 1e6; beyond, their period is that of 2 pi as a double. Special values as in C.
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

namespace limberg::elementary {

inline constexpr double pi = 3.141592653589793238;

namespace parts {

// ln 2 and pi / 2 in pieces of 33 bits, so that small multiples of all but the last are exact.
inline constexpr double ln2_high = 0x1.62e42fef00000p-1, ln2_low = 0x1.473de6af278edp-34;
inline constexpr double quarter_high = 0x1.921fb54400000p+0, quarter_mid = 0x1.0b4611a600000p-34,
                        quarter_low = 0x1.3198a2e037073p-69;

/// 2^k for -1022 <= k <= 1023.
inline double power_of_two(int k) { return std::bit_cast<double>(uint64_t(k + 1023) << 52); }

/// sum_{k >= from} r^(k - from) from! / k! of so many terms: e^r and what is left of it without its first terms.
template <int from, int to>
double exponential_series(double r) {
  double s = 1;
  for (int k = to; k > from; --k) s = 1 + s * r / double(k);
  return s;
}

/// x = quadrant pi/2 + high + low, |high| <= pi/4.
struct Reduced {
  double high, low;
  int quadrant;  // 0 .. 3
};
inline Reduced reduce(double x) {
  if (std::abs(x) > 1e6) x = std::remainder(x, 2 * pi);
  const double k = std::nearbyint(x * 0x1.45f306dc9c883p-1);
  const double a = x - k * quarter_high, b = k * quarter_mid, c = a - b;  // a and b are exact
  const double back = c - a, lost = (a - (c - back)) - (b + back);        // a - b = c + lost
  const double d = lost - k * quarter_low;
  const double high = c + d;
  return {high, (c - high) + d, int(int64_t(k) & 3)};
}
inline double sine(double r, double low) {
  const double q = r * r;
  double s = 0;
  for (int k = 17; k >= 3; k -= 2) s = (1 - s) * q / double(k * (k - 1));
  return r - (r * s - low * (1 - 0.5 * q));
}
inline double cosine(double r, double low) {
  const double q = r * r, half = 0.5 * q;
  double s = 0;
  for (int k = 18; k >= 4; k -= 2) s = (1 - s) * q / double(k * (k - 1));
  const double one = 1 - half;  // its rounding is taken back
  return one + (((1 - one) - half) + (half * s - r * low));
}

}  // namespace parts

inline double exp(double x) {
  if (x != x) return x;
  if (x > 709.8) return std::numeric_limits<double>::infinity();
  if (x < -745.2) return 0;
  const double k = std::nearbyint(x * 0x1.71547652b82fep+0);
  const double high = x - k * parts::ln2_high, low = k * parts::ln2_low, r = high - low;
  const double lost = (high - r) - low;
  const double value = 1 + (r + (lost + 0.5 * r * r * parts::exponential_series<2, 14>(r)));
  const int whole = int(k), half = whole / 2;  // two factors: neither is out of range where the result is not
  return value * parts::power_of_two(half) * parts::power_of_two(whole - half);
}

/// e^x - 1.
inline double expm1(double x) {
  if (std::abs(x) < 0.35) return x * parts::exponential_series<1, 15>(x);
  return exp(x) - 1;
}

inline double log(double x) {
  if (!(x > 0) || x == std::numeric_limits<double>::infinity())
    return x == 0 ? -std::numeric_limits<double>::infinity() : x > 0 ? x : std::numeric_limits<double>::quiet_NaN();
  int e = 0;
  if (x < 0x1p-1022) x *= 0x1p54, e = -54;
  const uint64_t bits = std::bit_cast<uint64_t>(x);
  e += int(bits >> 52) - 1023;
  double m = std::bit_cast<double>((bits & 0x000fffffffffffffULL) | 0x3ff0000000000000ULL);
  if (m > 1.4142135623730951) m *= 0.5, ++e;
  // ln m = 2 artanh r = f - r (f - q s) with f = m - 1, r = f / (2 + f), q = r^2: what is rounded is small.
  const double f = m - 1, r = f / (2 + f), q = r * r;
  double s = 0;
  for (int k = 25; k >= 3; k -= 2) s = q * (s + 2.0 / double(k));
  const double half = 0.5 * f * f;
  return e * parts::ln2_high - ((half - (r * (half + s) + e * parts::ln2_low)) - f);
}
inline double log10(double x) { return log(x) * 0x1.bcb7b1526e50ep-2; }

/// x^y. Whole y up to 64 are multiplied out, so x may be negative there.
inline double pow(double x, double y) {
  if (y == std::trunc(y) && std::abs(y) <= 64) {
    double p = 1, base = x;
    for (unsigned n = unsigned(std::abs(y)); n; n >>= 1, base *= base)
      if (n & 1) p *= base;
    return y < 0 ? 1 / p : p;
  }
  if (x == 0) return y > 0 ? 0 : y < 0 ? std::numeric_limits<double>::infinity() : y;
  return exp(y * log(x));
}

inline double sin(double x) {
  if (!std::isfinite(x)) return std::numeric_limits<double>::quiet_NaN();
  const parts::Reduced r = parts::reduce(x);
  const double s = r.quadrant & 1 ? parts::cosine(r.high, r.low) : parts::sine(r.high, r.low);
  return r.quadrant & 2 ? -s : s;
}
inline double cos(double x) {
  if (!std::isfinite(x)) return std::numeric_limits<double>::quiet_NaN();
  const parts::Reduced r = parts::reduce(x);
  const double c = r.quadrant & 1 ? parts::sine(r.high, r.low) : parts::cosine(r.high, r.low);
  return r.quadrant == 1 || r.quadrant == 2 ? -c : c;
}
inline double tan(double x) { return sin(x) / cos(x); }

inline double atan(double x) {
  static constexpr double high[9] = {0,
                                     0x1.fd5ba9aac2f6ep-4,
                                     0x1.f5b75f92c80ddp-3,
                                     0x1.6f61941e4def1p-2,
                                     0x1.dac670561bb4fp-2,
                                     0x1.1e00babdefeb4p-1,
                                     0x1.4978fa3269ee1p-1,
                                     0x1.700a7c5784634p-1,
                                     0x1.921fb54442d18p-1};
  static constexpr double low[9] = {0,
                                    -0x1.cd37686760c17p-59,
                                    0x1.8ab6e3cf7afbdp-57,
                                    -0x1.c63aae6f6e918p-56,
                                    0x1.a2b7f222f65e2p-56,
                                    -0x1.928df287a668fp-58,
                                    0x1.2419a87f2a458p-56,
                                    -0x1.8c34d25aadef6p-56,
                                    0x1.1a62633145c07p-55};
  if (x != x) return x;
  const double size = std::abs(x);
  const bool steep = size > 1;
  const double a = steep ? 1 / size : size;
  const int k = int(8 * a + 0.5);  // arctan a = arctan(k/8) + arctan t, |t| <= 1/16
  const double c = 0.125 * k, t = steep ? (1 - c * size) / (size + c) : (a - c) / (1 + a * c), q = t * t;
  double s = 0;
  for (int n = 15; n >= 3; n -= 2) s = q * (1.0 / double(n) - s);
  const double rest = low[k] + (t - t * s);
  const double value = steep ? 0x1.921fb54442d18p+0 - (high[k] - (0x1.1a62633145c07p-54 - rest)) : high[k] + rest;
  return std::copysign(value, x);
}

inline double atan2(double y, double x) {
  if (x != x || y != y) return x + y;
  const double ax = std::abs(x), ay = std::abs(y);
  double a;
  if (ay == 0)
    a = std::signbit(x) ? pi : 0;
  else if (ax == ay)
    a = std::signbit(x) ? 0.75 * pi : 0.25 * pi;
  else if (ax == 0 || std::isinf(ay))
    a = 0.5 * pi;
  else
    a = std::signbit(x) ? pi - (atan(ay / ax) - 0x1.1a62633145c07p-53) : atan(ay / ax);
  return std::copysign(a, y);
}

inline double asin(double x) { return atan2(x, std::sqrt((1 - x) * (1 + x))); }
inline double acos(double x) { return atan2(std::sqrt((1 - x) * (1 + x)), x); }

inline double tanh(double x) {
  const double size = std::abs(x);
  if (size > 20) return std::copysign(1.0, x);
  const double e = expm1(2 * size);
  return std::copysign(e / (e + 2), x);
}

/// Cubes of doubles with 17 bits come back exactly.
inline double cbrt(double x) {
  if (x == 0 || !std::isfinite(x)) return x;
  int e = 0;
  double m = std::frexp(std::abs(x), &e);  // [1/2, 1)
  const int third = (e >= 0 ? e + 2 : e) / 3;
  m = std::ldexp(m, e - 3 * third);  // [1/8, 1)
  double y = 0.32 + m * (1.06 - 0.38 * m);
  for (int i = 0; i < 5; ++i) y -= (y * y * y - m) / (3 * y * y);
  return std::copysign(std::ldexp(y, third), x);
}

inline double hypot(double x, double y) {
  const double ax = std::abs(x), ay = std::abs(y), h = ax > ay ? ax : ay, l = ax > ay ? ay : ax;
  if (std::isinf(x) || std::isinf(y)) return std::numeric_limits<double>::infinity();
  if (h > 1e-140 && h < 1e140) return std::sqrt(x * x + y * y);
  return h == 0 ? 0 : h * std::sqrt(1 + (l / h) * (l / h)) + (x - x) + (y - y);
}

inline double hypot(double x, double y, double z) { return hypot(hypot(x, y), z); }

}  // namespace limberg::elementary
