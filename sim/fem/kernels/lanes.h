#pragma once
// Sixteen floats at a time, for the kernels only: one register of AVX-512, two of AVX2, four
// of SSE2 or what the compiler makes of vectors elsewhere. Every kernel source is compiled
// once per LIMBERG_LANES (128, 256, 512 bits) into a namespace of that name; whatever is
// inline here must be inlined, so that no linker can put one set's code into another's place.
#include "sim/base/node4.h"
#if LIMBERG_LANES > 128
#include <immintrin.h>
#endif

#if LIMBERG_LANES == 512
#define LIMBERG_SET avx512
#elif LIMBERG_LANES == 256
#define LIMBERG_SET avx2
#else
#define LIMBERG_SET plain
#endif
#define LIMBERG_INLINE [[gnu::always_inline]] inline

namespace limberg::fem::LIMBERG_SET {

typedef double v8d __attribute__((vector_size(64)));

#if LIMBERG_LANES == 512

typedef float v16 __attribute__((vector_size(64)));
typedef int32_t v16i __attribute__((vector_size(64)));

LIMBERG_INLINE v16 get(const void* p) { return (v16)_mm512_loadu_ps(p); }
LIMBERG_INLINE void put(void* p, v16 v) { _mm512_storeu_ps(p, (__m512)v); }
/// The same four numbers in every 128-bit lane.
LIMBERG_INLINE v16 in_every_lane(const void* four) {
  return (v16)_mm512_broadcast_f32x4(_mm_loadu_ps(static_cast<const float*>(four)));
}
/// Each of four numbers in all of its lane.
LIMBERG_INLINE v16 spread(const float* four) {
  const v16i lanes = {0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3};
  return __builtin_shuffle((v16)_mm512_castps128_ps512(_mm_loadu_ps(four)), lanes);
}
LIMBERG_INLINE double sum(v16 v) {
  const v8d s = (v8d)_mm512_cvtps_pd(_mm512_castps512_ps256((__m512)v)) +
                (v8d)_mm512_cvtps_pd(_mm512_extractf32x8_ps((__m512)v, 1));
  const __m256d t = _mm256_add_pd(_mm512_castpd512_pd256((__m512d)s), _mm512_extractf64x4_pd((__m512d)s, 1));
  const __m128d r = _mm_add_pd(_mm256_castpd256_pd128(t), _mm256_extractf128_pd(t, 1));
  return _mm_cvtsd_f64(r) + _mm_cvtsd_f64(_mm_unpackhi_pd(r, r));
}
/// Three vectors of 16 numbers (x, y, z of 16 rows) to four
/// vectors whose 128-bit lane l holds row 4*l + k as (x,y,z,0).
LIMBERG_INLINE void to_rows(v16 x, v16 y, v16 z, v16 r[4]) {
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
LIMBERG_INLINE void from_rows(const v16 r[4], v16& x, v16& y, v16& z) {
  const v16i lo = {0, 16, 1, 17, 4, 20, 5, 21, 8, 24, 9, 25, 12, 28, 13, 29};
  const v16i hi = {2, 18, 3, 19, 6, 22, 7, 23, 10, 26, 11, 27, 14, 30, 15, 31};
  const v16i first = {0, 1, 16, 17, 4, 5, 20, 21, 8, 9, 24, 25, 12, 13, 28, 29};
  const v16i second = {2, 3, 18, 19, 6, 7, 22, 23, 10, 11, 26, 27, 14, 15, 30, 31};
  const v16 a = __builtin_shuffle(r[0], r[1], lo), b = __builtin_shuffle(r[2], r[3], lo);
  const v16 c = __builtin_shuffle(r[0], r[1], hi), d = __builtin_shuffle(r[2], r[3], hi);
  x = __builtin_shuffle(a, b, first), y = __builtin_shuffle(a, b, second);
  z = __builtin_shuffle(c, d, first);
}

#else

#if LIMBERG_LANES == 256
typedef float part __attribute__((vector_size(32)));
typedef int32_t parti __attribute__((vector_size(32)));
#define LIMBERG_SHUFFLE(a, b, i, j, k, l) \
  __builtin_shuffle(a, b, (parti{i, j, k, l, (i) + 4, (j) + 4, (k) + 4, (l) + 4}))
constexpr int from_second = 8;  // where the numbers of a shuffle's second vector begin
#else
typedef v4 part;
typedef v4i parti;
#define LIMBERG_SHUFFLE(a, b, i, j, k, l) __builtin_shuffle(a, b, (parti{i, j, k, l}))
constexpr int from_second = 4;
#endif
constexpr int parts = int(64 / sizeof(part));

struct alignas(64) v16 {
  part p[parts];
};

LIMBERG_INLINE v16 operator+(v16 a, v16 b) {
  for (int i = 0; i < parts; ++i) a.p[i] = a.p[i] + b.p[i];
  return a;
}
LIMBERG_INLINE v16 operator-(v16 a, v16 b) {
  for (int i = 0; i < parts; ++i) a.p[i] = a.p[i] - b.p[i];
  return a;
}
LIMBERG_INLINE v16 operator*(v16 a, v16 b) {
  for (int i = 0; i < parts; ++i) a.p[i] = a.p[i] * b.p[i];
  return a;
}
LIMBERG_INLINE v16 operator*(v16 a, float s) {
  for (int i = 0; i < parts; ++i) a.p[i] = a.p[i] * s;
  return a;
}
LIMBERG_INLINE v16 operator*(float s, v16 a) { return a * s; }
LIMBERG_INLINE v16& operator+=(v16& a, v16 b) { return a = a + b; }
LIMBERG_INLINE v16& operator-=(v16& a, v16 b) { return a = a - b; }

typedef part loose __attribute__((aligned(4)));
LIMBERG_INLINE v16 get(const void* p) {
  v16 v;
  for (int i = 0; i < parts; ++i) v.p[i] = static_cast<const loose*>(p)[i];
  return v;
}
LIMBERG_INLINE void put(void* p, v16 v) {
  for (int i = 0; i < parts; ++i) static_cast<loose*>(p)[i] = v.p[i];
}
LIMBERG_INLINE v16 in_every_lane(const void* four) {
  typedef v4 loose4 __attribute__((aligned(4)));
  const v4 f = *static_cast<const loose4*>(four);
  v16 v;
#if LIMBERG_LANES == 256
  for (int i = 0; i < parts; ++i) v.p[i] = (part)_mm256_set_m128((__m128)f, (__m128)f);
#else
  for (int i = 0; i < parts; ++i) v.p[i] = f;
#endif
  return v;
}
LIMBERG_INLINE v16 spread(const float* four) {
  v16 v;
#if LIMBERG_LANES == 256
  const part both = (part)_mm256_broadcast_ps(reinterpret_cast<const __m128*>(four));
  v.p[0] = (part)_mm256_permutevar_ps((__m256)both, _mm256_setr_epi32(0, 0, 0, 0, 1, 1, 1, 1));
  v.p[1] = (part)_mm256_permutevar_ps((__m256)both, _mm256_setr_epi32(2, 2, 2, 2, 3, 3, 3, 3));
#else
  for (int i = 0; i < parts; ++i) v.p[i] = v4{four[i], four[i], four[i], four[i]};
#endif
  return v;
}
LIMBERG_INLINE double sum(v16 v) {
  double s = 0;
  for (int i = 0; i < parts; ++i)
    for (int k = 0; k < int(sizeof(part) / 4); ++k) s += double(v.p[i][k]);
  return s;
}
// In every 128-bit lane a transposition of four by four, so wider registers need no other code.
LIMBERG_INLINE void to_rows(v16 x, v16 y, v16 z, v16 r[4]) {
  constexpr int B = from_second;
  const part o = {};
  for (int i = 0; i < parts; ++i) {
    const part a = LIMBERG_SHUFFLE(x.p[i], y.p[i], 0, B, 1, B + 1),
               b = LIMBERG_SHUFFLE(x.p[i], y.p[i], 2, B + 2, 3, B + 3);
    const part c = LIMBERG_SHUFFLE(z.p[i], o, 0, B, 1, B + 1), d = LIMBERG_SHUFFLE(z.p[i], o, 2, B + 2, 3, B + 3);
    r[0].p[i] = LIMBERG_SHUFFLE(a, c, 0, 1, B, B + 1), r[1].p[i] = LIMBERG_SHUFFLE(a, c, 2, 3, B + 2, B + 3);
    r[2].p[i] = LIMBERG_SHUFFLE(b, d, 0, 1, B, B + 1), r[3].p[i] = LIMBERG_SHUFFLE(b, d, 2, 3, B + 2, B + 3);
  }
}
LIMBERG_INLINE void from_rows(const v16 r[4], v16& x, v16& y, v16& z) {
  constexpr int B = from_second;
  for (int i = 0; i < parts; ++i) {
    const part a = LIMBERG_SHUFFLE(r[0].p[i], r[1].p[i], 0, B, 1, B + 1),
               b = LIMBERG_SHUFFLE(r[2].p[i], r[3].p[i], 0, B, 1, B + 1);
    const part c = LIMBERG_SHUFFLE(r[0].p[i], r[1].p[i], 2, B + 2, 3, B + 3),
               d = LIMBERG_SHUFFLE(r[2].p[i], r[3].p[i], 2, B + 2, 3, B + 3);
    x.p[i] = LIMBERG_SHUFFLE(a, b, 0, 1, B, B + 1), y.p[i] = LIMBERG_SHUFFLE(a, b, 2, 3, B + 2, B + 3);
    z.p[i] = LIMBERG_SHUFFLE(c, d, 0, 1, B, B + 1);
  }
}

#endif

}  // namespace limberg::fem::LIMBERG_SET
