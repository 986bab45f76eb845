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

#ifdef __clang__  // knows shuffles by constants only: the same elements in the same order, found out by its optimiser
template <class V, class Mask>
LIMBERG_INLINE V shuffled(V a, V b, Mask m) {
  constexpr auto n = int(sizeof(V) / sizeof(a[0]));
  V r = a;
  for (int k = 0; k < n; ++k) {
    const auto from = int(m[k]) & (2 * n - 1);
    r[k] = from < n ? a[from] : b[from - n];
  }
  return r;
}
template <class V, class Mask>
LIMBERG_INLINE V shuffled(V a, Mask m) {
  return shuffled(a, a, m);
}
#define __builtin_shuffle shuffled
#endif

/// One register: `parts` of them hold sixteen floats.
#if LIMBERG_LANES == 512
typedef float part __attribute__((vector_size(64)));
typedef int32_t parti __attribute__((vector_size(64)));
#define LIMBERG_SHUFFLE(a, b, i, j, k, l)                                                                      \
  __builtin_shuffle(a, b,                                                                                      \
                    (parti{i, j, k, l, (i) + 4, (j) + 4, (k) + 4, (l) + 4, (i) + 8, (j) + 8, (k) + 8, (l) + 8, \
                           (i) + 12, (j) + 12, (k) + 12, (l) + 12}))
#elif LIMBERG_LANES == 256
typedef float part __attribute__((vector_size(32)));
typedef int32_t parti __attribute__((vector_size(32)));
#define LIMBERG_SHUFFLE(a, b, i, j, k, l) \
  __builtin_shuffle(a, b, (parti{i, j, k, l, (i) + 4, (j) + 4, (k) + 4, (l) + 4}))
#else
typedef v4 part;
typedef v4i parti;
#define LIMBERG_SHUFFLE(a, b, i, j, k, l) __builtin_shuffle(a, b, (parti{i, j, k, l}))
#endif
constexpr int part_lanes = int(sizeof(part) / sizeof(float)), parts = 16 / part_lanes;

/// In every 128-bit lane a transposition of four by four: r[k] holds element k of x, y, z and w of that lane.
LIMBERG_INLINE void to_rows(part x, part y, part z, part w, part r[4]) {
  constexpr int B = part_lanes;  // where the numbers of a shuffle's second vector begin
  const part a = LIMBERG_SHUFFLE(x, y, 0, B, 1, B + 1), b = LIMBERG_SHUFFLE(x, y, 2, B + 2, 3, B + 3);
  const part c = LIMBERG_SHUFFLE(z, w, 0, B, 1, B + 1), d = LIMBERG_SHUFFLE(z, w, 2, B + 2, 3, B + 3);
  r[0] = LIMBERG_SHUFFLE(a, c, 0, 1, B, B + 1), r[1] = LIMBERG_SHUFFLE(a, c, 2, 3, B + 2, B + 3);
  r[2] = LIMBERG_SHUFFLE(b, d, 0, 1, B, B + 1), r[3] = LIMBERG_SHUFFLE(b, d, 2, 3, B + 2, B + 3);
}
/// The inverse, without the fourth.
LIMBERG_INLINE void from_rows(const part r[4], part& x, part& y, part& z) {
  constexpr int B = part_lanes;
  const part a = LIMBERG_SHUFFLE(r[0], r[1], 0, B, 1, B + 1), b = LIMBERG_SHUFFLE(r[2], r[3], 0, B, 1, B + 1);
  const part c = LIMBERG_SHUFFLE(r[0], r[1], 2, B + 2, 3, B + 3), d = LIMBERG_SHUFFLE(r[2], r[3], 2, B + 2, 3, B + 3);
  x = LIMBERG_SHUFFLE(a, b, 0, 1, B, B + 1), y = LIMBERG_SHUFFLE(a, b, 2, 3, B + 2, B + 3);
  z = LIMBERG_SHUFFLE(c, d, 0, 1, B, B + 1);
}

#if LIMBERG_LANES == 512

typedef part v16;

LIMBERG_INLINE v16 get(const void* p) { return (v16)_mm512_loadu_ps(p); }
LIMBERG_INLINE void put(void* p, v16 v) { _mm512_storeu_ps(p, (__m512)v); }
/// The same four numbers in every 128-bit lane.
LIMBERG_INLINE v16 in_every_lane(const void* four) {
  return (v16)_mm512_broadcast_f32x4(_mm_loadu_ps(static_cast<const float*>(four)));
}
/// Each of four numbers in all of its lane.
LIMBERG_INLINE v16 spread(const float* four) {
  const parti lanes = {0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3};
  return __builtin_shuffle((v16)_mm512_castps128_ps512(_mm_loadu_ps(four)), lanes);
}
/// Three vectors of 16 numbers (x, y, z of 16 rows) to four
/// vectors whose 128-bit lane l holds row 4*l + k as (x,y,z,0).
LIMBERG_INLINE void to_rows(v16 x, v16 y, v16 z, v16 r[4]) { to_rows(x, y, z, v16{}, r); }

#else

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
LIMBERG_INLINE void to_rows(v16 x, v16 y, v16 z, v16 r[4]) {
  for (int i = 0; i < parts; ++i) {
    part t[4];
    to_rows(x.p[i], y.p[i], z.p[i], part{}, t);
    for (int k = 0; k < 4; ++k) r[k].p[i] = t[k];
  }
}
LIMBERG_INLINE void from_rows(const v16 r[4], v16& x, v16& y, v16& z) {
  for (int i = 0; i < parts; ++i) {
    const part t[4] = {r[0].p[i], r[1].p[i], r[2].p[i], r[3].p[i]};
    from_rows(t, x.p[i], y.p[i], z.p[i]);
  }
}

#endif

/// The sum of sixteen numbers in double, folded in halves: 8 and 8, 4 and 4, 2 and 2, 1 and 1.
LIMBERG_INLINE double sum(v16 v) {
  float f[16];
  __builtin_memcpy(f, &v, 64);
  double s[8];
  for (int i = 0; i < 8; ++i) s[i] = double(f[i]) + double(f[i + 8]);
  return ((s[0] + s[4]) + (s[2] + s[6])) + ((s[1] + s[5]) + (s[3] + s[7]));
}

}  // namespace limberg::fem::LIMBERG_SET
